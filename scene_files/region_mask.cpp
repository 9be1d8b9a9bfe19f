// SPDX-License-Identifier: Apache-2.0

#include "scene_files/region_mask.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <string>

#include "scene/surfaces.h"

namespace plumb {
namespace {

constexpr int steps = 4;  // across a pixel or a lamp

// Of a ray's length: closer than this to its ends nothing is hit.
constexpr double margin = 1e-7;

// A point of the lamp: of its rectangle or triangle, or of the disc that a sphere shows to `point`.
Vec3 lamp_point(const Surface& lamp, const Vec3& point, double u, double v) {
  if (const Polygon* polygon = lamp.polygon()) {
    const std::vector<Vec3>& c = polygon->corners;
    return c[0] + (c[1] - c[0]) * (c.size() == 3 ? u * (1.0 - v) : u) + (c.back() - c[0]) * v;
  }
  const Sphere& sphere = *lamp.sphere();
  const Vec3 axis = (point - sphere.center).normalized();
  const Vec3 side = axis.cross(std::abs(axis.x) < 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0)).normalized();
  const double angle = u * 2.0 * std::numbers::pi;
  const Vec3 radial = side * std::cos(angle) + axis.cross(side) * std::sin(angle);
  return sphere.center + radial * (v * sphere.radius) + axis * sphere.radius * 1.01;
}

// Which of a shape's sides a surface is for one who looks through the camera.
std::string side(const Surface& surface, const Camera& camera) {
  if (surface.sphere() != nullptr) return "";
  const double x = surface.flat_normal.dot(camera.right);
  const double y = surface.flat_normal.dot(camera.up);
  const double z = surface.flat_normal.dot(camera.forward);
  if (std::abs(z) >= std::max(std::abs(x), std::abs(y))) return z < 0.0 ? "front" : "back";
  if (std::abs(x) >= std::abs(y)) return x < 0.0 ? "left" : "right";
  return y < 0.0 ? "bottom" : "top";
}

const std::vector<std::string> shadows{"lit", "penumbra", "umbra"};

// An index into `shadows`; -1 for a lamp.
int shadow(const std::vector<Surface>& surfaces, const Surface& surface, const Ray& ray,
           const Vec3& point) {
  if (surface.shape->is_lamp()) return -1;
  const Vec3 normal = surface.normal(point);
  const double sign = normal.dot(ray.direction) < 0.0 ? 1.0 : -1.0;
  bool is_lit = false;
  bool is_shaded = false;
  for (const Surface& lamp : surfaces) {
    if (!lamp.shape->is_lamp()) continue;
    for (int i = 0; i <= steps; ++i) {
      for (int j = 0; j <= steps; ++j) {
        const Vec3 goal = lamp_point(lamp, point, i / double{steps}, j / double{steps});
        const Ray shadow_ray{point, goal - point};
        if (lamp.normal(goal).dot(shadow_ray.direction) >= 0.0) continue;  // shines elsewhere
        const bool is_seen = sign * normal.dot(shadow_ray.direction) > 0.0 &&
                             find_nearest(surfaces, shadow_ray, margin).second > 1.0 - margin;
        (is_seen ? is_lit : is_shaded) = true;
        if (is_lit && is_shaded) return 1;
      }
    }
  }
  return is_lit ? 0 : 2;
}

class RegionFinder {
 public:
  RegionFinder(const Scene& scene, RegionKind kind)
      : camera_(scene.camera), kind_(kind), surfaces_(list_surfaces(scene)) {
    if (kind == RegionKind::shadow) {
      names_ = shadows;
      return;
    }
    std::map<const Shape*, std::set<std::string>> sides;
    for (const Surface& surface : surfaces_) sides[surface.shape].insert(side(surface, camera_));
    for (const Surface& surface : surfaces_) {
      const bool has_sides = kind == RegionKind::side && sides[surface.shape].size() > 1;
      const std::string& id = surface.shape->id;
      const std::string name = has_sides ? fmt::format("{} {}", id, side(surface, camera_)) : id;
      const auto known = std::ranges::find(names_, name);
      numbers_.push_back(static_cast<int>(known - names_.begin()));
      if (known == names_.end()) names_.push_back(name);
    }
  }

  // Of all regions that the scene has, in the order of its shapes.
  const std::vector<std::string>& names() const { return names_; }

  // The number of the region that the pixel is in, or -1.
  int of_pixel(int x, int y) const {
    const int number = at(x, y);
    for (int i = 0; i <= steps; ++i) {
      for (int j = 0; j <= steps; ++j) {
        if (at(x + i / double{steps}, y + j / double{steps}) != number) return -1;
      }
    }
    return number;
  }

 private:
  int at(double x, double y) const {
    const Ray ray{camera_.origin, camera_.direction(x, y)};
    const auto [surface, distance] = find_nearest(surfaces_, ray, margin);
    if (surface == nullptr) return -1;
    if (kind_ == RegionKind::shadow) return shadow(surfaces_, *surface, ray, ray.at(distance));
    return numbers_[size_t(surface - surfaces_.data())];
  }

  const Camera& camera_;
  RegionKind kind_;
  std::vector<Surface> surfaces_;
  std::vector<std::string> names_;
  std::vector<int> numbers_;  // of the surfaces' regions
};

}  // namespace

RegionMask region_mask(const Scene& scene, RegionKind kind) {
  return region_mask(scene, kind, {0, 0, scene.camera.width, scene.camera.height});
}

RegionMask region_mask(const Scene& scene, RegionKind kind, const Window& window) {
  const RegionFinder finder(scene, kind);
  RegionMask mask{{}, {}, std::vector<int>(size_t(window.pixel_count()))};
  tbb::parallel_for(0, window.height, [&](int y) {
    const size_t row = size_t(y) * size_t(window.width);
    for (int x = 0; x < window.width; ++x)
      mask.regions[row + size_t(x)] = finder.of_pixel(window.x + x, window.y + y);
  });
  std::map<int, int> indices{{-1, -1}};  // by the regions' numbers
  for (const int number : mask.regions) indices[number] = -1;
  for (auto& [number, index] : indices) {
    if (number < 0) continue;
    index = static_cast<int>(mask.names.size());
    mask.names.push_back(finder.names()[size_t(number)]);
    mask.numbers.push_back(number);
  }
  for (int& region : mask.regions) region = indices[region];
  return mask;
}

}  // namespace plumb
