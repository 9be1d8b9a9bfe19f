// SPDX-License-Identifier: Apache-2.0

#include "cli/outputs.h"

#include <fmt/format.h>

#include <algorithm>

#include "cli/commands.h"
#include "cli/names.h"

namespace plumb::cli {

void add_output_option(CLI::App& command, Outputs& outputs) {
  add_option(command, "-o,--output", "FILE", outputs.files,
             "Linear .exr or sRGB .png; can be repeated")
      ->required()
      ->allow_extra_args(false);
}

void add_exposure_option(CLI::App& command, Outputs& outputs) {
  add_option(command, "--exposure", "EV", outputs.exposure, number(-100.0, 100.0),
             "Brighten the .png by so many stops (default: 0)");
}

void check(const Outputs& outputs) {
  for (const std::string& file : outputs.files) {
    image_format(file);
    check_writable(file);
    if (std::ranges::count(outputs.files, file) > 1) {
      throw ImageError(fmt::format("--output: {} is given twice", file));
    }
  }
}

void write(const Image& image, const Outputs& outputs) {
  for (const std::string& file : outputs.files) {
    write_image(image, file, outputs.exposure);
    fmt::print("wrote {}\n", file);
  }
}

}  // namespace plumb::cli
