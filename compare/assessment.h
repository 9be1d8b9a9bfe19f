// SPDX-License-Identifier: Apache-2.0

// Assesses a way of rendering by a picture that it has drawn in a limited time: whether it is
// right, and how fast its noise falls.
#pragma once

#include <optional>
#include <string>

#include "compare/picture.h"
#include "compare/sample_tail.h"

namespace plumb {

// What has been drawn, and what is known of how.
struct Trial {
  Picture picture;         // with its noise, unless the program has none
  std::string program;     // with its version; empty for our own
  double seconds = 0.0;    // of rendering alone
  double samples = 0.0;    // of all pixels together; 0 if the program has none
  double brightest = 0.0;  // radiance that a sample may have, though none has
  std::optional<SampleTail> tail;
};

// docs/stability.md says what these mean.
enum class Outcome { holds, noisy, biased, breaks };

struct Assessment {
  Outcome outcome = Outcome::breaks;

  // These describe the mean over the channels, and are not set if the outcome is `breaks`.
  double bias = 0.0, error = 0.0;  // of the whole picture, and its standard error; relative
  double cost = 0.0;               // relMSE, without the truth's noise, times seconds; infinite
                                   // for a picture without noise, which falls with none
  double seconds_to_one_percent = 0.0;  // for a picture of 256 x 256 pixels, if it has noise

  bool is_right() const { return outcome == Outcome::holds || outcome == Outcome::noisy; }
};

// Holds the averages over the picture and over its blocks against the truth. `false_alarm` is the
// probability that noise alone makes this trial biased.
Assessment assess(Trial trial, Picture truth, double false_alarm);

}  // namespace plumb
