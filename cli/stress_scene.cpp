#include "cli/stress_scene.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <regex>
#include <stdexcept>
#include <utility>

#include "cli/film_image.h"
#include "cli/names.h"
#include "scene_files/scene_reader.h"

namespace plumb::cli {
namespace {

const Words<Oracle> oracle_words{
    {"radiance", Oracle::radiance}, {"like", Oracle::like}, {"picture", Oracle::picture}};

Image render_slowly(const Scene& scene, Limits limits, const std::atomic<bool>& stop) {
  constexpr int64_t more = 4;
  limits.seconds *= more;
  limits.samples.last = std::min(largest_sample, limits.samples.last * more);
  constexpr uint32_t seed = 4711;  // no trial's
  Film film(scene.camera.width, scene.camera.height);
  render(scene, {.precision = Precision::float64, .seed = seed, .bounces = {}}, limits, film, {},
         &stop);
  return to_image(film, false);
}

}  // namespace

StressScene::StressScene(const std::filesystem::path& scene_file)
    : file(scene_file), scene(read_scene(scene_file)) {
  std::ifstream stream(file);
  const std::string text(std::istreambuf_iterator<char>(stream), {});
  for (const auto& [word, meaning] : oracle_words) {
    std::smatch match;
    const std::regex line(R"(Oracle:\s+)" + word + R"(\s+([\w./]*\w))");
    if (!std::regex_search(text, match, line)) continue;
    oracle = meaning;
    value = match[1];
  }
  if (value.empty()) {
    throw std::runtime_error(file.string() +
                             ": no 'Oracle: radiance X', 'like FILE' or 'picture FILE' in it");
  }
  beyond_float = text.find("Beyond float") != std::string::npos;
}

Picture StressScene::find_truth(const Limits& limits, const std::atomic<bool>& stop) const {
  const std::filesystem::path beside = file.parent_path() / value;
  if (oracle == Oracle::picture) return read_picture("reference", {beside}, "");
  Image truth{scene.camera.width, scene.camera.height, {"R", "G", "B"}, {}, {}};
  if (oracle == Oracle::like) {
    truth = render_slowly(read_scene(beside), limits, stop);
  } else {
    truth.values.assign(truth.pixel(0, truth.height) * 3, std::stof(value));
  }
  return to_picture("reference", std::move(truth), Film::replicates);
}

}  // namespace plumb::cli
