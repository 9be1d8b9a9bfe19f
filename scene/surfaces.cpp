// SPDX-License-Identifier: Apache-2.0

#include "scene/surfaces.h"

#include <cmath>
#include <limits>

namespace plumb {
namespace {

constexpr double miss = std::numeric_limits<double>::infinity();

// A triangle or a convex quad, by its edges.
double intersect_polygon(const Ray& ray, const Polygon& polygon, const Vec3& normal,
                         double margin) {
  const std::vector<Vec3>& corners = polygon.corners;
  const double t = (corners[0] - ray.origin).dot(normal) / ray.direction.dot(normal);
  if (!(t > margin)) return miss;
  for (size_t i = 0; i < corners.size(); ++i) {
    const Vec3 edge = corners[(i + 1) % corners.size()] - corners[i];
    if (edge.cross(ray.at(t) - corners[i]).dot(normal) < 0.0) return miss;
  }
  return t;
}

double intersect_sphere(const Ray& ray, const Sphere& sphere, double margin) {
  const Vec3 offset = ray.origin - sphere.center;
  const double a = ray.direction.length2();
  const double b = offset.dot(ray.direction);
  const double discriminant = b * b - a * (offset.length2() - sphere.radius * sphere.radius);
  if (discriminant < 0.0) return miss;
  const double root = std::sqrt(discriminant);
  if (-b - root > margin * a) return (-b - root) / a;
  return -b + root > margin * a ? (-b + root) / a : miss;
}

// What lamps are sampled by.
Mesh rectangles_and_triangles(const Polygon& face) {
  const auto& c = face.corners;
  if (c.size() == 3 || face.is_rectangle()) return {face};
  return {{{c[0], c[1], c[2]}}, {{c[0], c[2], c[3]}}};
}

}  // namespace

Vec3 Surface::normal(const Vec3& point) const {
  return polygon() != nullptr ? flat_normal : (point - sphere()->center).normalized();
}

double Surface::intersect(const Ray& ray, double margin) const {
  return polygon() != nullptr ? intersect_polygon(ray, *polygon(), flat_normal, margin)
                              : intersect_sphere(ray, *sphere(), margin);
}

std::vector<Surface> list_surfaces(const Scene& scene) {
  std::vector<Surface> surfaces;
  for (const Shape& shape : scene.shapes) {
    if (const auto* sphere = std::get_if<Sphere>(&shape.geometry)) {
      surfaces.push_back({&shape, *sphere});
      continue;
    }
    for (const Polygon& face : std::get<Mesh>(shape.geometry)) {
      for (Polygon& part : shape.is_lamp() ? rectangles_and_triangles(face) : Mesh{face}) {
        const Vec3 normal = part.normal();
        surfaces.push_back({&shape, std::move(part), normal});
      }
    }
  }
  return surfaces;
}

std::pair<const Surface*, double> find_nearest(const std::vector<Surface>& surfaces, const Ray& ray,
                                               double margin) {
  std::pair<const Surface*, double> nearest{nullptr, miss};
  for (const Surface& surface : surfaces) {
    const double distance = surface.intersect(ray, margin);
    if (distance < nearest.second) nearest = {&surface, distance};
  }
  return nearest;
}

}  // namespace plumb
