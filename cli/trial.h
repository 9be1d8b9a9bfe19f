// SPDX-License-Identifier: Apache-2.0

// Scenes of `plumb stress`, what is known of their pictures, and how ways of rendering are tried on
// them for a limited time.
#pragma once

#include <atomic>
#include <filesystem>
#include <optional>
#include <string>

#include "compare/assessment.h"
#include "compare/picture.h"
#include "other_renderers/runner.h"
#include "renderer/render.h"

namespace plumb::cli {

// What the true picture is: the same radiance in every pixel, what another scene looks like, or a
// picture in a file.
enum class Oracle { radiance, like, picture };

struct StressScene {
  std::filesystem::path file;
  Scene scene;
  // From the comment on top of the file:
  Oracle oracle = Oracle::radiance;
  std::string value;          // the radiance; or the oracle's file, beside the scene's
  bool beyond_float = false;  // "Beyond float": said in advance that float need not hold

  // Throws std::runtime_error.
  explicit StressScene(const std::filesystem::path& scene_file);

  // A scene that this one is like is rendered in double by `mis`, with four times the limits.
  Picture find_truth(const Limits& limits, const std::atomic<bool>& stop) const;
};

// Renders by a method of ours within the limits, and then single samples for an eighth of them.
// Returns nothing after a stop. Throws std::runtime_error if there was no time for any sample.
std::optional<Trial> try_method(const Scene& scene, const Settings& settings, const Limits& limits,
                                const std::atomic<bool>& stop);

// Has radiosity compute its first two resolutions, of which it tells no noise. Returns nothing
// after a stop. Throws as radiosity::draw() does.
std::optional<Trial> try_radiosity(const Scene& scene, const std::atomic<bool>& stop);

// Lets another renderer render with as many samples as fit into the seconds by a first small
// picture; one that has no samples draws its draft. Returns nothing after a stop. Throws as
// render_reference() does.
std::optional<Trial> try_renderer(const OtherRenderer& renderer, const Scene& scene,
                                  const std::filesystem::path& file, double seconds,
                                  const Watcher& watcher);

}  // namespace plumb::cli
