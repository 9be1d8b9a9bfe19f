// SPDX-License-Identifier: Apache-2.0

// The relative error of a picture, whose formula is the same wherever one is measured or estimated.
#pragma once

namespace plumb {

// Is added to the square of the reference, so that an error in the dark stays finite.
constexpr double relative_epsilon = 0.01;

// A pixel's part of relMSE = mean (x - r)^2 / (r^2 + epsilon), with x the picture and r the
// reference: `square` is (x - r)^2 or its expectation, which is the variance where there's no bias.
inline double relative_square(double square, double reference) {
  return square / (reference * reference + relative_epsilon);
}

}  // namespace plumb
