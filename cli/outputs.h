// SPDX-License-Identifier: Apache-2.0

// What commands that make a picture have in common.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "images/image.h"

namespace plumb::cli {

struct Outputs {
  std::vector<std::string> files;
  double exposure = 0.0;
};

void add_output_option(CLI::App& command, Outputs& outputs);    // -o, --output
void add_exposure_option(CLI::App& command, Outputs& outputs);  // --exposure

// Throws ImageError for what can't be written, or is given twice.
void check(const Outputs& outputs);

// Writes the picture into all files, and says so. Throws as write_image() does.
void write(const Image& image, const Outputs& outputs);

}  // namespace plumb::cli
