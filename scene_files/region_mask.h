// SPDX-License-Identifier: Apache-2.0

// Which part of a scene each pixel sees, so that pictures can be compared part by part.
#pragma once

#include <string>
#include <vector>

#include "scene/scene.h"

namespace plumb {

// What regions are: shapes; the sides of shapes as the camera looks at them (front, left, top,
// ...); or lit surfaces, penumbrae and umbrae.
enum class RegionKind { object, side, shadow };

struct RegionMask {
  std::vector<std::string> names;
  std::vector<int> regions;  // an index into `names` for each pixel, row by row; -1: none
};

// A pixel belongs to a region if all of a grid of points in it, its corners among them, do. Mirrors
// are taken for what they are, not for what they show; a lamp is no part of any shadow.
RegionMask region_mask(const Scene& scene, RegionKind kind);

}  // namespace plumb
