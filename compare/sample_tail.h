// SPDX-License-Identifier: Apache-2.0

// How heavy the tail of the samples' distribution is: how much of the noise rare bright ones make.
#pragma once

#include <cstdint>
#include <vector>

#include "images/image.h"

namespace plumb {

// How single samples scatter around the means of their pixels, over all pixels.
struct SampleTail {
  double fireflies = 0.0;  // the share of the variance that the worst thousandth of samples has
  double kurtosis = 0.0;   // 3 for a normal distribution; 0 if nothing scatters
  int64_t unfit = 0;       // values that are negative or not finite
  double brightest = 0.0;  // radiance, the mean of R, G and B
};

// Collects pictures of one sample per pixel.
class SampleTailEstimator {
 public:
  // `means` are of all pixels, R G B each, as are the samples.
  explicit SampleTailEstimator(const std::vector<float>& means);
  void add(const std::vector<float>& samples);
  SampleTail estimate();

 private:
  std::vector<double> means_;
  std::vector<double> squares_;  // of the deviations from the means
  SampleTail tail_;
};

// The brightest sample that a picture may hold whose samples are not known: as bright as would
// explain how far a pixel's replicates lie apart. Roulette can make it brighter than any lamp. The
// image has R G B variance.R variance.G variance.B; without variances the result is 0.
double brightest_by_scatter(const Image& image, int replicates, double samples_of_replicate);

}  // namespace plumb
