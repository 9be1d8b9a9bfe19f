// SPDX-License-Identifier: Apache-2.0

// Refractive indices by the names that Mitsuba 3 knows.
#pragma once

#include <optional>
#include <string>
#include <utility>

#include "scene/scene.h"

namespace plumb {

// Of what is transparent, in vacuum, such as "water". Upper and lower case are the same.
std::optional<double> refractive_index(const std::string& name);

// Eta and k of a metal, such as "Au", in linear RGB. A name may end with "_palik"
// where Mitsuba knows it so.
std::optional<std::pair<Rgb, Rgb>> complex_refractive_index(const std::string& name);

// "air, water, ...", for messages.
std::string names_of_transparent();
std::string names_of_metals();

}  // namespace plumb
