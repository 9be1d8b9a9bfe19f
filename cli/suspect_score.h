// SPDX-License-Identifier: Apache-2.0

// How well a picture of a suspect explains the one that is diagnosed.
#pragma once

#include "cli/suspects.h"
#include "compare/explanation.h"
#include "compare/picture.h"

namespace plumb::cli {

class SuspectScore {
 public:
  // Both are matched; `test` outlives this. `by_neighbours` says that its noise is as those tell.
  SuspectScore(const Picture& test, const Picture& healthy, bool by_neighbours);

  // Says in the suspect what its model, which is matched, leaves.
  void measure(Suspect& suspect, const Picture& model) const;

  // The exposure of a model that explains most.
  Yardstick::Factor best_factor(const Picture& model) const;

  // How far the picture lies from the reference towards a model, in standard errors.
  double towards(const Picture& reference, const Picture& model) const {
    return yardstick_.towards(test_, reference, model);
  }

  double penalty_of(const Suspect& suspect) const;

  // What counts: blocks or pixels, whichever shows the difference more clearly: a slow change is
  // lost in the noise of pixels, and an edge in the middle of a block.
  double Suspect::* what_counts() const { return side_ == 1 ? &Suspect::pixels : &Suspect::blocks; }

  // The standard deviation of squares that are noise, of averages over squares of so many pixels;
  // and the same with the noise of a model.
  double deviation(int side) const;
  double deviation(int side, const Picture& model) const;

 private:
  const Picture& test_;
  Yardstick yardstick_;
  double values_;  // how many the picture has
  int side_ = 1;   // of what counts
  // The squared difference of picture and reference without the noise of either, and the noise.
  double all_ = 0.0, noise_ = 0.0;
};

}  // namespace plumb::cli
