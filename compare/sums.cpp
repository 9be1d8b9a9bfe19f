// SPDX-License-Identifier: Apache-2.0

#include "compare/sums.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>

#include "images/relative_error.h"

namespace plumb {
namespace {

int block_columns(const Window& window) { return (window.width + block_side - 1) / block_side; }
int block_rows(const Window& window) { return (window.height + block_side - 1) / block_side; }

}  // namespace

PixelPair mean_pair(const Picture& test, const Picture& reference, size_t pixel) {
  PixelPair sum;
  for (size_t c = 0; c < test.averaged; ++c) {
    const PixelPair pair = pixel_pair(test, reference, pixel, c);
    sum.test += pair.test;
    sum.reference += pair.reference;
    sum.test_variance += std::sqrt(pair.test_variance);
    sum.reference_variance += std::sqrt(pair.reference_variance);
  }
  const auto n = static_cast<double>(test.averaged);
  return {sum.test / n, sum.reference / n, sum.test_variance * sum.test_variance / (n * n),
          sum.reference_variance * sum.reference_variance / (n * n)};
}

void Pool::add(const PixelPair& pair, const Picture& t, const Picture& r, double count) {
  const double error = std::abs(pair.difference());
  pixels += count;
  test += count * pair.test;
  reference += count * pair.reference;
  test_variance += count * pair.test_variance;
  reference_variance += count * pair.reference_variance;
  squares += count * error * error;
  fourth += count * (pair.test_variance * pair.test_variance / t.degrees_of_freedom +
                     pair.reference_variance * pair.reference_variance / r.degrees_of_freedom);
  absolute += count * error;
  relative += relative_square(count * error * error, pair.reference);
  symmetric +=
      count * 2.0 * error / (std::abs(pair.test) + std::abs(pair.reference) + relative_epsilon);
}

void Pool::operator+=(const Pool& other) {
  for (const auto member : {&Pool::pixels, &Pool::test, &Pool::reference, &Pool::test_variance,
                            &Pool::squares, &Pool::reference_variance, &Pool::fourth,
                            &Pool::absolute, &Pool::relative, &Pool::symmetric}) {
    this->*member += other.*member;
  }
}

std::vector<Pool> Sums::blocks_of(size_t channel) const {
  std::vector<Pool> pools;
  for (size_t i = channel; i < blocks.size(); i += image.size()) pools.push_back(blocks[i]);
  return pools;
}

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

Window block_window(const Window& window, int block) {
  const int x = block % block_columns(window) * block_side;
  const int y = block / block_columns(window) * block_side;
  return {window.x + x, window.y + y, std::min(block_side, window.width - x),
          std::min(block_side, window.height - y)};
}

Sums add_up(const Picture& test, const Picture& reference, const Window& window,
            const Regions& regions) {
  const size_t pools = test.channel_count() + 1;  // of a unit
  Sums sums;
  sums.image.resize(pools);
  sums.blocks.resize(static_cast<size_t>(block_columns(window) * block_rows(window)) * pools);
  const auto add_block = [&](int block, std::vector<Pool>& in_regions) {
    Pool* const pool = &sums.blocks[static_cast<size_t>(block) * pools];
    for_each_pixel(block_window(window, block), [&](int x, int y) {
      const size_t pixel = test.image.pixel(x, y);
      if (!regions.hold(pixel)) return;
      const int region = regions.of_pixel.empty() ? -1 : regions.of_pixel[pixel];
      for (size_t c = 0; c < pools; ++c) {
        const PixelPair pair = pixel_pair(test, reference, pixel, c);
        pool[c].add(pair, test, reference);
        if (region < 0) continue;
        in_regions[static_cast<size_t>(region) * pools + c].add(pair, test, reference);
      }
    });
  };
  // In an order that doesn't depend on the number of threads.
  sums.regions = tbb::parallel_deterministic_reduce(
      tbb::blocked_range<int>(0, block_columns(window) * block_rows(window), 1024),
      std::vector<Pool>(regions.names.size() * pools),
      [&](const tbb::blocked_range<int>& blocks, std::vector<Pool> in_regions) {
        for (int b = blocks.begin(); b < blocks.end(); ++b) add_block(b, in_regions);
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
