// SPDX-License-Identifier: Apache-2.0

// Compares a picture with a reference: how far apart they are, and whether noise explains that.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compare/equivalence.h"
#include "compare/flip.h"
#include "compare/picture.h"
#include "compare/sums.h"

namespace plumb {

// Either an absolute amount (radiance, or a number of pixels), or a fraction: of what is judged, or
// of the number of pixels. What is judged is the reference's average over the image, a region, a
// block or a pixel, but at least a tenth of the image's typical value: the median over the pixels
// of the channels' mean, without black ones if it would be 0.
struct Amount {
  double value = 0;
  bool is_relative = true;
};

struct Judgement {
  Amount tolerance{0.01};  // a difference that does not matter

  // How wrong the pictures may be beside their known noise. The whole image's average has a floor
  // of its own if there is an `image_floor`.
  std::optional<Amount> floor, image_floor;

  double false_alarm = 1e-3;      // the probability that noise alone makes the verdict `different`
  Amount max_outliers{0, false};  // how many pixels may differ

  // By how much these may differ; no pixel may by more.
  std::optional<Amount> hard_limit;

  // FLIP's largest mean and 95th percentile over the compared pixels.
  std::optional<double> flip_mean, flip_p95;
};

// What is averaged before it is judged.
enum class Unit { image, region, block, pixel };
const char* to_string(Unit unit);

// What was found of one unit in one channel.
struct Finding {
  std::string name;  // of a region; else empty
  Window window;     // of any other unit
  std::string channel;
  Estimate estimate;
  bool is_beyond_limit = false;  // of a pixel: whether it surely differs by more than that
  double scale = 0;              // of an average: what a relative amount is a part of
};

// All units of one kind.
struct Level {
  Unit unit = Unit::image;
  int64_t units = 0;                // how many there are
  int64_t different = 0;            // how many of them differ, in any channel
  int64_t beyond_limit = 0;         // how many of these do by more than the hard limit
  bool differs = false;             // whether these are too many
  double visible = 0;               // a bias that would be found, as a part of what is judged; the
                                    // median over units and averaged channels
  std::vector<Finding> worst = {};  // of the units that differ ten at most, the clearest first
};

// Measures of the error in one channel, with x the test and r the reference.
struct Errors {
  double mae = 0;      // mean |x - r|
  double mse = 0;      // mean (x - r)^2
  double rel_mse = 0;  // mean (x - r)^2 / (r^2 + relative_epsilon)
  double smape = 0;    // mean 2 |x - r| / (|x| + |r| + relative_epsilon)
  double bias_squared = 0, test_noise = 0, reference_noise = 0;  // the known parts of mse
  double peak = 1;                         // the reference's largest value, but at least 1
  double max = -1;                         // the largest |x - r|
  int x = 0, y = 0;                        // the pixel where that is,
  double max_test = 0, max_reference = 0;  // and its two values

  double psnr() const;  // 10 lg(peak^2 / mse)
};

struct Comparison {
  std::vector<std::string> channels;  // the compared ones, and "all" for their mean
  Window window;
  std::vector<Errors> errors;              // one for each of the channels
  std::vector<double> tolerances, floors;  // radiance, for each channel over the image
  bool knows_noise = false;
  bool is_paired = false;               // both took the same samples
  std::vector<Finding> image, regions;  // a finding for each channel (of each region)
  std::vector<Level> levels;
  bool is_same_but_for_pixels = false;  // more pixels differ than are allowed to, and nothing else
  bool is_doubtful = false;  // something differs, but there are few samples, which may deceive
  Verdict verdict = Verdict::inconclusive;
  double samples_factor = 1;     // this many times the samples would lead to a decision
  int64_t fireflies = 0;         // how many pixels outshine their surroundings
  Estimate without_fireflies;    // the mean of all channels over the other pixels
  std::optional<Flip> flip;      // compare() leaves it empty
  bool looks_different = false;  // FLIP alone makes the verdict `different`
};

// Compares two pictures that match() has matched, which returned the `channels`. `regions` may be
// empty; else the pixels in none of them are not compared.
//
// The verdict is `different` if the average over the image, a region or a block differs by more
// than the tolerance, or if more pixels do than are allowed to or one by more than the hard limit,
// where noise and the number of tests are accounted for. It is `same` if the averages of the image
// and of all regions surely differ by less. Where the noise of either picture is not known and no
// floor is stated, every pixel is held against the tolerance instead.
//
// Pictures with the same samples (are_paired()) are judged by the scatter of their differences
// instead of the noise that either claims, whether they claim any or not. Single pixels have no
// scatter: they are judged by the claimed noise as ever, or not at all where none is claimed.
//
// Where either picture has few samples (Picture::has_few_samples()) and they are not paired, the
// verdict is `inconclusive` instead of `different`.
//
// A firefly is a pixel that differs by more than the tolerance, whose squared difference is more
// than half of the sum over its block and more than 64 times the mean over the typical block.
// Throws std::invalid_argument if the regions hold no pixel of the window.
Comparison compare(const Picture& test, const Picture& reference,
                   const std::vector<std::string>& channels, const Window& window,
                   const Regions& regions, const Judgement& judgement);

// Adds FLIP to a comparison, whose verdict becomes `different` if FLIP is above one of its limits.
void add_flip(Comparison& comparison, const Flip& flip, const Judgement& judgement);

}  // namespace plumb
