// SPDX-License-Identifier: Apache-2.0

// The curve of sRGB (IEC 61966-2-1).
#pragma once

#include <algorithm>
#include <cmath>

namespace plumb {

// From code to radiance and back, both from 0 to 1. Codes may be larger, radiance is cut off there.
inline double linear_of_srgb(double code) {
  return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
}

inline double srgb_of_linear(double radiance) {
  const double x = std::clamp(radiance, 0.0, 1.0);
  return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055;
}

}  // namespace plumb
