// How an error falls with the number of samples.
#pragma once

#include <optional>
#include <vector>

namespace plumb {

// Of one render: its samples per pixel and its mean squared error, absolute or relative.
struct Observation {
  double samples = 0;
  double error = 0;
};

// An estimate and where, with 95 %, the truth is.
struct Interval {
  double value = 0, low = 0, high = 0;
};

// error(N) = scale N^-exponent + floor: the noise's part and what no number of samples removes. The
// floor may come out negative, by chance.
struct PowerLaw {
  double scale = 0;
  Interval exponent, floor;

  double noise(double samples) const;
};

// Least squares, relative to the scatter that the mean square of many pixels' normal errors has
// around their expectation f: its variance is proportional to f^2 - floor^2, and larger by a factor
// 1 + tail / N where rare bright samples make few of them abnormal. How large it is, and the
// likeliest tail, the residuals tell. The intervals are those where the least sum of squares for a
// given exponent (or floor) is not larger than Student's t allows (Bates and Watts, "Nonlinear
// Regression Analysis and Its Applications", 1988, ch. 6). A slope through logarithms would read
// less than the truth as soon as there is a floor.
//
// With a `floor`, that is known. Throws std::invalid_argument unless there are four observations
// with three different numbers of samples.
PowerLaw fit_power_law(const std::vector<Observation>& observations,
                       const std::optional<double>& floor = {});

}  // namespace plumb
