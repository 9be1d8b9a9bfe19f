// SPDX-License-Identifier: Apache-2.0

#include "cli/suspect_score.h"

#include <algorithm>
#include <cmath>

#include "compare/sums.h"

namespace plumb::cli {

SuspectScore::SuspectScore(const Picture& test, const Picture& healthy, bool by_neighbours)
    : test_(test),
      yardstick_(test, healthy),
      values_(3.0 * static_cast<double>(test.image.pixel(0, test.image.height))) {
  double clearest = 0.0;
  for (const int side : {block_side, 1}) {
    const double noise = by_neighbours ? 0.0 : yardstick_.noise(test, side);
    const double all = yardstick_.squares(test, healthy, side) - noise;
    const double clear = all / deviation(side);
    if (clear <= clearest) continue;
    clearest = clear;
    side_ = side;
    noise_ = noise;
    all_ = all;
  }
}

void SuspectScore::measure(Suspect& suspect, const Picture& model) const {
  const double penalty = penalty_of(suspect);
  suspect.blocks = yardstick_.squares(test_, model, block_side) + penalty;
  suspect.pixels = yardstick_.squares(test_, model, 1) + penalty;
  suspect.blocks_error = deviation(block_side, model);
  suspect.pixels_error = deviation(1, model);
  const double left = suspect.*what_counts() - penalty - noise_;
  suspect.explained = std::clamp(1.0 - left / all_, 0.0, 1.0);
}

Yardstick::Factor SuspectScore::best_factor(const Picture& model) const {
  return yardstick_.best_factor(test_, model);
}

double SuspectScore::penalty_of(const Suspect& suspect) const {
  double choices = 0.0;
  for (const Planting& p : suspect.plantings) {
    choices += description(p.fault).numbers.empty() ? 1.0 : 2.0;
  }
  return choices * std::log(values_);
}

double SuspectScore::deviation(int side) const { return std::sqrt(2.0 * values_) / side; }

double SuspectScore::deviation(int side, const Picture& model) const {
  return deviation(side) * (1.0 + yardstick_.noise(model, side) * side * side / values_);
}

}  // namespace plumb::cli
