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

// For one exponent at a time, what is left is a straight line in x = (N / unit)^-exponent.
class Fit {
 public:
  Fit(const std::vector<Observation>& observations, std::optional<double> floor)
      : observations_(observations), floor_(floor) {
    double logarithms = 0.0;
    for (const Observation& o : observations) {
      logarithms += std::log(o.samples);
      weights_.push_back(1.0 / (o.error * o.error));
    }
    unit_ = std::exp(logarithms / static_cast<double>(observations.size()));
  }

  struct Line {
    double slope, floor, squares;
  };

  double x(double samples, double exponent) const { return std::pow(samples / unit_, -exponent); }

  Line line(double exponent) const { return line(exponent, floor_); }

  Line line(double exponent, std::optional<double> floor) const {
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
        floor ? (wxy - wx * *floor) / wxx : (w * wxy - wx * wy) / (w * wxx - wx * wx);
    const double found = floor.value_or((wy - slope * wx) / w);
    return {slope, found, squares(exponent, slope, found)};
  }

  // Weighs by what the line expects.
  void weigh(double exponent, const Line& line, double tail) {
    const double floor = std::max(line.floor, 0.0);
    for (size_t i = 0; i < observations_.size(); ++i) {
      const double samples = observations_[i].samples;
      // Chance makes even lines that rise.
      const double noise =
          std::max(line.slope * x(samples, exponent), 1e-3 * observations_[i].error);
      weights_[i] = 1.0 / (noise * (noise + 2.0 * floor) * (1.0 + tail / samples));
    }
  }

  // The logarithm, but for a constant, of how likely normal residuals of these weights are.
  double likelihood(double exponent) const {
    double sum = 0.0;
    for (const double weight : weights_) sum += std::log(weight);
    const auto n = static_cast<double>(weights_.size());
    return (sum - n * std::log(line(exponent).squares)) / 2.0;
  }

  double unit() const { return unit_; }

 private:
  double squares(double exponent, double slope, double floor) const {
    double sum = 0.0;
    for (size_t i = 0; i < observations_.size(); ++i) {
      const double rest =
          observations_[i].error - slope * x(observations_[i].samples, exponent) - floor;
      sum += weights_[i] * rest * rest;
    }
    return sum;
  }

  const std::vector<Observation>& observations_;
  std::optional<double> floor_;
  std::vector<double> weights_;
  double unit_;
};

// The exponent with the least squares.
template <typename Squares>
double best_exponent(Squares squares) {
  const auto at = [&](double logarithm) { return squares(std::exp(logarithm)); };
  const auto [logarithm, least] = boost::math::tools::brent_find_minima(
      at, std::log(least_exponent), std::log(most_exponent), 40);
  return std::exp(logarithm);
}

// Where `excess` becomes positive, from `best` in steps that double, `step` first; not beyond
// `last`.
double edge(const std::function<double(double)>& excess, double best, double step, double last) {
  double inside = best;
  for (;; step *= 2.0) {
    double outside = best + step;
    if ((step > 0.0) == (outside > last)) outside = last;
    if (excess(outside) > 0.0) {
      std::uintmax_t steps = 60;
      const auto [a, b] = boost::math::tools::toms748_solve(
          excess, std::min(inside, outside), std::max(inside, outside),
          boost::math::tools::eps_tolerance<double>(20), steps);
      return (a + b) / 2.0;
    }
    if (outside == last) return last;
    inside = outside;
  }
}

// The exponent of the best line, by weights that follow from it.
double settle(Fit& fit, double tail) {
  double exponent = 1.0;
  for (int round = 0; round < 8; ++round) {
    exponent = best_exponent([&](double p) { return fit.line(p).squares; });
    fit.weigh(exponent, fit.line(exponent), tail);
  }
  return best_exponent([&](double p) { return fit.line(p).squares; });
}

// The same for the likeliest tail.
double settle(Fit& fit) {
  double best_tail = 0.0;
  double best = -std::numeric_limits<double>::infinity();
  for (const double tail : {0.0, 1.0, 4.0, 16.0, 64.0, 256.0, 1024.0}) {
    const double likelihood = fit.likelihood(settle(fit, tail));
    if (likelihood > best) best = likelihood, best_tail = tail;
  }
  return settle(fit, best_tail);
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
  Fit fit(observations, floor);
  const bool shows_scatter = observations.size() >= counts.size() + 10;
  const double p = shows_scatter ? settle(fit) : settle(fit, 0.0);
  const Fit::Line line = fit.line(p);

  const double freedom = static_cast<double>(observations.size()) - (floor ? 2.0 : 3.0);
  const double t = quantile(complement(boost::math::students_t(freedom), 0.025));
  const double most = line.squares * (1.0 + t * t / freedom);
  const auto by_exponent = [&](double exponent) { return fit.line(exponent).squares - most; };
  PowerLaw law{
      line.slope * std::pow(fit.unit(), p),
      {p, edge(by_exponent, p, -1e-3, least_exponent), edge(by_exponent, p, 1e-3, most_exponent)},
      {line.floor, line.floor, line.floor}};
  if (floor) return law;
  const auto by_floor = [&](double trial) {
    const auto squares = [&](double exponent) { return fit.line(exponent, trial).squares; };
    return squares(best_exponent(squares)) - most;
  };
  const auto [least, largest] = std::ranges::minmax(observations, {}, &Observation::error);
  const double step = 1e-3 * least.error;
  law.floor.low = edge(by_floor, line.floor, -step, -largest.error);
  law.floor.high = edge(by_floor, line.floor, step, largest.error);
  return law;
}

}  // namespace plumb
