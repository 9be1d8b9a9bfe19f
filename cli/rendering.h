// SPDX-License-Identifier: Apache-2.0

// A render from what is asked for to the picture, for `plumb render` and for scripts.
#pragma once

#include <CLI/CLI.hpp>
#include <atomic>
#include <cstdint>
#include <optional>
#include <string>

#include "cli/scene_options.h"
#include "faults/faults.h"
#include "images/image.h"
#include "renderer/render.h"

namespace plumb::cli {

// What is not said is chosen to fit the scene.
struct RenderOptions {
  SceneOptions scene;
  Settings settings{.seed = 1, .bounces = {}};
  Limits limits;
  std::optional<int64_t> spp;
  std::optional<SampleRange> samples;
  std::optional<Window> crop;
  Fault fault = Fault::none;
  std::optional<Method> method;
  std::optional<Sampler> sampler;
  std::optional<Precision> precision;
};

struct Rendering {
  std::optional<Image> image;  // with its noise and provenance; none if no pass was finished
  Cost cost;
  int64_t samples_per_pixel = 0;
  double relative_error = 0.0;
};

void add_render_options(CLI::App& command, RenderOptions& options);  // all but SCENE

// Renders the scene, which adjust() has made what the options say. Throws std::invalid_argument for
// options that contradict each other or the scene.
Rendering draw(Scene scene, RenderOptions options, const ProgressCallback& progress,
               const std::atomic<bool>& stop);

// Where a render is, as a line.
std::string to_text(const Progress& progress);

// The pixels that --crop asks for, or all. Throws std::invalid_argument if it reaches beyond them.
Window window_of(const std::optional<Window>& crop, const Camera& camera);

// What a render took and gave, as a line; it has an image.
std::string summary(const Scene& scene, const Rendering& rendering);

// That there is no picture, as a sentence.
std::string why_no_picture(const Rendering& rendering);

}  // namespace plumb::cli
