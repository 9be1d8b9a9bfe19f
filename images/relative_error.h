// SPDX-License-Identifier: Apache-2.0

// The relative error of a picture, whose formula is the same wherever one is measured or estimated.
#pragma once

#include <cmath>
#include <cstdint>

namespace plumb {

// Is added to the square of the reference, so that an error in the dark stays finite.
constexpr double relative_epsilon = 0.01;

// A pixel's part of relMSE = mean (x - r)^2 / (r^2 + epsilon), with x the picture and r the
// reference: `square` is (x - r)^2 or its expectation, which is the variance where there's no bias.
inline double relative_square(double square, double reference) {
  return square / (reference * reference + relative_epsilon);
}

// Root mean square error of a picture, estimated: sqrt(mean of variance / (mean^2 + epsilon)) over
// pixels and channels, which are added in the order in which files have them. Of the same floats it
// has the same bits.
class RelativeError {
 public:
  void add(float variance, float mean) {
    sum_ += relative_square(double{variance}, double{mean});
    ++count_;
  }
  double value() const { return std::sqrt(sum_ / static_cast<double>(count_)); }

 private:
  double sum_ = 0.0;
  int64_t count_ = 0;
};

}  // namespace plumb
