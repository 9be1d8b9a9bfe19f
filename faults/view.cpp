// SPDX-License-Identifier: Apache-2.0

#include "faults/view.h"

#include <algorithm>

#include "scene/surfaces.h"

namespace plumb {

double View::farthest() const { return *std::ranges::max_element(depths); }

double View::depth_at(double part) const {
  double nearest = farthest();
  for (size_t i = 0; i < depths.size(); ++i) {
    if (surfaces[i] >= 0) nearest = std::min(nearest, depths[i]);
  }
  return nearest + part * (farthest() - nearest);
}

View look_at(const Scene& scene) {
  constexpr double margin = 1e-7;
  const std::vector<Surface> all = list_surfaces(scene);
  View view;
  for (int y = 0; y < scene.camera.height; ++y) {
    for (int x = 0; x < scene.camera.width; ++x) {
      const Ray ray{scene.camera.origin, scene.camera.direction(x + 0.5, y + 0.5)};
      const auto [surface, depth] = find_nearest(all, ray, margin);
      view.surfaces.push_back(surface != nullptr ? surface - all.data() : -1);
      view.depths.push_back(surface != nullptr ? depth : 0.0);
      view.shows_others.push_back(surface != nullptr && surface->shape->bsdf.is_specular());
    }
  }
  return view;
}

}  // namespace plumb
