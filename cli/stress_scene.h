// A scene of `plumb stress`, and what is known of its picture.
#pragma once

#include <atomic>
#include <filesystem>
#include <string>

#include "compare/picture.h"
#include "renderer/render.h"

namespace plumb::cli {

struct StressScene {
  std::filesystem::path file;
  Scene scene;
  // From the comment on top of the file:
  std::string oracle;         // "radiance", of every pixel; "like" another scene; or a "picture"
  std::string value;          // the radiance or the file, beside the scene's
  bool beyond_float = false;  // "Beyond float": said in advance that float need not hold

  // Throws std::runtime_error.
  explicit StressScene(const std::filesystem::path& scene_file);

  // A scene that this one is like is rendered in double by `mis`, with four times the limits.
  Picture find_truth(const Limits& limits, const std::atomic<bool>& stop) const;
};

}  // namespace plumb::cli
