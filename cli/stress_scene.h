// A scene of `plumb stress`, and what is known of its picture.
#pragma once

#include <atomic>
#include <filesystem>
#include <string>

#include "compare/picture.h"
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

}  // namespace plumb::cli
