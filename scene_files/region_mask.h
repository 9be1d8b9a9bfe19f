// SPDX-License-Identifier: Apache-2.0

// Which part of a scene each pixel sees, so that pictures can be compared part by part.
#pragma once

#include <string>
#include <vector>

#include "images/window.h"
#include "scene/scene.h"

namespace plumb {

// What regions are: shapes; the sides of shapes as the camera looks at them (front, left, top,
// ...); or lit surfaces, penumbrae and umbrae.
enum class RegionKind { object, side, shadow };

struct RegionMask {
  std::vector<std::string> names;  // of those in the window, in the scene's order
  // Of each of these its number among all regions that the scene has, whatever the window sees.
  std::vector<int> numbers;
  // An index into `names` for each pixel of a window, row by row; -1: none.
  std::vector<int> regions;
};

// A pixel belongs to a region if all of a grid of points in it, its corners among them, do. Mirrors
// are taken for what they are, not for what they show; a lamp is no part of any shadow.
// The window lies within the picture.
RegionMask region_mask(const Scene& scene, RegionKind kind, const Window& window);
RegionMask region_mask(const Scene& scene, RegionKind kind);  // of the whole picture

}  // namespace plumb
