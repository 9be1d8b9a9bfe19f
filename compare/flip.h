// How different two pictures look to somebody who flips between them.
#pragma once

#include "compare/sums.h"

namespace plumb {

// As a display shows radiance from 0 to 1; or at several exposures, a pixel's worst one of which
// counts.
enum class FlipKind { ldr, hdr };

struct Flip {
  FlipKind kind;
  std::vector<float> map;                        // 0 to 1, for each pixel of the window
  double mean = 0;                               // of the map
  double first_exposure = 0, last_exposure = 0;  // stops

  static constexpr double pixels_per_degree = 67.02064;  // 3840 pixels on 0.7 m, from 0.7 m away
};

// FLIP (Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images") and HDR-FLIP
// (2021, "Visualizing Errors in Rendered High Dynamic Range Images") with the ACES tone mapper.
// HDR's exposures reach from where the reference's largest luminance is shown at 0.85 to where the
// median one is, or the median without black pixels if it is 0, for which the paper has no answer.
// A black reference is seen as it is. Throws std::invalid_argument unless there are three channels
// (R G B) or one.
Flip flip(FlipKind kind, const Picture& test, const Picture& reference, const Window& window);

}  // namespace plumb
