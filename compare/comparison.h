// Compares a picture with a reference: how far apart they are, and whether noise explains it.
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

// A radiance, or a fraction of the mean of the reference's channel (over a region for regions, over
// the image else); or a number of pixels, or a fraction of them.
struct Amount {
  double value = 0;
  bool is_relative = true;
};

struct Judgement {
  Amount tolerance{0.01};
  std::optional<Amount> floor;        // of what is wrong with the pictures beside their known noise
  std::optional<Amount> image_floor;  // the same of the whole image's average; else it is the floor
  double false_alarm = 1e-3;          // the chance that noise alone makes the verdict "different"
  Amount max_outliers{0, false};      // pixels that may differ
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
};

// All units of one kind.
struct Level {
  Unit unit = Unit::image;
  int64_t units = 0;           // how many there are
  int64_t different = 0;       // how many of them differ, in any channel
  double visible = 0;          // a bias that would be found, as a part of the image's mean, or of a
                               // region's own; the median over units and channels
  std::vector<Finding> worst;  // of the units that differ ten at most, the clearest first
};

// Of one channel, with x the test and r the reference.
struct Errors {
  double mae = 0;      // mean |x - r|
  double mse = 0;      // mean (x - r)^2
  double rel_mse = 0;  // mean (x - r)^2 / (r^2 + relative_epsilon)
  double smape = 0;    // mean 2 |x - r| / (|x| + |r| + relative_epsilon)
  double bias_squared = 0, test_noise = 0, reference_noise = 0;  // the known parts of mse
  double peak = 1;  // the reference's largest value, 1 at least
  double max = -1;  // max |x - r|, at the pixel x, y with these two values
  int x = 0, y = 0;
  double max_test = 0, max_reference = 0;

  double psnr() const;  // 10 lg(peak^2 / mse)
};

struct Comparison {
  std::vector<std::string> channels;  // those compared, and "all" for their mean
  Window window;
  std::vector<Errors> errors;              // of each of the channels
  std::vector<double> tolerances, floors;  // radiance, of each channel over the image
  bool knows_noise = false;
  std::vector<Finding> image, regions;  // a finding for each channel (of each region)
  std::vector<Level> levels;
  bool is_same_but_for_pixels = false;  // more pixels differ than may, and nothing else does
  Verdict verdict = Verdict::inconclusive;
  double samples_factor = 1;  // how many times the samples would decide it
  int64_t fireflies = 0;      // pixels that outshine their surroundings
  Estimate without_fireflies;
  std::optional<Flip> flip;  // left to the caller: it judges nothing
};

// The pictures are matched already; `regions` may be empty.
//
// The verdict is "different" if an average over the image, a region or a block, or more pixels than
// allowed, differ by more than the tolerance, noise and number of tests being allowed for. It is
// "same" if the image's and all regions' averages surely differ by less. Where the noise of either
// picture is not known and no floor is stated, every pixel is held against the tolerance instead.
//
// A firefly is a pixel that differs by more than the tolerance, with more than half of its block's
// squared differences and 64 times the mean one of the typical block.
Comparison compare(const Picture& test, const Picture& reference,
                   const std::vector<std::string>& channels, const Window& window,
                   const Regions& regions, const Judgement& judgement);

}  // namespace plumb
