// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <vector>

#include "scene/scene.h"

namespace plumb {

// What the middle of each pixel sees: which surface, and how far away along the camera's axis. Of
// the sky that is -1 and 0.
struct View {
  std::vector<std::ptrdiff_t> surfaces;
  std::vector<double> depths;
  std::vector<bool> shows_others;  // whether that is a mirror or glass

  double farthest() const;
  // The depth that lies this part of the way from the nearest surface to the farthest.
  double depth_at(double part) const;
};

View look_at(const Scene& scene);

}  // namespace plumb
