// SPDX-License-Identifier: Apache-2.0

#include "renderer/film.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "images/relative_error.h"

namespace plumb {

Film::Film(const Window& window) : window_(window), sums_(size_t(pixel_count()) * replicates * 3) {}

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

void Film::add_sums(int replicate, int64_t samples, const std::vector<float>& values,
                    double weight) {
  for (size_t i = 0; i < values.size(); ++i) {
    sums_[index_of(i, replicate)].add(weight * double{values[i]}, grid_);
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
  const ExactSum* sums = &sums_[size_t(pixel) * replicates * 3];
  const auto total = static_cast<double>(samples_per_pixel());
  Moments result;
  if (total == 0.0) return result;
  for (size_t c = 0; c < 3; ++c) {
    double mean = 0.0;
    for (size_t r = 0; r < replicates; ++r) mean += sums[r * 3 + c].value() / total;
    double scatter = 0.0;
    double weights = 0.0;
    for (size_t r = 0; r < replicates; ++r) {
      if (counts_[r] == 0) continue;
      const auto n = static_cast<double>(counts_[r]);
      const double weight = n * n / (total * std::max(total - 2.0 * n, 1e-9));
      const double off = sums[r * 3 + c].value() / n - mean;
      scatter += weight * off * off;
      weights += weight;
    }
    result.mean[c] = static_cast<float>(mean);
    if (knows_variance()) result.variance[c] = static_cast<float>(scatter / (1.0 + weights));
  }
  return result;
}

std::vector<float> Film::collect(std::array<float, 3> Moments::* part) const {
  std::vector<float> values;
  values.reserve(size_t(pixel_count()) * 3);
  for (int64_t p = 0; p < pixel_count(); ++p) {
    const Moments pixel = moments(p);
    values.insert(values.end(), (pixel.*part).begin(), (pixel.*part).end());
  }
  return values;
}

double Film::relative_error() const {
  if (!knows_variance()) return std::numeric_limits<double>::infinity();
  RelativeError error;
  for (int64_t p = 0; p < pixel_count(); ++p) {
    const auto [mean, variance] = moments(p);
    for (size_t c = 0; c < 3; ++c) error.add(variance[c], mean[c]);
  }
  return error.value();
}

template <class Pick>
std::vector<float> Film::collect_sums(int replicate, Pick pick) const {
  std::vector<float> values(size_t(pixel_count()) * 3);
  for (size_t i = 0; i < values.size(); ++i) values[i] = pick(sums_[index_of(i, replicate)]);
  return values;
}

std::vector<float> Film::replicate_mean(int replicate) const {
  const auto n = static_cast<double>(counts_[size_t(replicate)]);
  return collect_sums(replicate, [n](const ExactSum& sum) { return float(sum.value() / n); });
}

std::vector<float> Film::replicate_term(int replicate, size_t term) const {
  return collect_sums(replicate, [term](const ExactSum& sum) { return sum.terms()[term]; });
}

}  // namespace plumb
