// SPDX-License-Identifier: Apache-2.0

// How different two pictures look to somebody who flips between them on a display.
#pragma once

#include "compare/sums.h"

namespace plumb {

// Low dynamic range: the display shows radiance from 0 to 1. High dynamic range: it shows several
// exposures, of which each pixel's worst one counts.
enum class FlipKind { ldr, hdr };

struct Flip {
  FlipKind kind;
  std::vector<float> map;                        // 0 to 1, for each pixel of the window
  double mean = 0, p95 = 0;                      // of the compared pixels: mean, 95th percentile
  double first_exposure = 0, last_exposure = 0;  // stops
  double pixels_per_degree = 0;
};

constexpr double usual_pixels_per_degree = 67.02064;  // 3840 pixels on 0.7 m, from 0.7 m away

// Computes FLIP (Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images") or
// HDR-FLIP (2021, "Visualizing Errors in Rendered High Dynamic Range Images") with the ACES tone
// mapper. HDR-FLIP's exposures range from the one that shows the reference's largest luminance at
// 0.85 to the one that shows its median there. If that median is 0, which the paper does not
// discuss, it is taken without the black pixels; a wholly black reference is shown unexposed.
// Throws std::invalid_argument unless there are three compared channels (R G B) or one.
Flip flip(FlipKind kind, const Picture& test, const Picture& reference, const Window& window,
          const Regions& regions = {}, double pixels_per_degree = usual_pixels_per_degree);

}  // namespace plumb
