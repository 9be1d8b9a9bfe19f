// SPDX-License-Identifier: Apache-2.0

// What the module plumb_formats has: formats other than EXR, by OpenImageIO. That starts 250
// libraries, so that the module is loaded when it is needed.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "images/provenance_attributes.h"
#include "images/stored_image.h"

namespace plumb {

struct OtherFormats {
  // `format` as a file's extension names it; the part by its name or number, empty for the first.
  // Throws ImageError.
  StoredImage (*read)(const std::filesystem::path& file, const std::string& format,
                      const std::string& part);

  // Of three sRGB codes per pixel. The name of the file is for messages. Throws ImageError.
  std::vector<unsigned char> (*encode_png)(int width, int height,
                                           const std::vector<unsigned char>& codes,
                                           const Attributes& attributes,
                                           const std::filesystem::path& file);
};

}  // namespace plumb

// What the module exports.
extern "C" const plumb::OtherFormats plumb_other_formats;
