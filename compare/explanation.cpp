// SPDX-License-Identifier: Apache-2.0

#include "compare/explanation.h"

#include <algorithm>
#include <cmath>

#include "compare/report.h"
#include "compare/sums.h"

namespace plumb {
namespace {

Window whole(const Picture& picture) { return {0, 0, picture.image.width, picture.image.height}; }

double difference(const Picture& a, const Picture& b, int x, int y, size_t channel) {
  const size_t pixel = a.image.pixel(x, y);
  return a.value(pixel, channel) - b.value(pixel, channel);
}

size_t count_blocks(const Window& w) {
  const auto count = [](int pixels) { return (pixels + block_side - 1) / block_side; };
  return static_cast<size_t>(count(w.width)) * static_cast<size_t>(count(w.height));
}

// Calls `use` with each square of so many pixels, row by row; what is left at the edges is left
// out.
template <typename Use>
void for_each_cell(const Image& image, int cell, Use use) {
  for_each_pixel({0, 0, image.width / cell, image.height / cell},
                 [&](int x, int y) { use(Window{x * cell, y * cell, cell, cell}); });
}

// The averages over cells, with their noise.
Picture coarsened(const Picture& picture, int cell) {
  const Image& image = picture.image;
  const bool knows_noise = picture.knows_noise();
  Picture coarse = picture;
  coarse.file_variances.clear();
  coarse.image.width /= cell;
  coarse.image.height /= cell;
  coarse.image.channels = {"R", "G", "B"};
  if (knows_noise)
    coarse.image.channels.insert(coarse.image.channels.end(),
                                 {"variance.R", "variance.G", "variance.B"});
  coarse.image.values.clear();
  const double pixels = cell * cell;
  for_each_cell(image, cell, [&](const Window& w) {
    for (const bool is_noise : {false, true}) {
      if (is_noise && !knows_noise) continue;
      for (size_t c = 0; c < picture.channel_count(); ++c) {
        double sum = 0.0;
        for_each_pixel(w, [&](int x, int y) {
          const size_t pixel = image.pixel(x, y);
          sum += is_noise ? picture.variance(pixel, c) / pixels : picture.value(pixel, c);
        });
        coarse.image.values.push_back(static_cast<float>(sum / pixels));
      }
    }
  });
  return coarse;
}

// A cell is in the region that all of its pixels are in.
Regions coarsened(const Regions& regions, const Image& image, int cell) {
  Regions coarse{regions.names, {}, regions.excludes_rest};
  for_each_cell(image, cell, [&](const Window& w) {
    int region = regions.of_pixel[image.pixel(w.x, w.y)];
    for_each_pixel(w, [&](int x, int y) {
      if (regions.of_pixel[image.pixel(x, y)] != region) region = -1;
    });
    coarse.of_pixel.push_back(region);
  });
  return coarse;
}

// The differences that are nearer to their mean than half of their standard deviation: from, to.
std::pair<double, double> bulk(const Picture& test, const Picture& model) {
  double sum = 0.0, squares = 0.0, count = 0.0;
  for (size_t c = 0; c < test.averaged; ++c) {
    for_each_pixel(whole(test), [&](int x, int y) {
      const double here = difference(test, model, x, y, c);
      sum += here;
      squares += here * here;
      ++count;
    });
  }
  const double mean = sum / count;
  const double reach = 0.5 * std::sqrt(std::max(squares / count - mean * mean, 0.0));
  return {mean - reach, mean + reach};
}

}  // namespace

void tell_noise_by_neighbours(Picture& test, const Picture& reference) {
  const Window all = whole(test);
  const size_t stride = test.image.channels.size();
  std::vector<float> variances(test.image.values.size());
  for (size_t block = 0; block < count_blocks(all); ++block) {
    const Window w = block_window(all, static_cast<int>(block));
    for (size_t c = 0; c < test.channel_count(); ++c) {
      const auto at = [&](int x, int y) { return difference(test, reference, x, y, c); };
      double sum = 0.0, count = 0.0;
      for_each_pixel({w.x, w.y, w.width - 1, w.height - 1}, [&](int x, int y) {
        sum += std::pow(at(x, y) - at(x + 1, y) - at(x, y + 1) + at(x + 1, y + 1), 2.0) / 4.0;
        ++count;
      });
      for_each_pixel(w, [&](int x, int y) {
        variances[test.image.pixel(x, y) * stride + test.value_channels[c]] =
            static_cast<float>(sum / std::max(count, 1.0));
      });
    }
  }
  test.file_variances = std::move(variances);
  test.variance_channels.assign(test.value_channels.begin(), test.value_channels.end());
  test.degrees_of_freedom = block_side * block_side;
}

Yardstick::Yardstick(const Picture& test, const Picture& reference)
    : channels_(test.channel_count()), window_(whole(test)) {
  const Sums sums = add_up(test, reference, window_, {});
  double typical = 0.0;
  for (size_t c = 0; c < channels_; ++c) {
    std::vector<double> means;
    for (const Pool& pool : sums.blocks_of(c)) means.push_back(pool.mean_reference());
    typical += median(means) / static_cast<double>(channels_);
  }
  for (size_t i = 0; i < sums.blocks.size(); ++i) {
    const Pool& pool = sums.blocks[i];
    if (i % (channels_ + 1) == channels_) continue;
    variances_.push_back((pool.test_variance + pool.reference_variance) / pool.pixels);
    const double size = std::max(std::abs(pool.mean_reference()), 0.1 * typical) + 1e-6;
    squares_.push_back(std::pow(tolerated * size, 2.0));
  }
}

double Yardstick::weight(size_t block, size_t channel, double pixels) const {
  const size_t i = block * channels_ + channel;
  return 1.0 / (variances_[i] / pixels + squares_[i]);
}

// Calls `use` with the weight, the averages of a and b, and the variances of these.
template <typename Use>
void Yardstick::for_each_average(const Picture& a, const Picture& b, int side, Use use) const {
  for (size_t block = 0; block < count_blocks(window_); ++block) {
    const Window w = block_window(window_, static_cast<int>(block));
    for (int y = w.y; y < w.y + w.height; y += side) {
      for (int x = w.x; x < w.x + w.width; x += side) {
        const Window square{x, y, std::min(side, w.x + w.width - x),
                            std::min(side, w.y + w.height - y)};
        const double n = square.width * square.height;
        for (size_t c = 0; c < channels_; ++c) {
          PixelPair sum;
          for_each_pixel(square, [&](int u, int v) {
            const PixelPair pair = pixel_pair(a, b, a.image.pixel(u, v), c);
            sum.test += pair.test;
            sum.reference += pair.reference;
            sum.test_variance += pair.test_variance;
            sum.reference_variance += pair.reference_variance;
          });
          use(weight(block, c, n),
              PixelPair{sum.test / n, sum.reference / n, sum.test_variance / (n * n),
                        sum.reference_variance / (n * n)});
        }
      }
    }
  }
}

double Yardstick::squares(const Picture& test, const Picture& model, int side) const {
  double sum = 0.0;
  for_each_average(test, model, side, [&](double weight, const PixelPair& pair) {
    sum += weight * (std::pow(pair.difference(), 2.0) - pair.reference_variance);
  });
  return sum;
}

double Yardstick::noise(const Picture& test, int side) const {
  double sum = 0.0;
  for_each_average(test, test, side, [&](double weight, const PixelPair& pair) {
    sum += weight * pair.test_variance;
  });
  return sum;
}

Yardstick::Factor Yardstick::best_factor(const Picture& test, const Picture& model) const {
  double of_test = 0.0, product = 0.0, of_model = 0.0;
  for_each_average(test, model, block_side, [&](double weight, const PixelPair& pair) {
    of_test += weight * pair.test * pair.test;
    product += weight * pair.test * pair.reference;
    of_model += weight * (pair.reference * pair.reference - pair.reference_variance);
  });
  if (product <= 0.0 || of_model <= 0.0) return {.squares = of_test};
  return {product / of_model, 1.0 / std::sqrt(of_model), of_test - product * product / of_model};
}

double Yardstick::towards(const Picture& test, const Picture& reference,
                          const Picture& model) const {
  std::vector<PixelPair> seen;
  std::vector<double> ratios, changes;
  for_each_average(test, reference, block_side, [&](double, const PixelPair& pair) {
    seen.push_back(pair);
    if (pair.reference_variance > 0.0) {
      ratios.push_back(pair.test_variance / pair.reference_variance);
    }
  });
  for_each_average(model, reference, block_side,
                   [&](double, const PixelPair& pair) { changes.push_back(pair.difference()); });
  const double usual = ratios.empty() ? 0.0 : median(std::move(ratios));
  const auto noise = [&](size_t i) {
    return std::max(seen[i].test_variance, usual * seen[i].reference_variance) +
           seen[i].reference_variance + squares_[i];
  };
  double product = 0.0, size = 0.0;
  for (size_t i = 0; i < seen.size(); ++i) {
    product += changes[i] * seen[i].difference() / noise(i);
    size += changes[i] * changes[i] / noise(i);
  }
  if (size == 0.0) return 0.0;
  double sum = 0.0, most = 0.0, told = 0.0, scattered = 0.0;
  for (size_t block = 0; block < seen.size(); block += channels_) {
    double along = 0.0, error = 0.0, left = 0.0;
    for (size_t i = block; i < block + channels_; ++i) {
      along += (changes[i] * seen[i].difference() - seen[i].reference_variance) / noise(i);
      error += std::abs(changes[i]) / std::sqrt(noise(i));
      left += changes[i] * (seen[i].difference() - product / size * changes[i]) / noise(i);
    }
    sum += along;
    most = std::max(most, along);
    told += error * error;
    scattered += left * left;
  }
  return (sum - most) / std::sqrt(std::max(told, scattered));
}

Agreement agreement(const Picture& test, const Picture& model, const Regions& regions,
                    double false_alarm, bool by_neighbours, int cell) {
  Judgement judgement;
  judgement.tolerance.value = 0.0;
  judgement.floor = {0.0};  // what tells no noise is exact
  judgement.false_alarm = false_alarm;
  if (by_neighbours) judgement.max_outliers = {1.0};
  Picture coarse_test = coarsened(test, cell), coarse_model = coarsened(model, cell);
  const auto channels = match(coarse_test, coarse_model, {}, true);
  const Comparison comparison = compare(coarse_test, coarse_model, channels, whole(coarse_test),
                                        coarsened(regions, test.image, cell), judgement);
  Agreement result;
  result.is_refuted = comparison.verdict == Verdict::different;
  for (const auto* findings : {&comparison.image, &comparison.regions}) {
    for (const Finding& f : *findings) {
      const double most = std::abs(f.estimate.difference) + f.estimate.margin;
      if (f.scale > 0.0) result.within = std::max(result.within, most / f.scale);
    }
  }
  if (result.is_refuted) result.rest = clearest_difference(comparison);
  return result;
}

SharedNoise shared_noise(const Picture& test, const Picture& model) {
  constexpr int far = 4;
  const auto [least, most] = bulk(test, model);
  std::vector<double> near_differences, far_differences;
  double near_squares = 0.0, far_squares = 0.0;
  for (size_t c = 0; c < test.averaged; ++c) {
    for_each_pixel({0, 0, test.image.width - far, test.image.height - far}, [&](int x, int y) {
      const double here = difference(test, model, x, y, c);
      const auto add = [&](int step, std::vector<double>& all, double& squares) {
        for (const double there :
             {difference(test, model, x + step, y, c), difference(test, model, x, y + step, c)}) {
          all.push_back(std::abs(there - here));
          squares += std::pow(std::clamp(there, least, most) - std::clamp(here, least, most), 2.0);
        }
      };
      add(1, near_differences, near_squares);
      add(far, far_differences, far_squares);
    });
  }
  const double away = median(std::move(far_differences));
  if (away == 0.0 || far_squares == 0.0) return {};
  const double typical = 1.0 - std::pow(median(std::move(near_differences)) / away, 2.0);
  return {std::max(0.0, typical), std::max(0.0, 1.0 - near_squares / far_squares)};
}

}  // namespace plumb
