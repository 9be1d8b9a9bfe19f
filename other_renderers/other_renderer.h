// SPDX-License-Identifier: Apache-2.0

// Renderers that share no code with this one. Each is a description: what it can, what it reads,
// how it is called, and what its picture means. Everything else asks the description: to add a
// renderer is to write its file and to name it in table.cpp (and in CMakeLists.txt, to be built).
#pragma once

#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/settings.h"
#include "scene/scene.h"

namespace plumb {

enum class Quality { draft, good, best };

struct ReferenceSettings {
  Quality quality = Quality::good;
  int samples_per_pixel = 0;  // of each seed; 0: the quality's
  int seeds = 0;              // 0: the quality's
  int first_seed = 101;
  std::vector<std::string> overrides = {};  // settings of the renderer's own, NAME=NUMBER
  BounceRange bounces = {};
  int threads = 0;  // 0: all that the machine has
};

// A program, which is looked up in PATH, and its arguments.
using Command = std::vector<std::string>;

// One run of a renderer, whose picture counts with `weight`.
struct Run {
  Command command;
  double weight = 1.0;
};

// Runs are started in a folder of their own and leave their picture there under this name, as large
// as the scene's camera says.
constexpr const char* picture_name = "picture.exr";

// What a run's picture holds, if it is not linear R G B with Rec. 709 primaries, the first row on
// top.
struct Decoding {
  enum class Transfer { linear, srgb, gamma };  // gamma: code = radiance^(1/2.2)
  Transfer transfer = Transfer::linear;         // of what the file's format takes for linear
  double scale = 1.0;                           // that linear values are multiplied by
  bool flipped = false;                         // the first row is the lowest
  bool mirrored = false;                        // the first column is the rightmost
};

// A picture that a renderer is asked for.
struct Job {
  const Scene& scene;
  std::filesystem::path file;         // the scene as the renderer reads it, an absolute path
  const ReferenceSettings& settings;  // with samples and seeds, if the renderer has any
  std::optional<int> most_bounces;    // none: all light
  int seed = 0;
};

// How scenes are written for a renderer that doesn't read scene files as they are.
struct SceneFormat {
  std::string extension;  // with its dot
  std::function<std::string(const Scene&)> text;
};

// What a program says of a run. It prints "plumbline:" and, as JSON, an object with these names and
// with the settings that it applied.
struct RunReport {
  std::string program;  // with its version
  std::string version;
  double seconds = 0.0;  // of rendering alone
};

struct OtherRenderer {
  std::string word;      // on the command line and in names of files: "cycles"
  std::string name;      // in sentences: "Cycles"
  std::string software;  // what it is a part of, or its name again: "Blender"

  // How it is found and installed.
  Command probe;               // ends with 0 where it is installed
  std::string how_to_install;  // said where the program that it runs in is missing

  // What it can.
  bool has_samples = true;     // else its pictures differ in quality alone, and seeds count not
  bool has_seeds = true;       // else it may take another one each time, or always the same
  bool counts_bounces = true;  // else it draws all light only
  bool counts_mirror_bounces = true;  // else not in mirrors and glass, so no ranges there
  bool takes_threads = true;          // else it takes as many as it likes
  bool promises_same_bits = false;    // for a seed, with any number of threads
  bool is_single_precision = false;   // said of itself
  // Why it can't draw a scene; empty if nothing is known to be in its way.
  std::function<std::string(const Scene&)> obstacle = [](const Scene&) { return ""; };
  std::string example_setting = "";  // of its own, NAME=NUMBER; empty: none can be set

  // What it reads.
  std::string_view script_name;  // a file that is put beside the scene, or where the program runs
  std::string_view script;       // its text
  std::optional<SceneFormat> format = std::nullopt;  // none: scene files as they are
  // What of the scene it draws otherwise, in a line; empty if nothing.
  std::function<std::string(const Scene&)> drawn_otherwise = [](const Scene&) { return ""; };

  // How it is called: the weighted sum of the runs' pictures is the job's.
  std::function<std::vector<Run>(const Job&)> runs;
  double time_limit = std::numeric_limits<double>::infinity();  // seconds, of a run

  // What it leaves.
  std::string picture = picture_name;
  Decoding decoding = {};
  bool must_report = true;  // else time may be its process's, its version what its probe says
  // Reads what the program can't print as JSON from its log; none if it can.
  std::function<RunReport(const std::string& log)> read_log = nullptr;
};

// The table.
const std::vector<OtherRenderer>& other_renderers();

// The one that `word` names, or the file of a description (description.h). Throws
// std::invalid_argument, which lists the words, or what is wrong in the file.
OtherRenderer other_renderer(const std::string& word);

}  // namespace plumb
