// SPDX-License-Identifier: Apache-2.0

// A picture by radiosity from what is asked for, for `plumb radiosity` and for scripts.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "cli/scene_options.h"
#include "images/image.h"
#include "radiosity/radiosity.h"

namespace plumb::cli {

struct RadiosityOptions {
  SceneOptions scene;
  bool is_constant = false;  // elements
  double error = 0.0;
  int threads = 0;
};

struct RadiosityDrawing {
  std::optional<Image> image;  // with its provenance, which tells how wrong it may be
  std::string summary;         // of the image, a line
  std::string why_ended;       // before the wanted error was reached; else empty
};

void add_radiosity_options(CLI::App& command, RadiosityOptions& options);  // all but SCENE

size_t half_of_the_memory();

// Draws the scene, which adjust() has made what the options say. Throws as radiosity::draw() does.
RadiosityDrawing draw(const Scene& scene, const RadiosityOptions& options,
                      const radiosity::Work& work);

}  // namespace plumb::cli
