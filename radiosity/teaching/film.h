// SPDX-License-Identifier: Apache-2.0

// Pictures of patches, many of the same view.
#pragma once

#include <array>
#include <vector>

#include "radiosity/teaching/exchange.h"
#include "radiosity/teaching/patches.h"
#include "radiosity/work.h"

namespace plumb::radiosity::teaching {

// What is seen at nine points of each pixel. Pictures are radiance of each pixel, rows from the
// top; what is no patch is black.
class Film {
 public:
  Film(const Patches& patches, const Camera& camera, const Work& work);

  std::vector<float> flat(const Light& light) const;
  // Interpolated between the patches' corners.
  std::vector<float> smooth(const Light& light) const;
  // Patches with their edges.
  std::vector<float> wire(const Light& light) const;

 private:
  static constexpr size_t points = 3;  // along a pixel's side
  static constexpr size_t nothing = size_t(-1);

  struct Sample {
    size_t patch = nothing;
    std::array<double, 4> weights{};  // of the corners' values
  };

  template <typename Value>
  std::vector<float> picture(Value value) const;

  const Patches& patches_;
  size_t width_, height_;  // in samples
  std::vector<Sample> samples_;
};

}  // namespace plumb::radiosity::teaching
