// SPDX-License-Identifier: Apache-2.0

// Tells how much of what a picture differs from its reference a model of it explains: a picture of
// what a suspected mistake would show.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "compare/comparison.h"

namespace plumb {

// Gives a picture that does not tell its noise what its neighbouring pixels do: in each block of a
// channel the mean square of second differences, along x and y, of `test` minus `reference`. Of
// independent noise that is four times its variance (Immerkaer, "Fast noise variance estimation",
// Computer Vision and Image Understanding 64(2), 1996, with a smaller mask); what differs at edges
// adds to it. Both are matched.
void tell_noise_by_neighbours(Picture& test, const Picture& reference);

// Sums of squared differences, in units of the noise.
class Yardstick {
 public:
  // Of the two variances together in each block and channel. What a model may be off beside its
  // noise, as a part of the reference, is added to them: `tolerated`. Both are matched.
  Yardstick(const Picture& test, const Picture& reference);

  // The sum over squares of `side` pixels, a divisor of block_side, and over channels of (test -
  // model)^2 / variance, for the averages over each; less what the model's own noise adds on
  // average. For a model without noise that explains everything, and a test that tells its noise,
  // it is the number of averages, but for the part of the variance that is not noise.
  double squares(const Picture& test, const Picture& model, int side) const;

  // What of that is the noise of the test; 0 where that is not known for certain.
  double noise(const Picture& test, int side) const;

  // The factor of the model's values that makes squares() of whole blocks smallest, its standard
  // error, and those squares.
  struct Factor {
    double value = 1, error = 0, squares = 0;
  };
  Factor best_factor(const Picture& test, const Picture& model) const;

  // How far the test lies from the reference towards the model, in standard errors: the sum over
  // blocks and channels of their two differences from the reference, each in units of its noise,
  // which is the matched filter of a change whose size is not known. The noise of a block is at
  // least that of the reference times the usual ratio, so that a test that missed a rare path is
  // not certain; channels may err alike; blocks are as noisy as they scatter, if that is more than
  // they tell, since their pixels may share noise; and the block that tells most does not count.
  // What the reference's own noise adds is subtracted at its most. Of a test that is the reference
  // but for noise it is about normal, with a deviation of at most 1. All are matched and tell their
  // noise.
  double towards(const Picture& test, const Picture& reference, const Picture& model) const;

  static constexpr double tolerated = 1e-3;

 private:
  // The weight of the average over so many pixels of a block.
  double weight(size_t block, size_t channel, double pixels) const;
  template <typename Use>
  void for_each_average(const Picture& a, const Picture& b, int side, Use use) const;

  size_t channels_;
  Window window_;
  std::vector<double> variances_, squares_;  // per pixel; of what is tolerated, per average
};

// What compare() says of a model, at tolerance 0.
struct Agreement {
  bool is_refuted = false;  // they differ by more than noise
  // The averages over the image and all regions surely differ by no more, as a part of what is
  // judged (see Amount).
  double within = 0;
  std::string rest;  // the clearest difference, or what fits better, if it is refuted
};

// `by_neighbours` says that the test's noise is as those tell: then no single pixel counts. If
// neighbouring pixels share noise, these are not independent, as the margins need it: then averages
// over squares of `cell` pixels stand for them.
Agreement agreement(const Picture& test, const Picture& model, const Regions& regions,
                    double false_alarm, bool by_neighbours, int cell = 1);

// How alike the noise of neighbouring pixels is, from 0, if it is independent, to 1.
struct SharedNoise {
  // By the medians of differences between pixels, in which edges hardly count. But where light is
  // met by chance, most pixels have met none and tell slow changes alone, which are alike, too.
  double typical = 0;
  // By the squares of these differences, of values that are cut off at half of their standard
  // deviation from their mean, lest few bright pixels decide. Edges count.
  double of_all = 0;

  // What neither edges nor rare light make alone.
  double sure() const { return std::min(typical, of_all); }
};

// Holds differences between pixels that touch against those between pixels that are four apart, of
// `test` minus `model`. Both are matched.
SharedNoise shared_noise(const Picture& test, const Picture& model);

}  // namespace plumb
