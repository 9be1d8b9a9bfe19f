// SPDX-License-Identifier: Apache-2.0

// Where light comes from: pictures of what came by way of some shapes alone.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace plumb {

// Which light a picture shows, of all that reaches the surface that is seen (the first one from the
// camera, be it matte, a mirror or glass):
//
//   last  what left one of the shapes right before, emitted or reflected. A lamp that is seen
//   itself
//         counts as light that left the lamp. Pictures of disjoint sets of shapes add up to that of
//         their union.
//   any   what one of the shapes has reflected, or let through, at least once on its way there.
struct LightOrigin {
  enum class Way { last, any };
  Way way = Way::last;
  std::vector<uint8_t> has_shape;    // for each of the scene's shapes, whether it is one of them
  std::vector<uint8_t> has_surface;  // and for each of list_surfaces(scene)

  // Whether the picture shows what a lamp sends straight to the camera or to what is seen.
  bool counts_emission(size_t shape) const { return way == Way::last && has_shape[shape] != 0; }
};

// Of the shapes with these ids. Throws std::invalid_argument, which lists the scene's, if there is
// none of an id.
LightOrigin light_origin(const Scene& scene, LightOrigin::Way way,
                         const std::vector<std::string>& ids);

}  // namespace plumb
