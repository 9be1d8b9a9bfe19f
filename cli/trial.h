// A way of rendering is tried on a scene for a while.
#pragma once

#include <atomic>
#include <filesystem>
#include <optional>

#include "compare/assessment.h"
#include "reference_scenes/reference.h"
#include "renderer/render.h"

namespace plumb::cli {

// Both return nothing after a stop. Other programs take as many samples as fit into the time, by a
// first small picture; POV-Ray draws its draft. Throws as render_reference() does.
std::optional<Trial> try_method(const Scene& scene, const Settings& settings, const Limits& limits,
                                const std::atomic<bool>& stop);
std::optional<Trial> try_program(const Scene& scene, const std::filesystem::path& file,
                                 Program program, double seconds, const Watcher& watcher);

}  // namespace plumb::cli
