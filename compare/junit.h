// SPDX-License-Identifier: Apache-2.0

// A gate's outcome as CI servers read it.
#pragma once

#include <string>
#include <vector>

#include "compare/gate.h"

namespace plumb {

// JUnit's XML: a test case for each entry. One that did not end as expected is an error if it was
// trouble, else a failure.
std::string to_junit(const std::vector<GateEntry>& entries);

}  // namespace plumb
