// SPDX-License-Identifier: Apache-2.0

#include "cli/trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iterator>
#include <regex>
#include <stdexcept>
#include <utility>

#include "cli/film_image.h"
#include "cli/names.h"
#include "cli/radiosity_drawing.h"
#include "radiosity/radiosity.h"
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

// Renders single samples, with another seed than `film` was, for an eighth of the limits.
SampleTail measure_tail(const Scene& scene, Settings settings, const Film& film,
                        const Limits& limits) {
  using Clock = std::chrono::steady_clock;
  const std::chrono::duration<double> time(limits.seconds / 8.0);
  const auto begin = Clock::now();
  const int64_t passes = std::clamp<int64_t>(film.samples_per_pixel() / 8, 1, 4096);
  ++settings.seed;
  SampleTailEstimator estimator(film.mean());
  for (int64_t s = 0; s < passes && Clock::now() - begin < time; ++s) {
    Film single(film.width(), film.height());
    render(scene, settings, {.samples = {s, s + 1}}, single);
    estimator.add(single.mean());
  }
  return estimator.estimate();
}

double brightest_lamp(const Scene& scene) {
  const auto radiance = [](const Shape& s) { return s.radiance.dot(Rgb(1.0)) / 3.0; };
  return radiance(*std::ranges::max_element(scene.shapes, {}, radiance));
}

bool finds_lamps_by_chance(const Scene& scene, Method method) {
  const auto is_specular = [](const Shape& s) { return s.bsdf.is_specular(); };
  return method == Method::bsdf || std::ranges::any_of(scene.shapes, is_specular);
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

std::optional<Trial> try_method(const Scene& scene, const Settings& settings, const Limits& limits,
                                const std::atomic<bool>& stop) {
  Film film(scene.camera.width, scene.camera.height);
  const Cost cost = render(scene, settings, limits, film, {}, &stop);
  if (stop) return {};
  if (film.samples_per_pixel() == 0) throw std::runtime_error(why_unfinished(cost));
  const SampleTail tail = measure_tail(scene, settings, film, limits);
  const double by_chance =
      finds_lamps_by_chance(scene, settings.method) ? brightest_lamp(scene) : 0;
  return Trial{.picture = to_picture("test", film),
               .program = "",
               .seconds = cost.wall_seconds,
               .samples = static_cast<double>(cost.samples),
               .brightest = std::max(tail.brightest, by_chance),
               .tail = tail};
}

std::optional<Trial> try_radiosity(const Scene& scene, const std::atomic<bool>& stop) {
  const auto begin = std::chrono::steady_clock::now();
  radiosity::Picture drawn = radiosity::draw(
      scene, {.bounces = scene.request.bounces, .level = 1, .most_bytes = half_of_the_memory()},
      {[](const std::string&) {}, &stop});
  if (stop) return {};
  Image image{scene.camera.width, scene.camera.height, {"R", "G", "B"}, std::move(drawn.rgb), {}};
  const std::chrono::duration<double> time = std::chrono::steady_clock::now() - begin;
  return Trial{.picture = to_picture("test", std::move(image)),
               .program = "",
               .seconds = time.count(),
               .tail = {}};
}

std::optional<Trial> try_renderer(const OtherRenderer& renderer, const Scene& scene,
                                  const std::filesystem::path& file, double seconds,
                                  const Watcher& watcher) {
  constexpr double most_samples = 1 << 22;  // of a picture: some hold them in memory at once
  const double pixels = double{1} * scene.camera.width * scene.camera.height;
  const auto log = std::filesystem::temp_directory_path() / fmt::format("plumb-{}.log", scene.name);
  ReferenceSettings settings{.quality = Quality::draft};
  if (renderer.has_samples) settings.samples_per_pixel = 256;
  if (renderer.has_samples) settings.seeds = 1;
  Reference reference = render_reference(renderer, scene, file, settings, log, watcher);
  if (renderer.has_samples && !watcher.stop) {
    settings.seeds = 4;
    const double ratio = seconds / settings.seeds / std::max(reference.wall_seconds, 1e-3);
    settings.samples_per_pixel =
        static_cast<int>(std::clamp(256.0 * ratio, 1.0, most_samples / pixels));
    reference = render_reference(renderer, scene, file, settings, log, watcher);
  }
  if (watcher.stop) return {};
  const double samples_of_seed = double{1} * reference.samples_per_pixel / reference.seeds;
  const double brightest =
      std::max(brightest_lamp(scene),
               brightest_by_scatter(reference.image, reference.seeds, samples_of_seed));
  return Trial{.picture = to_picture("test", std::move(reference.image), reference.seeds),
               .program = reference.program,
               .seconds = reference.wall_seconds,
               .samples = reference.samples_per_pixel * pixels,
               .brightest = brightest,
               .tail = {}};
}

}  // namespace plumb::cli
