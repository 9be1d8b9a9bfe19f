#include "cli/stress_scenes.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <sstream>
#include <stdexcept>

#include "cli/film_image.h"
#include "renderer/scene_reader.h"

namespace plumb::cli {
namespace {

namespace fs = std::filesystem;

StressScene read_entry(const toml::table& table, const fs::path& folder) {
  StressScene stress;
  for (const auto& [key, value] : table) {
    const std::string name(key.str());
    const auto text = value.value<std::string>();
    if (name == "file" && text) {
      stress.file = folder / *text;
    } else if (name == "idea" && text) {
      stress.idea = *text;
    } else if (name == "like" && text) {
      stress.oracle.like = folder / *text;
    } else if (name == "picture" && text) {
      stress.oracle.picture = folder / *text;
    } else if (name == "radiance" && value.is_number()) {
      stress.oracle.radiance = *value.value<double>();
    } else if (name == "beyond_float" && value.is_boolean()) {
      stress.beyond_float = *value.value<bool>();
    } else {
      throw std::runtime_error(fmt::format("line {}: '{}' is unknown or has another type",
                                           key.source().begin.line, name));
    }
  }
  const Oracle& oracle = stress.oracle;
  const int oracles =
      int{oracle.radiance > 0.0} + int{!oracle.like.empty()} + int{!oracle.picture.empty()};
  if (stress.file.empty() || stress.idea.empty() || oracles != 1) {
    throw std::runtime_error(fmt::format(
        "line {}: a scene needs a file, an idea and one of radiance (above 0), like and picture",
        table.source().begin.line));
  }
  return stress;
}

Picture known_exactly(double radiance, const Camera& camera) {
  Image image{camera.width, camera.height, {"R", "G", "B"}, {}, {}};
  image.values.assign(image.pixel(0, camera.height) * 3, static_cast<float>(radiance));
  return {.side = "reference", .image = std::move(image)};
}

Picture of_like_scene(const fs::path& file, const Limits& limits, const std::atomic<bool>& stop) {
  const Scene scene = read_scene(file);
  Film film(scene.camera.width, scene.camera.height);
  constexpr int64_t more = 4;
  Limits longer = limits;
  longer.seconds *= more;
  longer.samples.last = std::min(largest_sample, longer.samples.last * more);
  const Settings settings{.precision = Precision::float64, .seed = 4711, .bounces = {}};
  render(scene, settings, longer, film, {}, &stop);
  return {.side = "reference",
          .image = to_image(film, false),
          .degrees_of_freedom = Film::replicates - 1};
}

}  // namespace

std::vector<StressScene> read_stress_scenes(const fs::path& list) try {
  std::vector<StressScene> scenes;
  const toml::table root = toml::parse_file(list.string());
  const toml::array* entries = root["scene"].as_array();
  if (entries == nullptr || root.size() != 1) throw std::runtime_error("no list of [[scene]]");
  for (const toml::node& entry : *entries) {
    if (!entry.is_table()) throw std::runtime_error("no list of [[scene]]");
    scenes.push_back(read_entry(*entry.as_table(), list.parent_path()));
  }
  return scenes;
} catch (const toml::parse_error& error) {
  std::ostringstream what;
  what << error;
  throw std::runtime_error(fmt::format("{}: {}", list.string(), what.str()));
} catch (const std::runtime_error& error) {
  throw std::runtime_error(fmt::format("{}: {}", list.string(), error.what()));
}

Picture find_truth(const StressScene& stress, const Camera& camera, const Limits& limits,
                   const std::atomic<bool>& stop) {
  const Oracle& oracle = stress.oracle;
  if (oracle.radiance > 0.0) return known_exactly(oracle.radiance, camera);
  Picture truth = oracle.like.empty() ? read_picture("reference", {oracle.picture}, "")
                                      : of_like_scene(oracle.like, limits, stop);
  if (truth.image.width != camera.width || truth.image.height != camera.height) {
    throw std::runtime_error(stress.name() + ": the oracle's picture has another size");
  }
  return truth;
}

}  // namespace plumb::cli
