// SPDX-License-Identifier: Apache-2.0

// How an error falls with the number of samples.
#pragma once

#include <optional>
#include <vector>

namespace plumb {

// The samples per pixel of a render and its mean squared error, absolute or relative.
struct Observation {
  double samples = 0;
  double error = 0;
};

// An estimate and its 95 % confidence interval.
struct Interval {
  double value = 0, low = 0, high = 0;
};

// error(N) = scale N^-exponent + floor. The first term is noise; the floor remains however many
// samples are taken. An estimated floor may be negative, by chance.
struct PowerLaw {
  double scale = 0;
  Interval exponent, floor;

  double noise(double samples) const;  // the first term
};

// Fits by weighted least squares. The mean square of many pixels' normal errors, whose expectation
// is f, has a variance proportional to f^2 - floor^2. It is larger by the factor 1 + tail / N where
// rare bright samples make the errors of few samples abnormal. The weights are the inverse of this
// variance; the residuals tell its scale and, by their likelihood, the tail. The intervals are
// profile-t intervals: all exponents (or floors) for which the smallest residual sum of squares
// stays below the bound that Student's t sets (Bates and Watts, "Nonlinear Regression Analysis and
// Its Applications", 1988, ch. 6). A straight line through the logarithms would underestimate the
// exponent as soon as there is a floor.
//
// If `floor` is given, the floor is known to be that. Throws std::invalid_argument unless there are
// at least four observations, with three different numbers of samples, and unless all errors are
// above 0 and not all the same.
PowerLaw fit_power_law(const std::vector<Observation>& observations,
                       const std::optional<double>& floor = {});

}  // namespace plumb
