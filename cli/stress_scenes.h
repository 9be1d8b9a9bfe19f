// The scenes of `plumb stress` and what is known of them.
#pragma once

#include <atomic>
#include <filesystem>
#include <string>
#include <vector>

#include "compare/picture.h"
#include "renderer/render.h"

namespace plumb::cli {

// How the truth is known; one of these.
struct Oracle {
  double radiance = 0.0;          // of every pixel, in all channels
  std::filesystem::path like;     // a scene with the same picture and less noise
  std::filesystem::path picture;  // by another program, converged, with its noise
};

struct StressScene {
  std::filesystem::path file;
  std::string idea;
  Oracle oracle;
  bool beyond_float = false;  // said in advance: float need not hold

  std::string name() const { return file.stem(); }
};

// Reads the list that docs/stability.md describes. Throws std::runtime_error.
std::vector<StressScene> read_stress_scenes(const std::filesystem::path& list);

// A scene that is like another is rendered in double by the default method, `limits` times four.
Picture find_truth(const StressScene& stress, const Camera& camera, const Limits& limits,
                   const std::atomic<bool>& stop);

}  // namespace plumb::cli
