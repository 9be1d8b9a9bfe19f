// SPDX-License-Identifier: Apache-2.0

#include "compare/study.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "compare/shared_samples.h"
#include "compare/sums.h"
#include "images/relative_error.h"
#include "images/replicates.h"

namespace plumb {
namespace {

void add_mean(std::vector<double>& values) {
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  values.push_back(sum / static_cast<double>(values.size()));
}

Point point_of(const std::vector<const Render*>& runs, const std::vector<double>& noise) {
  const auto middle = [&](auto member) {
    std::vector<double> values(runs.size());
    std::ranges::transform(runs, values.begin(), [&](const Render* r) { return r->label.*member; });
    return median(std::move(values));
  };
  Point point{runs.front()->label, runs.size(), {}, {}};
  point.label.seconds = middle(&Label::seconds);
  point.label.startup_seconds = middle(&Label::startup_seconds);
  for (size_t c = 0; c < noise.size(); ++c) {
    Replicates<double> error;
    for (const Render* run : runs) error.add(run->errors[c]);
    point.errors.push_back(error.mean - noise[c]);
    point.deviations.push_back(std::sqrt(error.variance()));
  }
  return point;
}

// Whether the error falls slower than 1 / N over the last two doublings, two standard errors of the
// slope being allowed for.
bool falls_slowly(const std::vector<Point>& points, size_t channel) {
  const Point& last = points.back();
  const auto earlier = std::find_if(points.rbegin(), points.rend(), [&](const Point& p) {
    return p.label.samples <= last.label.samples / 4.0 || &p == &points.front();
  });
  const double distance = std::log(last.label.samples / earlier->label.samples);
  const double slope = std::log(earlier->errors[channel] / last.errors[channel]) / distance;
  const double deviation = std::hypot(earlier->deviations[channel] / earlier->errors[channel],
                                      last.deviations[channel] / last.errors[channel]);
  return slope + 2.0 * deviation / distance < 1.0;
}

}  // namespace

Label label_of(const Picture& picture) {
  const Provenance& made = picture.image.provenance;
  Label label{made.renderer.value_or(""), made.quality.value_or(""), picture.samples_per_pixel(),
              0.0, 0.0};
  for (const auto& words : {made.method, made.sampler, made.settings, made.fault}) {
    if (!words.value_or("").empty()) label.series += " " + *words;
  }
  if (made.precision == "double") label.series += " double";
  if (const std::string bounces = made.bounces.value_or("0:"); bounces != "0:") {
    label.series += " bounces " + bounces;
  }
  if (label.samples > 0.0) label.step = fmt::format("{} spp", label.samples);
  label.seconds = made.wall_seconds.value_or(0.0);
  if (made.process_seconds) label.startup_seconds = *made.process_seconds - label.seconds;
  return label;
}

void Study::measure_reference() {
  const auto n = static_cast<double>(reference_.image.width * reference_.image.height);
  for (size_t c = 0; c < reference_.channel_count(); ++c) {
    double sum = 0.0;
    double squares = 0.0;
    for (size_t pixel = 0; pixel < static_cast<size_t>(n); ++pixel) {
      const double part =
          relative_square(reference_.variance(pixel, c), reference_.value(pixel, c));
      sum += part;
      squares += part * part;
    }
    noise_.push_back(sum / n);
    // Of normal noise, a squared error scatters by twice the variance's square; and the variance is
    // not known exactly.
    noise_deviations_.push_back(std::sqrt(squares * (2.0 + 2.0 / reference_.degrees_of_freedom)) /
                                n);
  }
  add_mean(noise_);
  add_mean(noise_deviations_);
}

void Study::add(Picture picture, const Label& label) {
  const auto channels = match(picture, reference_, {}, false);
  if (channels_.empty()) {
    channels_ = channels;
    channels_.emplace_back("all");
    measure_reference();
  }
  if (channels.size() + 1 != channels_.size()) {
    throw ImageError("other channels than the pictures before");
  }
  const Image& image = picture.image;
  const Sums sums = add_up(picture, reference_, {0, 0, image.width, image.height}, {});
  const auto is_equal = [](const Pool& pool) { return pool.squares == 0.0; };
  if (std::ranges::all_of(sums.image, is_equal)) {
    return left_out_.push_back(label.file +
                               ": left out, as it has the same pixels as the reference.");
  }
  if (share_samples(picture, reference_)) {
    return left_out_.push_back(label.file + ": left out, as it shares samples with the reference.");
  }
  Render render{label, {}};
  for (size_t c = 0; c < channels.size(); ++c) {
    render.errors.push_back(sums.image[c].relative / sums.image[c].pixels);
  }
  add_mean(render.errors);
  auto found = std::ranges::find(series_, label.series, &Series::name);
  if (found == series_.end()) found = series_.insert(found, Series{label.series, {}, {}});
  found->renders.push_back(std::move(render));
}

std::vector<Series> Study::series() const {
  if (series_.empty()) {
    throw ImageError(fmt::format("no picture could be held against the reference\n{}",
                                 fmt::join(left_out_, "\n")));
  }
  std::vector<Series> all = series_;
  for (Series& series : all) {
    std::map<std::pair<double, std::string>, std::vector<const Render*>> steps;
    for (const Render& r : series.renders) steps[{r.label.samples, r.label.step}].push_back(&r);
    for (const auto& [step, runs] : steps) series.points.push_back(point_of(runs, noise_));
    std::ranges::stable_sort(series.points, {}, [](const Point& p) {
      return std::pair(p.label.samples, p.label.seconds);
    });
  }
  return all;
}

Convergence Study::convergence(const Series& series, size_t channel) const {
  std::vector<Observation> observations;
  for (const Render& r : series.renders) {
    if (r.label.samples > 0.0) observations.push_back({r.label.samples, r.errors[channel]});
  }
  Convergence result{fit_power_law(observations), {}, {}};
  const Interval& floor = result.floor = result.law.floor;
  const double own = 2.0 * noise_deviations_[channel];
  const double rest = floor.value - noise_[channel];
  const double low = rest - std::hypot(floor.value - floor.low, own);
  const double high = rest + std::hypot(floor.high - floor.value, own);
  result.stops = rest > 2.0 * (rest - low) && falls_slowly(series.points, channel);
  if (!result.stops) result.law = fit_power_law(observations, noise_[channel]);
  // Where no power law fits, the bias is at least not larger than the last point's error.
  const Point& last = series.points.back();
  const double most = high > 0.0 ? high : last.errors[channel] + 2.0 * last.deviations[channel];
  const auto root = [](double square) {
    return std::copysign(std::sqrt(std::abs(square)), square);
  };
  result.bias = {root(rest), root(low), root(most)};
  return result;
}

}  // namespace plumb
