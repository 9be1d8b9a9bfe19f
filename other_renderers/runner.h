// SPDX-License-Identifier: Apache-2.0

// Has another renderer draw a scene.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "images/image.h"
#include "images/replicates.h"
#include "other_renderers/other_renderer.h"

namespace plumb {

// Who is told what is going on, and can say that it is enough.
struct Watcher {
  std::function<void(const std::string&)> show;
  const std::atomic<bool>& stop;
};

struct Reference {
  Image image;  // channels R G B and, from two seeds on, variance.R G B; no provenance
  std::string program;
  std::string version;
  int seeds = 0;                 // 0: stopped before the first one was finished, there's no image
  int samples_per_pixel = 0;     // of all seeds; 0: the program has none
  double wall_seconds = 0.0;     // of rendering alone
  double process_seconds = 0.0;  // of whole processes
  std::string runs;              // JSON: what was run and what each run said that it applied
};

// Light of A to B bounces is the difference of a picture with up to B and one with up to A - 1.
// After a stop the picture has the seeds that were finished.
//
// Throws std::invalid_argument for what the renderer can't, std::runtime_error if it isn't
// installed or fails. The file `log` holds what the program printed and stays if it fails.
Reference render_reference(const OtherRenderer& renderer, const Scene& scene,
                           const std::filesystem::path& scene_file,
                           const ReferenceSettings& settings, const std::filesystem::path& log,
                           const Watcher& watcher);

// The mean of pictures, and from two on the variance of that mean. `values` are those of R G B,
// pixel by pixel.
Image mean_of(const std::vector<Replicates<double>>& values, int width, int height);

// What it says of itself in its first line; nothing if it can't be run. Asks its probe, which takes
// up to a second.
std::optional<std::string> installed_version(const OtherRenderer& renderer);

}  // namespace plumb
