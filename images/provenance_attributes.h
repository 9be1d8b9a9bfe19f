// SPDX-License-Identifier: Apache-2.0

// Provenance as attributes of an image file, named "plumbline:sceneHash" and so on.
#pragma once

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "images/provenance.h"

namespace plumb {

using Attributes = std::vector<std::pair<std::string, std::variant<std::string, int, double>>>;

// The fields that are set, in their order.
Attributes to_attributes(const Provenance& provenance);

// Leaves out what is missing or is of another type.
Provenance to_provenance(const Attributes& attributes);

}  // namespace plumb
