// SPDX-License-Identifier: Apache-2.0

// What commands that take a scene have in common.
#pragma once

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "images/printable.h"
#include "renderer/settings.h"
#include "scene/light_origin.h"
#include "scene/scene.h"

namespace plumb::cli {

// Tells the user, in a line, what was taken or chosen how; on standard error, unless another
// program that this is a part of has other ears.
inline std::function<void(const std::string& line)> say = [](const std::string& line) {
  fmt::print(stderr, "plumb: {}\n", printable(line));
};

struct SceneOptions {
  std::string file;
  std::optional<std::pair<int, int>> size;
  std::optional<BounceRange> bounces;
  std::vector<std::string> from, by;  // shapes' ids
};

void add_scene_option(CLI::App& command, SceneOptions& options);      // SCENE
void add_size_and_bounces(CLI::App& command, SceneOptions& options);  // --size, --bounces
void add_light_origin(CLI::App& command, SceneOptions& options);      // --from, --by

// Where the project's own scenes are: `reference_scenes` if the working directory has it, as a
// checkout does; else the folder that was installed with this executable, wherever both have been
// moved to.
std::filesystem::path scene_folder();

// The .xml files in a folder, sorted. Throws std::runtime_error if there is no such folder.
std::vector<std::filesystem::path> scene_files_in(const std::filesystem::path& folder);

// The names of these files, without .xml.
std::vector<std::string> scene_names_in(const std::filesystem::path& folder);

// Gives the scene the size and the bounces that were asked for, these in scene.request.
void adjust(Scene& scene, const SceneOptions& options);

// The scene with the size and the bounces that were asked for. Says what of the file was taken how.
// Throws SceneError.
Scene load_scene(const SceneOptions& options);

// What --from and --by ask for, and the same as words for the provenance; nothing if neither is
// there.
std::optional<LightOrigin> light_origin_of(const Scene& scene, const SceneOptions& options);
std::optional<std::string> light_origin_words(const SceneOptions& options);

// `mis`, or `bsdf` if chance suffices: then it says so.
Method fitting_method(const Scene& scene);

// Float, or double if the scene needs it: then it says so, and why.
Precision fitting_precision(const Scene& scene);

}  // namespace plumb::cli
