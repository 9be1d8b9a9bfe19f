// SPDX-License-Identifier: Apache-2.0

// Sums that do not depend on the order of what is added, nor on how it was split: parts of a render
// give the bits of the whole.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace plumb {

// The finest part of a number that a sum keeps. Of 2^25 numbers whose sum is less than 2^37
// brightnesses, what is left out of each is less than 2^-45 brightnesses: float32 of a millionth of
// the brightness keeps every bit. Beyond that, sums are those of double precision, and of the
// order.
class SumGrid {
 public:
  // `brightness` is about the largest number; of it, only the power of two counts. Where it is 0,
  // all that is added is.
  explicit SumGrid(double brightness = 1.0)
      : high_(std::exp2(std::ilogb(std::clamp(brightness, 1e-200, 1e200)) - 16) * to_integer),
        low_(high_ * std::exp2(-29.0)) {}

  double high(double x) const { return (x + high_) - high_; }
  double low(double x) const { return (x + low_) - low_; }

 private:
  // 2^52 and half of it: to add and subtract it rounds to integers, and negative ones, too.
  static constexpr double to_integer = 6755399441055744.0;
  double high_;
  double low_;
};

// The numbers are split at a bit as in "accurate summation by extraction" of Rump, Ogita and Oishi
// (SIAM Journal on Scientific Computing 31(1), 2008): both parts' sums are exact.
class ExactSum {
 public:
  void add(double x, const SumGrid& grid) {
    const double high = grid.high(x);
    high_ += high;
    low_ += grid.low(x - high);
  }

  double value() const { return high_ + low_; }

  // Numbers whose sum it is, exactly: adding them to a sum of the same grid adds this one.
  std::array<float, 4> terms() const {
    std::array<float, 4> terms{};
    double rest = high_, rounding = low_;
    for (float& term : terms) {
      // The sum of the two, and what its rounding left out (Knuth's).
      const double sum = rest + rounding;
      const double added = sum - rest;
      rounding = (rest - (sum - added)) + (rounding - added);
      term = static_cast<float>(sum);
      rest = sum - double{term};
    }
    return terms;
  }

 private:
  double high_ = 0.0;
  double low_ = 0.0;
};

}  // namespace plumb
