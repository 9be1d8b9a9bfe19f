// Pictures of a scene by programs that share no code with this one.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "images/image.h"
#include "renderer/scene.h"
#include "renderer/settings.h"

namespace plumb {

enum class Program { povray, cycles, mitsuba };

enum class Quality { draft, good, best };

struct ReferenceSettings {
  Program program = Program::cycles;
  Quality quality = Quality::good;
  int samples_per_pixel = 0;  // of each seed; 0: the quality's
  int seeds = 0;              // 0: the quality's; POV-Ray has none
  int first_seed = 1;
  std::vector<std::string> overrides = {};  // Cycles' own settings that differ, NAME=NUMBER
  BounceRange bounces = {};
  int threads = 0;  // 0: all that the machine has
};

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

// What of the scene the program draws otherwise, in a line; empty if nothing.
std::string drawn_otherwise(const Scene& scene, Program program);

// Light of A to B bounces is the difference of a picture with up to B and one with up to A - 1.
// After a stop the picture has the seeds that were finished.
//
// Throws std::invalid_argument for what the program can't render, std::runtime_error if it isn't
// installed or fails. The file `log` holds what the program printed and stays if it fails.
Reference render_reference(const Scene& scene, const std::filesystem::path& scene_file,
                           const ReferenceSettings& settings, const std::filesystem::path& log,
                           const Watcher& watcher);

}  // namespace plumb
