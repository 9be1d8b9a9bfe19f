// SPDX-License-Identifier: Apache-2.0

#include "scene_files/precision.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "renderer/packed_scene.h"
#include "scene/surfaces.h"

namespace plumb {
namespace {

// A point of the flat face near p: the nearest one, unless a sharp corner is.
Vec3 point_near(const Vec3& p, const Surface& face) {
  const auto& c = face.polygon()->corners;
  Vec3 point = p - face.flat_normal * face.flat_normal.dot(p - c[0]);
  for (size_t i = 0; i < c.size(); ++i) {
    const Vec3 edge = c[(i + 1) % c.size()] - c[i];
    if (edge.cross(point - c[i]).dot(face.flat_normal) >= 0.0) continue;
    point = c[i] + edge * std::clamp(edge.dot(point - c[i]) / edge.length2(), 0.0, 1.0);
  }
  return point;
}

// Whether a gap of 10 to 1000 g separates an edge of the face from what it points at on the other.
// Looks at eight places along each edge.
bool leaves_gap(const Surface& face, const Surface& other, double g) {
  constexpr int places = 8;
  const auto& c = face.polygon()->corners;
  for (size_t i = 0; i < places * c.size(); ++i) {
    const Vec3& from = c[i / places];
    const Vec3 edge = c[(i / places + 1) % c.size()] - from;
    const Vec3 place = from + edge * (double(i % places) / places);
    const Vec3& corner = other.polygon()->corners[0];
    if (std::abs(other.flat_normal.dot(corner - place)) > 1000.0 * g) continue;
    const Vec3 gap = point_near(place, other) - place;
    const double width = gap.length();
    const double outwards = gap.dot(edge.cross(face.flat_normal).normalized());
    if (width > 10.0 * g && width < 1000.0 * g && outwards > width / 2.0) return true;
  }
  return false;
}

// Whether the flat lamp shines on the point from less than 2000 g above it, as on a wall next to
// it.
bool meets_edge_on(const Surface& lamp, const Vec3& point, double g) {
  if (!lamp.shape->is_lamp() || lamp.polygon() == nullptr) return false;
  const double height = lamp.flat_normal.dot(point - lamp.polygon()->corners[0]);
  return height > g && height < 2000.0 * g;
}

}  // namespace

std::string needs_double(const Scene& scene) {
  const double g = float_growth(scene);
  const std::vector<Surface> surfaces = list_surfaces(scene);
  const size_t looked_at = surfaces.size() > 300 ? 0 : surfaces.size();
  const auto is_opaque_and_flat = [](const Surface& surface) {
    return surface.polygon() != nullptr && surface.shape->bsdf.kind != Bsdf::Kind::dielectric;
  };
  for (size_t i = 0; i < looked_at * looked_at; ++i) {
    const Surface &a = surfaces[i / looked_at], &b = surfaces[i % looked_at];
    if (a.shape == b.shape || !is_opaque_and_flat(a) || !is_opaque_and_flat(b)) continue;
    if (!leaves_gap(a, b, g)) continue;
    return fmt::format("the gap between '{}' and '{}'", a.shape->id, b.shape->id);
  }
  constexpr int side = 4, rays = side * side;
  const Camera& camera = scene.camera;
  std::set<const Surface*> seen;
  std::vector<double> distances;  // of what is met
  int edge_on = 0;
  for (int i = 0; i < rays; ++i) {
    const int column = i % side, row = i / side;
    const Ray ray{camera.origin, camera.direction((column + 0.5) / side * camera.width,
                                                  (row + 0.5) / side * camera.height)};
    const auto [surface, distance] = find_nearest(surfaces, ray, 0.0);
    seen.insert(surface);
    if (surface == nullptr) continue;
    distances.push_back(distance);
    edge_on += std::ranges::any_of(surfaces, [&, point = ray.at(distance)](const Surface& lamp) {
      return meets_edge_on(lamp, point, g);
    });
  }
  if (2 * edge_on > rays) return "a lamp that is seen edge-on";
  if (distances.empty() || seen.size() == 1) return "";
  const auto [nearest, farthest] = std::ranges::minmax(distances);
  const bool has_silhouettes = seen.contains(nullptr) || farthest > 2.0 * nearest;
  const double width = 2.0 * camera.half_width() * farthest;
  return has_silhouettes && width < 2e5 * g ? "so narrow a view of so large a scene" : "";
}

}  // namespace plumb
