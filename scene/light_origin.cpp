// SPDX-License-Identifier: Apache-2.0

#include "scene/light_origin.h"

#include <algorithm>
#include <stdexcept>

#include "scene/surfaces.h"

namespace plumb {

LightOrigin light_origin(const Scene& scene, LightOrigin::Way way,
                         const std::vector<std::string>& ids) {
  for (const std::string& id : ids) {
    if (std::ranges::find(scene.shapes, id, &Shape::id) != scene.shapes.end()) continue;
    std::string there;
    for (const Shape& shape : scene.shapes) there += (there.empty() ? "" : ", ") + shape.id;
    throw std::invalid_argument("no shape has the id \"" + id + "\"; there are: " + there);
  }
  LightOrigin origin{.way = way, .has_shape = {}, .has_surface = {}};
  const auto is_one = [&](const Shape& shape) -> uint8_t {
    return std::ranges::find(ids, shape.id) != ids.end();
  };
  for (const Shape& shape : scene.shapes) origin.has_shape.push_back(is_one(shape));
  for (const Surface& surface : list_surfaces(scene)) {
    origin.has_surface.push_back(is_one(*surface.shape));
  }
  return origin;
}

}  // namespace plumb
