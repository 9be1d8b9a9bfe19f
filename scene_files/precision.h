// SPDX-License-Identifier: Apache-2.0

// Whether float holds a scene.
#pragma once

#include <string>

#include "scene/scene.h"

namespace plumb {

// What of the scene wants double, in words; nothing where float does. What float costs is known: it
// grows flat surfaces at their edges by g = float_growth(), some 1e-6 of the scene's size, and
// rounds points by a tenth of that. The limits lie between scenes of reference_scenes/stress/ that
// float gets wrong and others that it gets right:
//
//   a gap of 10 to 1000 g       gap: 47 g wide, 4 % wrong; grazing_lamp: 84 g, 0.004 %.
//                               slit: 4700 g, right
//   points in view that a lamp  giant_sphere: 60 g above its plane, 1 % wrong; edge_on_lamp: 560 g,
//     meets edge-on, from less  0.006 %. ceiling_lamp: 6000 g, right
//     than 2000 g
//   silhouettes in a view that  edge_pixel: 1.8e5 g wide, 0.001 % wrong. caustic: 8.5e5 g, right
//     is narrower than 2e5 g
//
// Gaps count between an edge of one flat shape and what it points at on another, in scenes of no
// more than 300 faces, but not beside glass, through which light gets there anyhow. Narrower ones
// are joints that a file's digits have opened. What is in view is told by 16 rays.
std::string needs_double(const Scene& scene);

}  // namespace plumb
