#include "compare/sums.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <span>

namespace plumb {
namespace {

int block_columns(const Window& window) { return (window.width + block_side - 1) / block_side; }
int block_rows(const Window& window) { return (window.height + block_side - 1) / block_side; }

void add(const Sample& s, const Picture& test, const Picture& reference, Pool& pool) {
  const double error = std::abs(s.difference());
  pool.pixels += 1.0;
  pool.test += s.test;
  pool.reference += s.reference;
  pool.test_variance += s.test_variance;
  pool.reference_variance += s.reference_variance;
  pool.squares += error * error;
  pool.fourth += s.test_variance * s.test_variance / test.degrees_of_freedom +
                 s.reference_variance * s.reference_variance / reference.degrees_of_freedom;
  pool.absolute += error;
  pool.relative += error * error / (s.reference * s.reference + epsilon);
  pool.symmetric += 2.0 * error / (std::abs(s.test) + std::abs(s.reference) + epsilon);
}

// The mean over the channels. How the noise of a pixel's channels is correlated is not known: the
// standard deviation of the mean is at most the mean of the standard deviations.
Sample mean(std::span<const Sample> channels) {
  Sample sum;
  for (const Sample& s : channels) {
    sum.test += s.test;
    sum.reference += s.reference;
    sum.test_variance += std::sqrt(s.test_variance);
    sum.reference_variance += std::sqrt(s.reference_variance);
  }
  const auto n = static_cast<double>(channels.size());
  return {sum.test / n, sum.reference / n, sum.test_variance * sum.test_variance / (n * n),
          sum.reference_variance * sum.reference_variance / (n * n)};
}

}  // namespace

Sample sample(const Picture& test, const Picture& reference, size_t pixel, size_t channel) {
  return {test.value(pixel, channel), reference.value(pixel, channel),
          test.variance(pixel, channel), reference.variance(pixel, channel)};
}

void Pool::operator+=(const Pool& other) {
  for (const auto member : {&Pool::pixels, &Pool::test, &Pool::reference, &Pool::test_variance,
                            &Pool::squares, &Pool::reference_variance, &Pool::fourth,
                            &Pool::absolute, &Pool::relative, &Pool::symmetric}) {
    this->*member += other.*member;
  }
}

Window block_window(const Window& window, int block) {
  const int x = block % block_columns(window) * block_side;
  const int y = block / block_columns(window) * block_side;
  return {window.x + x, window.y + y, std::min(block_side, window.width - x),
          std::min(block_side, window.height - y)};
}

Sums add_up(const Picture& test, const Picture& reference, const Window& window,
            const Regions& regions) {
  const size_t pools = test.values.size() + 1;  // of a unit
  Sums sums;
  sums.image.resize(pools);
  sums.blocks.resize(static_cast<size_t>(block_columns(window) * block_rows(window)) * pools);
  const auto add_block = [&](int block, std::vector<Sample>& samples,
                             std::vector<Pool>& in_regions) {
    Pool* const pool = &sums.blocks[static_cast<size_t>(block) * pools];
    const Window w = block_window(window, block);
    for (int y = w.y; y < w.y + w.height; ++y) {
      for (int x = w.x; x < w.x + w.width; ++x) {
        const size_t pixel = test.image.pixel(x, y);
        const int region = regions.of_pixel.empty() ? -1 : regions.of_pixel[pixel];
        for (size_t c = 0; c + 1 < pools; ++c) samples[c] = sample(test, reference, pixel, c);
        samples.back() = mean(std::span(samples).first(pools - 1));
        for (size_t c = 0; c < pools; ++c) {
          add(samples[c], test, reference, pool[c]);
          if (region < 0) continue;
          add(samples[c], test, reference, in_regions[static_cast<size_t>(region) * pools + c]);
        }
      }
    }
  };
  // In an order that doesn't depend on the number of threads.
  sums.regions = tbb::parallel_deterministic_reduce(
      tbb::blocked_range<int>(0, block_columns(window) * block_rows(window), 1024),
      std::vector<Pool>(regions.names.size() * pools),
      [&](const tbb::blocked_range<int>& blocks, std::vector<Pool> in_regions) {
        std::vector<Sample> samples(pools);
        for (int b = blocks.begin(); b < blocks.end(); ++b) add_block(b, samples, in_regions);
        return in_regions;
      },
      [](std::vector<Pool> a, const std::vector<Pool>& b) {
        for (size_t i = 0; i < a.size(); ++i) a[i] += b[i];
        return a;
      });
  for (size_t i = 0; i < sums.blocks.size(); ++i) sums.image[i % pools] += sums.blocks[i];
  return sums;
}

}  // namespace plumb
