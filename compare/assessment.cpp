// SPDX-License-Identifier: Apache-2.0

#include "compare/assessment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "compare/equivalence.h"
#include "compare/sums.h"
#include "images/relative_error.h"

namespace plumb {
namespace {

// What differs by less, as a part of the mean, is rounding: of a hundred bounces in float.
constexpr double rounding = 1e-5;
// What a program without noise may be off, as a part of the mean.
constexpr double noiseless_tolerance = 0.01;
// A trial is noisy if the error of a picture with so many pixels needs longer to fall to 1 %.
constexpr double reasonable_seconds = 60.0;
constexpr double usual_pixels = 256.0 * 256.0;

// What noise alone may make of the difference of two averages. If the test is the darker one, it
// may have met none of some rare bright samples.
double margin(const Pool& pool, const Trial& trial, double false_alarm) {
  const double by_variance = confidence(pool, false_alarm);
  if (pool.test >= pool.reference) return by_variance;
  const Image& image = trial.picture.image;
  const double share = pool.pixels / static_cast<double>(image.pixel(0, image.height));
  return by_variance + unseen_margin(trial.brightest, trial.samples * share, false_alarm);
}

bool is_off(const Pool& pool, const Trial& trial, double mean, double false_alarm) {
  const bool knows_noise = trial.picture.knows_noise();
  const Criterion criterion{.tolerance = (knows_noise ? rounding : noiseless_tolerance) * mean};
  Estimate estimate{.difference = (pool.test - pool.reference) / pool.pixels};
  if (knows_noise) estimate.margin = margin(pool, trial, false_alarm);
  criterion.judge(estimate);
  return estimate.verdict == Verdict::different;
}

bool is_biased(const Sums& sums, const Trial& trial, double false_alarm) {
  const Pool& whole = sums.image.back();
  const double mean = whole.reference / whole.pixels;
  // Half of the false alarms for the picture, half for all of its blocks.
  const std::vector<Pool> blocks = sums.blocks_of(sums.image.size() - 1);
  const double alarm_of_block = false_alarm / 2.0 / static_cast<double>(blocks.size());
  return is_off(whole, trial, mean, false_alarm / 2.0) ||
         std::ranges::any_of(
             blocks, [&](const Pool& block) { return is_off(block, trial, mean, alarm_of_block); });
}

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
  result.cost = std::numeric_limits<double>::infinity();
  if (trial.picture.knows_noise()) {
    result.cost = trial.seconds * relative_square_error(trial.picture, truth);
    result.seconds_to_one_percent = result.cost / 1e-4 * usual_pixels / whole.pixels;
  }
  const bool is_noisy = result.seconds_to_one_percent > reasonable_seconds;
  result.outcome = is_biased(sums, trial, false_alarm) ? Outcome::biased
                   : is_noisy                          ? Outcome::noisy
                                                       : Outcome::holds;
  return result;
}

}  // namespace plumb
