#include "cli/trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "cli/film_image.h"
#include "compare/equivalence.h"
#include "compare/sums.h"

namespace plumb::cli {
namespace {

// Radiance that differs by less, as a part of the mean, is rounding: of a hundred bounces in float.
constexpr double rounding = 1e-5;
// What a program without noise may be off, as a part of the mean.
constexpr double noiseless_tolerance = 0.01;
// A trial is noisy if the pixels' error needs longer than this to fall to 1 %.
constexpr double reasonable_seconds = 60.0;

constexpr int64_t most_tail_samples = int64_t{1} << 18;

std::vector<double> gray(const std::vector<float>& rgb) {
  std::vector<double> values;
  for (size_t i = 0; i < rgb.size(); i += 3) {
    values.push_back((double{rgb[i]} + double{rgb[i + 1]} + double{rgb[i + 2]}) / 3.0);
  }
  return values;
}

// Renders single samples, with another seed than `film` was, for an eighth of the limits.
Tail measure_tail(const Scene& scene, Settings settings, const Film& film, const Limits& limits) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  const int64_t passes = std::clamp<int64_t>(film.samples_per_pixel() / 8, 1,
                                             most_tail_samples / film.pixel_count());
  Tail tail;
  ++settings.seed;
  const std::vector<double> means = gray(film.mean());
  std::vector<double> squares;
  for (int64_t s = 0; s < passes; ++s) {
    if (std::chrono::duration<double>(Clock::now() - begin).count() > limits.seconds / 8.0) break;
    Film single(film.width(), film.height());
    render(scene, settings, {.samples = {s, s + 1}}, single);
    const std::vector<float> rgb = single.mean();
    tail.unfit += std::ranges::count_if(rgb, [](float value) { return !(value >= 0.0F && std::isfinite(value)); });
    const std::vector<double> values = gray(rgb);
    for (size_t i = 0; i < values.size(); ++i) {
      if (!std::isfinite(values[i] - means[i])) continue;
      tail.brightest = std::max(tail.brightest, values[i]);
      squares.push_back(std::pow(values[i] - means[i], 2));
    }
  }
  const double sum = std::reduce(squares.begin(), squares.end(), 0.0);
  if (sum == 0.0) return tail;
  const auto worst = squares.end() - std::max<std::ptrdiff_t>(1, std::ssize(squares) / 1000);
  std::ranges::nth_element(squares, worst);
  tail.fireflies = std::accumulate(worst, squares.end(), 0.0) / sum;
  const double fourth = std::inner_product(squares.begin(), squares.end(), squares.begin(), 0.0);
  tail.kurtosis = fourth * static_cast<double>(squares.size()) / (sum * sum);
  return tail;
}

double brightest_lamp(const Scene& scene) {
  double brightest = 0.0;
  for (const Shape& shape : scene.shapes) {
    brightest = std::max(brightest, (shape.radiance.x + shape.radiance.y + shape.radiance.z) / 3.0);
  }
  return brightest;
}

bool finds_lamps_by_chance(const Scene& scene, Method method) {
  return method == Method::bsdf || std::ranges::any_of(scene.shapes, [](const Shape& shape) {
           return shape.bsdf.kind == Bsdf::Kind::conductor;
         });
}

// What noise alone may make of the difference of two averages of `pixels` pixels: the empirical
// Bernstein bound, with Student's quantile in the normal part because variances come from few
// replicates. Its second term is for samples up to `brightest` that are too rare to have been met.
double margin(const Pool& pool, const Trial& trial, double false_alarm) {
  const Image& image = trial.picture.image;
  const double samples = trial.samples * pool.pixels / (double{1} * image.width * image.height);
  return confidence(pool, false_alarm) +
         7.0 / 3.0 * trial.brightest * std::log(2.0 / false_alarm) / samples;
}

// Of the mean of the channels; the truth's noise left out.
double relative_square_error(const Picture& test, const Picture& truth) {
  const auto pixels = size_t(test.image.width) * size_t(test.image.height);
  double sum = 0.0;
  for (size_t i = 0; i < pixels; ++i) {
    const Sample s = sample(test, truth, i, test.values.size());
    sum += (std::pow(s.difference(), 2) - s.reference_variance) /
           (s.reference * s.reference + epsilon);
  }
  return std::max(sum / static_cast<double>(pixels), rounding * rounding);
}

}  // namespace

std::optional<Trial> try_method(const Scene& scene, const Settings& settings, const Limits& limits,
                                const std::atomic<bool>& stop) {
  Film film(scene.camera.width, scene.camera.height);
  const Cost cost = render(scene, settings, limits, film, {}, &stop);
  if (stop) return {};
  const Tail tail = measure_tail(scene, settings, film, limits);
  const double by_chance = finds_lamps_by_chance(scene, settings.method) ? brightest_lamp(scene) : 0;
  return Trial{Picture{.side = "test",
                       .image = to_image(film, false),
                       .degrees_of_freedom = Film::replicates - 1},
               cost.wall_seconds, static_cast<double>(cost.samples),
               std::max(tail.brightest, by_chance), tail};
}

std::optional<Trial> try_program(const Scene& scene, const std::filesystem::path& file,
                                 Program program, const Limits& limits, const Watcher& watcher) {
  // Mitsuba holds all samples of a picture in memory.
  constexpr double most_samples = 1 << 22;
  const double pixels = double{1} * scene.camera.width * scene.camera.height;
  const auto log = std::filesystem::temp_directory_path() / fmt::format("plumb-{}.log", scene.name);
  ReferenceSettings settings{.program = program, .quality = Quality::draft};
  const bool has_samples = program != Program::povray;
  if (has_samples) {
    settings.samples_per_pixel = 64;
    settings.seeds = 1;
  }
  Reference reference = render_reference(scene, file, settings, log, watcher);
  if (watcher.stop) return {};
  const double ratio = limits.seconds / std::max(reference.wall_seconds, 1e-3);
  constexpr double good_over_draft = 8.0;  // seconds
  if (has_samples) {
    settings.seeds = 4;
    settings.samples_per_pixel = static_cast<int>(
        std::clamp(64.0 * ratio / settings.seeds, 1.0, most_samples / pixels));
  } else if (ratio > good_over_draft) {
    settings.quality = Quality::good;
  }
  if (has_samples || settings.quality != Quality::draft) {
    reference = render_reference(scene, file, settings, log, watcher);
  }
  if (watcher.stop) return {};
  return Trial{Picture{.side = "test",
                       .image = std::move(reference.image),
                       .degrees_of_freedom = double(reference.seeds - 1)},
               reference.wall_seconds, reference.samples_per_pixel * pixels, brightest_lamp(scene),
               {}};
}

Assessment assess(Trial trial, Picture truth, double false_alarm) {
  Assessment result;
  try {
    match(trial.picture, truth, {}, true);
  } catch (const ImageError&) {
    return result;
  }
  if (trial.tail && trial.tail->unfit > 0) return result;
  const Window window{0, 0, truth.image.width, truth.image.height};
  const Sums sums = add_up(trial.picture, truth, window, {});
  const Pool& whole = sums.image.back();
  const double mean = whole.reference / whole.pixels;
  result.bias = (whole.test - whole.reference) / whole.reference;
  result.error = std::sqrt(whole.test_variance + whole.reference_variance) / whole.reference;
  result.square = relative_square_error(trial.picture, truth);
  result.seconds_to_one_percent = trial.seconds * result.square / 1e-4;
  result.outcome =
      result.seconds_to_one_percent > reasonable_seconds ? Outcome::noisy : Outcome::holds;

  // Half of the false alarms for the picture, half for all of its blocks.
  const auto judge = [&](const Pool& pool, double alarm, const std::string& name) {
    const double difference = std::abs(pool.test - pool.reference) / pool.pixels;
    const double allowed = trial.picture.knows_noise()
                               ? margin(pool, trial, alarm) + rounding * mean
                               : noiseless_tolerance * mean;
    if (difference <= allowed || result.outcome == Outcome::biased) return;
    result.outcome = Outcome::biased;
    result.where = name;
  };
  judge(whole, false_alarm / 2.0, "the picture");
  const size_t channels = sums.image.size();
  const double blocks = static_cast<double>(sums.blocks.size() / channels);
  for (size_t i = channels - 1; i < sums.blocks.size(); i += channels) {
    const Window w = block_window(window, static_cast<int>(i / channels));
    judge(sums.blocks[i], false_alarm / 2.0 / blocks, fmt::format("a block at {}, {}", w.x, w.y));
  }
  return result;
}

}  // namespace plumb::cli
