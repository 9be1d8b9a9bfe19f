// SPDX-License-Identifier: Apache-2.0

// What whoever looks into a bug asks first.
#pragma once

#include <string>

namespace plumb::cli {

// Version and commit, compiler, processor, libraries, and the programs that are found, a line each.
// Starts each of these programs, which takes seconds.
std::string bug_report();

}  // namespace plumb::cli
