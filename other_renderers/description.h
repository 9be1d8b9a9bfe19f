// SPDX-License-Identifier: Apache-2.0

// Anybody's renderer, described in a file: how it is called, what it can and what its picture
// means. docs/renderers.md lists the keys.
#pragma once

#include <filesystem>

#include "other_renderers/other_renderer.h"

namespace plumb {

// Reads a description, in TOML. Its word is the file's name without folder and extension. Throws
// std::invalid_argument, with the place, for what is no TOML, for unknown keys and placeholders and
// for those that are missing; std::runtime_error if there is no such file.
OtherRenderer read_description(const std::filesystem::path& file);

}  // namespace plumb
