// SPDX-License-Identifier: Apache-2.0

// Sums of two pictures and of their differences over blocks, regions and all pixels.
#pragma once

#include <cstddef>
#include <vector>

#include "compare/picture.h"

namespace plumb {

constexpr int block_side = 8;

// What the two pictures say about one channel of a pixel. The channel after the last one is the
// mean over the averaged channels; because the correlation between the noise of a pixel's channels
// is not known, its standard deviation is the largest possible one, which is the mean of the
// standard deviations.
struct PixelPair {
  double test = 0, reference = 0, test_variance = 0, reference_variance = 0;
  double difference() const { return test - reference; }
};
PixelPair mean_pair(const Picture& test, const Picture& reference, size_t pixel);
inline PixelPair pixel_pair(const Picture& test, const Picture& reference, size_t pixel,
                            size_t channel) {
  if (channel >= test.channel_count()) return mean_pair(test, reference, pixel);
  const double x = test.value(pixel, channel), r = reference.value(pixel, channel);
  return {x, r, test.variance(pixel, channel, r), reference.variance(pixel, channel, x)};
}

// Sums over pixels, with x the test, r the reference, V their variances.
struct Pool {
  double pixels = 0, test = 0, reference = 0, test_variance = 0, reference_variance = 0;
  double squares = 0;    // (x - r)^2
  double fourth = 0;     // V^2 / degrees of freedom, for Welch and Satterthwaite
  double absolute = 0;   // |x - r|
  double relative = 0;   // (x - r)^2 / (r^2 + relative_epsilon)
  double symmetric = 0;  // 2 |x - r| / (|x| + |r| + relative_epsilon)

  double mean_reference() const { return reference / pixels; }

  // Adds a pixel `count` times: -1 takes it away.
  void add(const PixelPair& pair, const Picture& test, const Picture& reference, double count = 1);
  void operator+=(const Pool& other);
};

// Ordered by units (regions, or blocks row by row) and within each unit by channels, the last of
// which is the mean over the channels.
struct Sums {
  std::vector<Pool> image, regions, blocks;

  std::vector<Pool> blocks_of(size_t channel) const;
};

// Adds up the window's pixels that the regions hold.
Sums add_up(const Picture& test, const Picture& reference, const Window& window,
            const Regions& regions);

// Of an even number of values this is the larger one of the two in the middle; of none it is 0.
double median(std::vector<double> values);

// The pixels of a block of the window, which has less than block_side of them at an edge.
Window block_window(const Window& window, int block);

}  // namespace plumb
