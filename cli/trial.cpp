#include "cli/trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "cli/film_image.h"
#include "compare/equivalence.h"
#include "compare/sums.h"
#include "images/relative_error.h"

namespace plumb::cli {
namespace {

// What differs by less, as a part of the mean, is rounding: of a hundred bounces in float.
constexpr double rounding = 1e-5;
// What a program without noise may be off, as a part of the mean.
constexpr double noiseless_tolerance = 0.01;
// A trial is noisy if the error of a picture with so many pixels needs longer to fall to 1 %.
constexpr double reasonable_seconds = 60.0;
constexpr double usual_pixels = 256.0 * 256.0;

std::vector<double> gray(const std::vector<float>& rgb) {
  std::vector<double> values;
  for (size_t i = 0; i < rgb.size(); i += 3) {
    values.push_back((double{rgb[i]} + double{rgb[i + 1]} + double{rgb[i + 2]}) / 3.0);
  }
  return values;
}

// Of the squared deviations from the mean.
void describe_scatter(std::vector<double> squares, Tail& tail) {
  const double sum = std::reduce(squares.begin(), squares.end(), 0.0);
  if (sum == 0.0) return;
  const double fourth = std::inner_product(squares.begin(), squares.end(), squares.begin(), 0.0);
  tail.kurtosis = fourth * static_cast<double>(squares.size()) / (sum * sum);
  const auto worst = squares.end() - std::max<std::ptrdiff_t>(1, std::ssize(squares) / 1000);
  std::ranges::nth_element(squares, worst);
  tail.fireflies = std::accumulate(worst, squares.end(), 0.0) / sum;
}

// Renders single samples, with another seed than `film` was, for an eighth of the limits.
Tail measure_tail(const Scene& scene, Settings settings, const Film& film, const Limits& limits) {
  using Clock = std::chrono::steady_clock;
  const std::chrono::duration<double> time(limits.seconds / 8.0);
  const auto begin = Clock::now();
  const int64_t passes = std::clamp<int64_t>(film.samples_per_pixel() / 8, 1, 4096);
  ++settings.seed;
  Tail tail;
  const std::vector<double> means = gray(film.mean());
  std::vector<double> squares;
  for (int64_t s = 0; s < passes && Clock::now() - begin < time; ++s) {
    Film single(film.width(), film.height());
    render(scene, settings, {.samples = {s, s + 1}}, single);
    const std::vector<float> rgb = single.mean();
    tail.unfit += std::ranges::count_if(
        rgb, [](float value) { return !(value >= 0.0F && std::isfinite(value)); });
    const std::vector<double> values = gray(rgb);
    for (size_t i = 0; i < values.size(); ++i) {
      if (!std::isfinite(values[i] - means[i])) continue;
      tail.brightest = std::max(tail.brightest, values[i]);
      squares.push_back(std::pow(values[i] - means[i], 2));
    }
  }
  describe_scatter(std::move(squares), tail);
  return tail;
}

double brightest_lamp(const Scene& scene) {
  const auto radiance = [](const Shape& s) { return s.radiance.dot(Rgb(1.0)) / 3.0; };
  return radiance(*std::ranges::max_element(scene.shapes, {}, radiance));
}

bool finds_lamps_by_chance(const Scene& scene, Method method) {
  const auto is_mirror = [](const Shape& s) { return s.bsdf.kind == Bsdf::Kind::conductor; };
  return method == Method::bsdf || std::ranges::any_of(scene.shapes, is_mirror);
}

// The brightest sample that another program may have drawn, which is unknown: as much as would
// explain how far a pixel's pictures by other seeds lie apart. Roulette can make it brighter than
// any lamp.
double brightest_by_scatter(const Reference& reference) {
  const Image& image = reference.image;
  if (image.channels.size() < 6) return 0.0;
  double largest = 0.0;
  for (size_t i = 3; i < image.values.size(); i += 6) {
    largest = std::max(largest, double{*std::max_element(&image.values[i], &image.values[i] + 3)});
  }
  const double samples_of_seed = double{1} * reference.samples_per_pixel / reference.seeds;
  return samples_of_seed * std::sqrt(largest * reference.seeds * (reference.seeds - 1));
}

// What noise alone may make of the difference of two averages: Student's quantile, because
// variances come from few replicates. If the test is the darker one, it may have met none of some
// rare bright samples, and then its variance does not tell; the second term of the empirical
// Bernstein bound (Maurer and Pontil 2009) allows for them.
double margin(const Pool& pool, const Trial& trial, double false_alarm) {
  const double by_variance = confidence(pool, false_alarm);
  if (pool.test >= pool.reference) return by_variance;
  const Image& image = trial.picture.image;
  const double share = pool.pixels / static_cast<double>(image.pixel(0, image.height));
  const double unseen = 7.0 / 3.0 * trial.brightest * std::log(2.0 / false_alarm);
  return by_variance + unseen / (trial.samples * share);
}

// Of the mean of the channels; the truth's noise left out.
double relative_square_error(const Picture& test, const Picture& truth) {
  const size_t pixels = truth.image.pixel(0, truth.image.height);
  double sum = 0.0;
  for (size_t i = 0; i < pixels; ++i) {
    const PixelPair pair = pixel_pair(test, truth, i, test.channel_count());
    sum +=
        relative_square(std::pow(pair.difference(), 2) - pair.reference_variance, pair.reference);
  }
  return std::max(sum / static_cast<double>(pixels), rounding * rounding);
}

}  // namespace

std::optional<Trial> try_method(const Scene& scene, const Settings& settings, const Limits& limits,
                                const std::atomic<bool>& stop) {
  Film film(scene.camera.width, scene.camera.height);
  const Cost cost = render(scene, settings, limits, film, {}, &stop);
  if (stop) return {};
  if (film.samples_per_pixel() == 0) throw std::runtime_error(why_unfinished(cost));
  const Tail tail = measure_tail(scene, settings, film, limits);
  const double by_chance =
      finds_lamps_by_chance(scene, settings.method) ? brightest_lamp(scene) : 0;
  return Trial{.picture = {.side = "test",
                           .image = to_image(film, false),
                           .degrees_of_freedom = Film::replicates - 1},
               .program = "",
               .seconds = cost.wall_seconds,
               .samples = static_cast<double>(cost.samples),
               .brightest = std::max(tail.brightest, by_chance),
               .tail = tail};
}

std::optional<Trial> try_program(const Scene& scene, const std::filesystem::path& file,
                                 Program program, double seconds, const Watcher& watcher) {
  constexpr double most_samples = 1 << 22;  // of a picture: Mitsuba holds them in memory at once
  const double pixels = double{1} * scene.camera.width * scene.camera.height;
  const auto log = std::filesystem::temp_directory_path() / fmt::format("plumb-{}.log", scene.name);
  const bool has_samples = program != Program::povray;
  ReferenceSettings settings{.program = program, .quality = Quality::draft};
  if (has_samples) settings.samples_per_pixel = 256;
  if (has_samples) settings.seeds = 1;
  Reference reference = render_reference(scene, file, settings, log, watcher);
  if (has_samples && !watcher.stop) {
    settings.seeds = 4;
    const double ratio = seconds / settings.seeds / std::max(reference.wall_seconds, 1e-3);
    settings.samples_per_pixel =
        static_cast<int>(std::clamp(256.0 * ratio, 1.0, most_samples / pixels));
    reference = render_reference(scene, file, settings, log, watcher);
  }
  if (watcher.stop) return {};
  const double brightest = std::max(brightest_lamp(scene), brightest_by_scatter(reference));
  return Trial{.picture = {.side = "test",
                           .image = std::move(reference.image),
                           .degrees_of_freedom = reference.seeds - 1.0},
               .program = reference.program,
               .seconds = reference.wall_seconds,
               .samples = reference.samples_per_pixel * pixels,
               .brightest = brightest,
               .tail = {}};
}

Assessment assess(Trial trial, Picture truth, double false_alarm) {
  Assessment result;
  try {
    match(trial.picture, truth, {}, true);
  } catch (const ImageError&) {
    return result;
  }
  if (trial.tail && trial.tail->unfit > 0) return result;
  const Sums sums = add_up(trial.picture, truth, {0, 0, truth.image.width, truth.image.height}, {});
  const Pool& whole = sums.image.back();
  result.bias = (whole.test - whole.reference) / whole.reference;
  result.error = std::sqrt(whole.test_variance + whole.reference_variance) / whole.reference;
  result.square = relative_square_error(trial.picture, truth);
  result.seconds_to_one_percent =
      trial.seconds * result.square / 1e-4 * usual_pixels / whole.pixels;

  const double mean = whole.reference / whole.pixels;
  const auto is_off = [&](const Pool& pool, double alarm) {
    const double allowed = trial.picture.knows_noise()
                               ? margin(pool, trial, alarm) + rounding * mean
                               : noiseless_tolerance * mean;
    return std::abs(pool.test - pool.reference) / pool.pixels > allowed;
  };
  // Half of the false alarms for the picture, half for all of its blocks.
  bool is_biased = is_off(whole, false_alarm / 2.0);
  const size_t channels = sums.image.size();
  const auto blocks = static_cast<double>(sums.blocks.size()) / static_cast<double>(channels);
  for (size_t i = channels - 1; i < sums.blocks.size(); i += channels) {
    is_biased |= is_off(sums.blocks[i], false_alarm / 2.0 / blocks);
  }
  const bool is_noisy = result.seconds_to_one_percent > reasonable_seconds;
  result.outcome = is_biased ? Outcome::biased : is_noisy ? Outcome::noisy : Outcome::holds;
  return result;
}

}  // namespace plumb::cli
