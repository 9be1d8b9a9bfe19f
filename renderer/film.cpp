// SPDX-License-Identifier: Apache-2.0

#include "renderer/film.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "images/relative_error.h"

namespace plumb {

Film::Film(int width, int height)
    : width_(width), height_(height), sums_(size_t(pixel_count()) * replicates * 3, 0.0) {}

Film::Counts samples_per_replicate(const SampleRange& samples) {
  Film::Counts counts;
  for (int r = 0; r < Film::replicates; ++r) {
    // How many s with s mod replicates = r lie below a bound.
    const auto below = [r](int64_t bound) {
      return (bound - r + Film::replicates - 1) / Film::replicates;
    };
    counts[size_t(r)] = below(samples.last) - below(samples.first);
  }
  return counts;
}

void Film::end_pass(SampleRange samples) {
  sums_.swap(next_);
  const Counts added = plumb::samples_per_replicate(samples);
  std::ranges::transform(counts_, added, counts_.begin(), std::plus{});
}

void Film::add_mean(int replicate, int64_t samples, const std::vector<float>& mean) {
  for (int64_t p = 0; p < pixel_count(); ++p) {
    double* sum = &sums_[size_t(p * replicates + replicate) * 3];
    for (size_t c = 0; c < 3; ++c) {
      sum[c] += static_cast<double>(samples) * double{mean[size_t(p) * 3 + c]};
    }
  }
  counts_[size_t(replicate)] += samples;
}

int64_t Film::samples_per_pixel() const {
  return std::accumulate(counts_.begin(), counts_.end(), int64_t{0});
}

bool Film::knows_variance() const {
  return std::ranges::count_if(counts_, [](int64_t n) { return n > 0; }) >= 2;
}

// Unlike those of images/replicates.h, the replicates may have unequal shares. Replicate r has the
// share w_r of all samples and the mean x_r, of unknown variance s_r. The picture's mean m has
// variance V = sum w_r^2 s_r, and E (x_r - m)^2 = (1 - 2 w_r) s_r + V. Hence E sum a_r (x_r - m)^2
// = V (1 + sum a_r) for a_r = w_r^2 / (1 - 2 w_r), whatever the s_r are. With two replicates of
// equal share that is 0 / 0, whose limit is ((x_1 - x_2) / 2)^2.
Film::Moments Film::moments(int64_t pixel) const {
  const double* sums = &sums_[size_t(pixel) * replicates * 3];
  const auto total = static_cast<double>(samples_per_pixel());
  Moments result;
  if (total == 0.0) return result;
  for (size_t c = 0; c < 3; ++c) {
    double mean = 0.0;
    for (size_t r = 0; r < replicates; ++r) mean += sums[r * 3 + c] / total;
    double scatter = 0.0;
    double weights = 0.0;
    for (size_t r = 0; r < replicates; ++r) {
      if (counts_[r] == 0) continue;
      const auto n = static_cast<double>(counts_[r]);
      const double weight = n * n / (total * std::max(total - 2.0 * n, 1e-9));
      scatter += weight * (sums[r * 3 + c] / n - mean) * (sums[r * 3 + c] / n - mean);
      weights += weight;
    }
    result.mean[c] = mean;
    result.variance[c] = knows_variance() ? scatter / (1.0 + weights) : 0.0;
  }
  return result;
}

template <class Pick>
std::vector<float> Film::collect(Pick pick) const {
  std::vector<float> values;
  values.reserve(size_t(pixel_count()) * 3);
  for (int64_t p = 0; p < pixel_count(); ++p) {
    for (const double value : pick(moments(p))) values.push_back(static_cast<float>(value));
  }
  return values;
}

std::vector<float> Film::mean() const {
  return collect([](const Moments& m) { return m.mean; });
}
std::vector<float> Film::variance() const {
  return collect([](const Moments& m) { return m.variance; });
}

double Film::relative_error() const {
  if (!knows_variance()) return std::numeric_limits<double>::infinity();
  double sum = 0.0;
  for (int64_t p = 0; p < pixel_count(); ++p) {
    const auto [mean, variance] = moments(p);
    for (size_t c = 0; c < 3; ++c) sum += relative_square(variance[c], mean[c]);
  }
  return std::sqrt(sum / static_cast<double>(3 * pixel_count()));
}

std::vector<float> Film::replicate_mean(int replicate) const {
  const auto n = static_cast<double>(counts_[size_t(replicate)]);
  std::vector<float> values;
  values.reserve(size_t(pixel_count()) * 3);
  for (int64_t p = 0; p < pixel_count(); ++p) {
    const double* sum = &sums_[size_t(p * replicates + replicate) * 3];
    for (size_t c = 0; c < 3; ++c) values.push_back(static_cast<float>(sum[c] / n));
  }
  return values;
}

}  // namespace plumb
