// SPDX-License-Identifier: Apache-2.0

#include "compare/sample_tail.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace plumb {
namespace {

std::vector<double> gray(const std::vector<float>& rgb) {
  std::vector<double> values;
  for (size_t i = 0; i < rgb.size(); i += 3) {
    values.push_back((double{rgb[i]} + double{rgb[i + 1]} + double{rgb[i + 2]}) / 3.0);
  }
  return values;
}

}  // namespace

SampleTailEstimator::SampleTailEstimator(const std::vector<float>& means) : means_(gray(means)) {}

void SampleTailEstimator::add(const std::vector<float>& samples) {
  tail_.unfit += std::ranges::count_if(
      samples, [](float value) { return !(value >= 0.0F && std::isfinite(value)); });
  const std::vector<double> values = gray(samples);
  for (size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i] - means_[i])) continue;
    tail_.brightest = std::max(tail_.brightest, values[i]);
    squares_.push_back(std::pow(values[i] - means_[i], 2));
  }
}

SampleTail SampleTailEstimator::estimate() {
  const double sum = std::reduce(squares_.begin(), squares_.end(), 0.0);
  if (sum == 0.0) return tail_;
  const double fourth = std::inner_product(squares_.begin(), squares_.end(), squares_.begin(), 0.0);
  tail_.kurtosis = fourth * static_cast<double>(squares_.size()) / (sum * sum);
  const auto worst = squares_.end() - std::max<std::ptrdiff_t>(1, std::ssize(squares_) / 1000);
  std::ranges::nth_element(squares_, worst);
  tail_.fireflies = std::accumulate(worst, squares_.end(), 0.0) / sum;
  return tail_;
}

double brightest_by_scatter(const Image& image, int replicates, double samples_of_replicate) {
  if (image.channels.size() < 6) return 0.0;
  double largest = 0.0;
  for (size_t i = 3; i < image.values.size(); i += 6) {
    largest = std::max(largest, double{*std::max_element(&image.values[i], &image.values[i] + 3)});
  }
  return samples_of_replicate * std::sqrt(largest * replicates * (replicates - 1));
}

}  // namespace plumb
