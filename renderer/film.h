// SPDX-License-Identifier: Apache-2.0

// Collects samples of radiance and turns them into a picture that knows its own noise.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "images/exact_sum.h"
#include "images/window.h"
#include "renderer/settings.h"

namespace plumb {

// Sample s of a pixel belongs to replicate s mod `replicates`. Each replicate is a randomisation of
// the sampler of its own, so the replicates' means are independent and their scatter measures the
// noise honestly, which the samples of one low-discrepancy set would not.
//
// Sums are exact: a film holds the same bits in whatever order, and in whatever parts, it got the
// samples.
//
// Different threads may add to different pixels at the same time.
class Film {
 public:
  static constexpr int replicates = 4;
  using Counts = std::array<int64_t, replicates>;

  // A film of some of a picture's pixels, or of a whole picture.
  explicit Film(const Window& window);
  Film(int width, int height) : Film(Window{0, 0, width, height}) {}

  // About the largest radiance of a sample, on which the exactness of sums depends (SumGrid);
  // render() says the scene's.
  void set_brightness(double brightness) { grid_ = SumGrid(brightness); }

  const Window& window() const { return window_; }
  int width() const { return window_.width; }
  int height() const { return window_.height; }
  int64_t pixel_count() const { return window_.pixel_count(); }

  // A pass begins, opens each pixel before it adds to it, and ends when every pixel has received
  // the samples; ranges must not overlap. begin_pass() again discards an unfinished pass: so a film
  // holds whole passes.
  void begin_pass() { next_.resize(sums_.size()); }
  void end_pass(SampleRange samples);

  // `pixel` counts along the window's rows from its top left corner.
  void open_pixel(size_t pixel) {
    std::copy_n(&sums_[pixel * replicates * 3], replicates * 3, &next_[pixel * replicates * 3]);
  }

  // Adds the radiance of one sample.
  template <typename T>
  void add(size_t pixel, size_t replicate, const T* radiance, size_t stride) {
    ExactSum* sum = &next_[(pixel * replicates + replicate) * 3];
    for (size_t c = 0; c < 3; ++c) sum[c].add(double{radiance[c * stride]}, grid_);
  }

  // Adds samples of which only the sum is known: to `weight` times each of the values, in the
  // layout of mean(). Further terms of the same sums are added as of no samples.
  void add_sums(int replicate, int64_t samples, const std::vector<float>& values, double weight);

  int64_t samples_per_pixel() const;
  const Counts& samples_per_replicate() const { return counts_; }

  // Whether two replicates have samples.
  bool knows_variance() const;

  // Mean radiance, and the variance of that mean (unbiased; zero while it is not
  // known): width * height * 3 values, rows from the top, RGB.
  std::vector<float> mean() const { return collect(&Moments::mean); }
  std::vector<float> variance() const { return collect(&Moments::variance); }

  // RelativeError of mean() and variance(). Infinite while the variance is not known.
  double relative_error() const;

  // The replicates' own means, in the layout of mean(); `replicate` must have samples.
  std::vector<float> replicate_mean(int replicate) const;

  // A term of the replicates' sums (ExactSum::terms()), in the layout of mean().
  std::vector<float> replicate_term(int replicate, size_t term) const;

 private:
  // Of a pixel, RGB.
  struct Moments {
    std::array<float, 3> mean{};
    std::array<float, 3> variance{};  // of that mean
  };
  Moments moments(int64_t pixel) const;
  std::vector<float> collect(std::array<float, 3> Moments::* part) const;
  template <class Pick>
  std::vector<float> collect_sums(int replicate, Pick pick) const;

  // Where the sum of the value that is number i of mean() is.
  static size_t index_of(size_t i, int r) { return (i / 3 * replicates + size_t(r)) * 3 + i % 3; }

  Window window_;
  SumGrid grid_;
  std::vector<ExactSum> sums_;
  std::vector<ExactSum> next_;  // the sums with the pass under way
  Counts counts_{};
};

// How many of the samples belong to each replicate.
Film::Counts samples_per_replicate(const SampleRange& samples);

}  // namespace plumb
