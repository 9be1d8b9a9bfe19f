// SPDX-License-Identifier: Apache-2.0

#include "compare/power_law.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/tools/minima.hpp>
#include <boost/math/tools/roots.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <stdexcept>

namespace plumb {
namespace {

constexpr double least_exponent = 0.02;
constexpr double most_exponent = 4.0;

// Weighted least squares. Given an exponent, the power law is a straight line in
// x = (N / unit)^-exponent, whose intercept is the floor.
class Regression {
 public:
  Regression(const std::vector<Observation>& observations, std::optional<double> floor)
      : observations_(observations), floor_(floor) {
    double logarithms = 0.0;
    for (const Observation& o : observations) {
      logarithms += std::log(o.samples);
      weights_.push_back(1.0 / (o.error * o.error));
    }
    unit_ = std::exp(logarithms / static_cast<double>(observations.size()));
  }

  struct Line {
    double exponent, slope, floor;
    double residual_squares;  // weighted sum
  };

  Line fit_line(double exponent) const {
    double w = 0, wx = 0, wy = 0, wxx = 0, wxy = 0;
    for (size_t i = 0; i < observations_.size(); ++i) {
      const double here = x(observations_[i].samples, exponent);
      const double weighted = weights_[i] * here;
      w += weights_[i];
      wx += weighted;
      wy += weights_[i] * observations_[i].error;
      wxx += weighted * here;
      wxy += weighted * observations_[i].error;
    }
    const double slope =
        floor_ ? (wxy - wx * *floor_) / wxx : (w * wxy - wx * wy) / (w * wxx - wx * wx);
    Line line{exponent, slope, floor_.value_or((wy - slope * wx) / w), 0.0};
    for (size_t i = 0; i < observations_.size(); ++i) {
      const double residual =
          observations_[i].error - slope * x(observations_[i].samples, exponent) - line.floor;
      line.residual_squares += weights_[i] * residual * residual;
    }
    return line;
  }

  // With the exponent for which the residual sum of squares is smallest.
  Line best_line() const {
    const auto squares = [&](double logarithm) {
      return fit_line(std::exp(logarithm)).residual_squares;
    };
    const auto [logarithm, least] = boost::math::tools::brent_find_minima(
        squares, std::log(least_exponent), std::log(most_exponent), 40);
    return fit_line(std::exp(logarithm));
  }

  // Sets the weights to the inverse variances that the line expects.
  void reweight(const Line& line, double tail) {
    const double floor = std::max(line.floor, 0.0);
    for (size_t i = 0; i < observations_.size(); ++i) {
      const double samples = observations_[i].samples;
      // Chance makes even lines that rise.
      const double noise =
          std::max(line.slope * x(samples, line.exponent), 1e-3 * observations_[i].error);
      weights_[i] = 1.0 / (noise * (noise + 2.0 * floor) * (1.0 + tail / samples));
    }
  }

  // The logarithm, but for a constant, of the likelihood of normal residuals with these weights,
  // at the most likely common scale of their variances.
  double log_likelihood(const Line& line) const {
    double sum = 0.0;
    for (const double weight : weights_) sum += std::log(weight);
    const auto n = static_cast<double>(weights_.size());
    return (sum - n * std::log(line.residual_squares)) / 2.0;
  }

  Regression with_floor(double floor) const {
    Regression result = *this;
    result.floor_ = floor;
    return result;
  }

  double unit() const { return unit_; }

 private:
  double x(double samples, double exponent) const { return std::pow(samples / unit_, -exponent); }

  const std::vector<Observation>& observations_;
  std::optional<double> floor_;
  std::vector<double> weights_;
  double unit_;  // the geometric mean of the numbers of samples, so that x is about 1
};

// An end of a profile-t confidence interval: where `excess`, by which the residual sum of squares
// at the other parameters' optimum exceeds what Student's t allows, becomes positive. Searched for
// from `estimate` in steps that double, `step` first; `limit` if it is not met before.
double profile_bound(const std::function<double(double)>& excess, double estimate, double step,
                     double limit) {
  double inside = estimate;
  for (;; step *= 2.0) {
    double outside = estimate + step;
    if ((step > 0.0) == (outside > limit)) outside = limit;
    if (excess(outside) > 0.0) {
      std::uintmax_t steps = 60;
      const auto [a, b] = boost::math::tools::toms748_solve(
          excess, std::min(inside, outside), std::max(inside, outside),
          boost::math::tools::eps_tolerance<double>(20), steps);
      return (a + b) / 2.0;
    }
    if (outside == limit) return limit;
    inside = outside;
  }
}

// Iteratively reweighted least squares: the weights follow from the fitted line.
Regression::Line fit_reweighted(Regression& regression, double tail) {
  for (int round = 0; round < 8; ++round) regression.reweight(regression.best_line(), tail);
  return regression.best_line();
}

// The same with the tail of the largest likelihood.
Regression::Line fit_reweighted(Regression& regression) {
  double best_tail = 0.0;
  double best = -std::numeric_limits<double>::infinity();
  for (const double tail : {0.0, 1.0, 4.0, 16.0, 64.0, 256.0, 1024.0}) {
    const double likelihood = regression.log_likelihood(fit_reweighted(regression, tail));
    if (likelihood > best) best = likelihood, best_tail = tail;
  }
  return fit_reweighted(regression, best_tail);
}

}  // namespace

double PowerLaw::noise(double samples) const { return scale * std::pow(samples, -exponent.value); }

PowerLaw fit_power_law(const std::vector<Observation>& observations,
                       const std::optional<double>& floor) {
  std::set<double> counts;
  for (const Observation& o : observations) counts.insert(o.samples);
  if (counts.size() < 3 || observations.size() < 4) {
    throw std::invalid_argument(
        "a fit needs four pictures or more, with three different numbers of samples");
  }
  const auto is_fit = [](const Observation& o) { return o.error > 0.0 && std::isfinite(o.error); };
  if (!std::ranges::all_of(observations, is_fit)) {
    throw std::invalid_argument("a fit needs errors above 0");
  }
  const auto [least, largest] = std::ranges::minmax(observations, {}, &Observation::error);
  if (least.error == largest.error) {
    throw std::invalid_argument("its error is the same with any number of samples");
  }
  Regression regression(observations, floor);
  const bool shows_scatter = observations.size() >= counts.size() + 10;
  const Regression::Line line =
      shows_scatter ? fit_reweighted(regression) : fit_reweighted(regression, 0.0);

  const double freedom = static_cast<double>(observations.size()) - (floor ? 2.0 : 3.0);
  const double t = quantile(complement(boost::math::students_t(freedom), 0.025));
  const double allowed = line.residual_squares * (1.0 + t * t / freedom);
  const auto exponent_excess = [&](double exponent) {
    return regression.fit_line(exponent).residual_squares - allowed;
  };
  const double p = line.exponent;
  PowerLaw law{line.slope * std::pow(regression.unit(), p),
               {p, profile_bound(exponent_excess, p, -1e-3, least_exponent),
                profile_bound(exponent_excess, p, 1e-3, most_exponent)},
               {line.floor, line.floor, line.floor}};
  if (floor) return law;
  const auto floor_excess = [&](double other) {
    return regression.with_floor(other).best_line().residual_squares - allowed;
  };
  const double step = 1e-3 * least.error;
  law.floor.low = profile_bound(floor_excess, line.floor, -step, -largest.error);
  law.floor.high = profile_bound(floor_excess, line.floor, step, largest.error);
  return law;
}

}  // namespace plumb
