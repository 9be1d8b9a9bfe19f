// SPDX-License-Identifier: Apache-2.0

#include "cli/scene_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <system_error>
#include <tuple>

#include "cli/commands.h"
#include "cli/names.h"
#include "scene_files/method.h"
#include "scene_files/precision.h"
#include "scene_files/scene_reader.h"

namespace plumb::cli {

void add_scene_option(CLI::App& command, SceneOptions& options) {
  add_option(command, "SCENE", "", options.file, "Scene file, in a subset of Mitsuba 3's XML")
      ->required();
}

void add_size_and_bounces(CLI::App& command, SceneOptions& options) {
  add_option(command, "--bounces", "A:B", options.bounces, parse_bounces,
             "Only light of A to B bounces: 0 is emission seen\n"
             "directly, 1 direct light; 'A:' for A and more\n"
             "(default: the scene's max_depth, else all)");
  add_option(command, "--size", "WxH", options.size, parse_size, "Size (default: the scene's)");
}

void add_light_origin(CLI::App& command, SceneOptions& options) {
  auto* from = add_option(command, "--from", "SHAPE,...", options.from,
                          "Only light that came straight from these shapes (ids; or\n"
                          "#3, the fourth) to the surface that is seen: pictures of\n"
                          "all shapes add up to the whole one");
  auto* by = add_option(command, "--by", "SHAPE,...", options.by,
                        "Only light that one of these shapes has reflected, on\n"
                        "its way to the surface that is seen");
  for (auto* option : {from, by}) option->delimiter(',')->allow_extra_args(false);
  by->excludes(from);
}

std::optional<LightOrigin> light_origin_of(const Scene& scene, const SceneOptions& options) {
  if (!options.from.empty()) return light_origin(scene, LightOrigin::Way::last, options.from);
  if (!options.by.empty()) return light_origin(scene, LightOrigin::Way::any, options.by);
  return {};
}

std::optional<std::string> light_origin_words(const SceneOptions& options) {
  if (!options.from.empty()) return fmt::format("from {}", fmt::join(options.from, ","));
  if (!options.by.empty()) return fmt::format("by {}", fmt::join(options.by, ","));
  return {};
}

std::filesystem::path scene_folder() {
  namespace fs = std::filesystem;
  const fs::path here = "reference_scenes";
  std::error_code error;
  const fs::path executable = fs::read_symlink("/proc/self/exe", error);
  const fs::path installed = (executable.parent_path() / PLUMB_SCENES_FROM_BIN).lexically_normal();
  return fs::is_directory(here, error) || !fs::is_directory(installed, error) ? here : installed;
}

std::vector<std::filesystem::path> scene_files_in(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  if (!fs::is_directory(folder)) {
    throw std::runtime_error(folder.string() + ": there are no scenes; --folder says where");
  }
  std::vector<fs::path> files;
  std::ranges::copy_if(fs::directory_iterator(folder), std::back_inserter(files),
                       [](const fs::path& file) { return file.extension() == ".xml"; });
  std::ranges::sort(files);
  return files;
}

std::vector<std::string> scene_names_in(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const auto& file : scene_files_in(folder)) names.push_back(file.stem());
  return names;
}

void adjust(Scene& scene, const SceneOptions& options) {
  if (options.size) std::tie(scene.camera.width, scene.camera.height) = *options.size;
  if (options.bounces) scene.request.bounces = *options.bounces;
}

Scene load_scene(const SceneOptions& options) {
  Scene scene = read_scene(options.file);
  adjust(scene, options);
  for (const std::string& note : scene.notes) say(note);
  if (!scene.has_lamps()) say("warning: " + options.file + ": no lamp, the picture will be black");
  return scene;
}

Method fitting_method(const Scene& scene) {
  if (!scene.request.bounces.is_everything() || !chance_suffices(scene)) return Method::mis;
  say("lamps are left to chance (bsdf), by which every path meets them");
  return Method::bsdf;
}

Precision fitting_precision(const Scene& scene) {
  const std::string need = needs_double(scene);
  if (need.empty()) return Precision::float32;
  say("in double precision, because float is too coarse for " + need);
  return Precision::float64;
}

}  // namespace plumb::cli
