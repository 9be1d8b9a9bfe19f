// SPDX-License-Identifier: Apache-2.0

#include "compare/equivalence.h"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>

namespace plumb {

namespace math = boost::math;

namespace {

// Of the mean of the pixels' differences, by their scatter around it.
double paired_standard_error(const Pool& pool) {
  if (pool.pixels < 2.0) return std::sqrt(pool.squares);
  const double sum = pool.test - pool.reference;
  const double scatter = std::max(pool.squares - sum * sum / pool.pixels, 0.0);
  return std::sqrt(scatter / (pool.pixels * (pool.pixels - 1.0)));
}

}  // namespace

const char* to_string(Verdict verdict) {
  constexpr const char* words[] = {"same", "different", "trouble", "inconclusive"};
  return words[static_cast<size_t>(verdict)];
}

double critical_value(double false_alarm, double tests) {
  const math::normal normal;
  const double k = 1.0 / (4.0 * cdf(complement(normal, std::sqrt(2.0))));
  return quantile(complement(normal, std::min(0.5, false_alarm / tests / (2.0 * k))));
}

double cautious_variance(double test, double reference, double noise_ratio) {
  return std::max(test, reference * noise_ratio) * (1.0 + 1.0 / noise_ratio);
}

void Criterion::judge(Estimate& e) const {
  const double size = std::abs(e.difference);
  e.excess = (size - floor) / (tolerance + e.margin);
  e.verdict = Verdict::inconclusive;
  if (size + floor + e.margin <= tolerance) e.verdict = Verdict::same;
  if (size - floor - e.margin > tolerance) e.verdict = Verdict::different;
}

// Noise shrinks with the root of the number of samples. What may be noise of the difference itself
// will shrink as the margin does.
double Criterion::samples_factor(const Estimate& e) const {
  if (e.verdict != Verdict::inconclusive) return 1.0;
  const double size = std::abs(e.difference);
  const bool is_noise = size < 3.0 * e.standard_error;
  const double present = e.margin + (is_noise ? size : 0.0);
  const double room = is_noise ? tolerance - floor : std::abs(tolerance - size) - floor;
  return room > 0.0 ? present * present / (room * room) : std::numeric_limits<double>::infinity();
}

double confidence(const Pool& pool, double false_alarm) {
  const double variance = pool.test_variance + pool.reference_variance;
  if (variance == 0.0) return 0.0;
  const math::students_t student(variance * variance / pool.fourth);
  return quantile(complement(student, false_alarm / 2.0)) * std::sqrt(variance) / pool.pixels;
}

double paired_confidence(const Pool& pool, double false_alarm) {
  const math::students_t student(std::max(pool.pixels - 1.0, 1.0));
  return quantile(complement(student, false_alarm / 2.0)) * paired_standard_error(pool);
}

double unseen_margin(double brightest, double samples, double false_alarm) {
  return 7.0 / 3.0 * brightest * std::log(2.0 / false_alarm) / samples;
}

Estimate Criterion::estimate(const Pool& pool, double critical) const {
  Estimate result;
  const double n = pool.pixels;
  result.test = pool.test / n;
  result.reference = pool.reference / n;
  result.difference = result.test - result.reference;
  result.visible = tolerance + floor;
  if (knows_noise) {
    // Equal pixels have the same samples, even if they don't say so.
    const bool paired = is_paired || pool.squares == 0.0;
    const double claimed = pool.test_variance + pool.reference_variance;
    const double cautious =
        paired ? pool.squares
               : cautious_variance(pool.test_variance, pool.reference_variance, noise_ratio);
    result.standard_error = paired ? paired_standard_error(pool) : std::sqrt(claimed) / n;
    result.margin = critical * std::sqrt(std::max(cautious, pool.squares)) / n;
    // A bias b adds n b^2 to the squares, so that fewer than critical^2 pixels never show it.
    const double room = n - critical * critical;
    static const double certainty = quantile(math::normal(), 0.95);
    result.visible += room > 0.0 ? std::sqrt(cautious / n) * (critical / std::sqrt(room)) +
                                       certainty * result.standard_error
                                 : std::numeric_limits<double>::infinity();
  }
  judge(result);
  if (pool.squares == 0.0) result.verdict = Verdict::same;
  return result;
}

}  // namespace plumb
