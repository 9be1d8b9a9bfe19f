// Tries a way of rendering on a scene for a limited time.
#pragma once

#include <atomic>
#include <filesystem>
#include <optional>

#include "compare/assessment.h"
#include "other_renderers/runner.h"
#include "renderer/render.h"

namespace plumb::cli {

// Renders by a method of ours within the limits, and then single samples for an eighth of them.
// Returns nothing after a stop. Throws std::runtime_error if there was no time for any sample.
std::optional<Trial> try_method(const Scene& scene, const Settings& settings, const Limits& limits,
                                const std::atomic<bool>& stop);

// Lets another renderer render with as many samples as fit into the seconds by a first small
// picture; one that has no samples draws its draft. Returns nothing after a stop. Throws as
// render_reference() does.
std::optional<Trial> try_renderer(const OtherRenderer& renderer, const Scene& scene,
                                  const std::filesystem::path& file, double seconds,
                                  const Watcher& watcher);

}  // namespace plumb::cli
