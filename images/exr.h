// SPDX-License-Identifier: Apache-2.0

// EXR files, by OpenEXR, on all cores.
#pragma once

#include <filesystem>
#include <string>

#include "images/stored_image.h"

namespace plumb {

// A file of float32 channels with the image's windows and provenance.
std::string encode_exr(const Image& image);

// A part by its name or number; empty for the first one. Without pixels, the image has no values.
// Throws ImageError.
StoredImage read_exr(const std::filesystem::path& file, const std::string& part,
                     bool has_pixels = true);

}  // namespace plumb
