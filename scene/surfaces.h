// SPDX-License-Identifier: Apache-2.0

// A scene's shapes taken apart into the flat faces and spheres that rays meet, in double precision
// and in the scene's own units.
#pragma once

#include <utility>
#include <variant>
#include <vector>

#include "scene/scene.h"

namespace plumb {

struct Ray {
  Vec3 origin;
  Vec3 direction;

  Vec3 at(double distance) const { return origin + direction * distance; }
};

// One flat face or one sphere of a shape. A lamp's faces are rectangles and triangles.
struct Surface {
  const Shape* shape;
  std::variant<Polygon, Sphere> geometry;
  Vec3 flat_normal{0.0};  // of a flat face

  const Polygon* polygon() const { return std::get_if<Polygon>(&geometry); }
  const Sphere* sphere() const { return std::get_if<Sphere>(&geometry); }

  // Of unit length, on the side to which lamps shine: of a sphere, outwards.
  Vec3 normal(const Vec3& point) const;

  // The first point of the ray, in units of the direction's length, that is on the surface and
  // farther away than `margin`; infinity if there is none.
  double intersect(const Ray& ray, double margin) const;
};

// In the order of the scene's shapes, to which the surfaces point.
std::vector<Surface> list_surfaces(const Scene& scene);

// The nearest surface and its distance, as intersect(); null and infinity if there is none.
std::pair<const Surface*, double> find_nearest(const std::vector<Surface>& surfaces, const Ray& ray,
                                               double margin);

}  // namespace plumb
