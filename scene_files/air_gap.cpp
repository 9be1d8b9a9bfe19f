// SPDX-License-Identifier: Apache-2.0

#include "scene_files/air_gap.h"

#include <Imath/ImathBox.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace plumb {
namespace {

constexpr double gap = 3e-5;    // float loses less than a tenth of it
constexpr double close = 1e-7;  // what counts as touching; both in half diagonals of the scene

Imath::Box3d bounds(const Shape& shape) {
  Imath::Box3d box;
  if (const auto* sphere = std::get_if<Sphere>(&shape.geometry)) {
    box.extendBy(sphere->center - Vec3(sphere->radius));
    box.extendBy(sphere->center + Vec3(sphere->radius));
    return box;
  }
  for (const Polygon& face : std::get<Mesh>(shape.geometry)) {
    for (const Vec3& corner : face.corners) box.extendBy(corner);
  }
  return box;
}

Imath::Box3d grown(const Imath::Box3d& box, double by) {
  return {box.min - Vec3(by), box.max + Vec3(by)};
}

// Whether both lie in one plane and share a part of it.
bool touch(const Polygon& a, const Polygon& b, double tolerance) {
  const Vec3 normal = a.normal();
  const bool is_coplanar = std::ranges::all_of(b.corners, [&](const Vec3& corner) {
    return std::abs(normal.dot(corner - a.corners[0])) <= tolerance;
  });
  if (!is_coplanar) return false;
  std::vector<Vec3> shared = b.corners;
  for (size_t i = 0; i < a.corners.size(); ++i) {
    const Vec3 edge = a.corners[(i + 1) % a.corners.size()] - a.corners[i];
    const Vec3 inwards = normal.cross(edge).normalized();
    shared = part_beyond(shared, inwards, inwards.dot(a.corners[i]) + tolerance);
  }
  return shared.size() >= 3;
}

// By which the glass must shrink; 1: nothing touches it; not above 0: it is flat.
double shrinking(const Scene& scene, const Shape& glass, double size) {
  const Imath::Box3d box = bounds(glass);
  double factor = 1.0;
  for (const Shape& other : scene.shapes) {
    const auto* mesh = std::get_if<Mesh>(&other.geometry);
    if (&other == &glass || mesh == nullptr) continue;
    if (!grown(bounds(other), close * size).intersects(box)) continue;
    for (const Polygon& face : *mesh) {
      Imath::Box3d face_box;
      for (const Vec3& corner : face.corners) face_box.extendBy(corner);
      if (!grown(face_box, close * size).intersects(box)) continue;
      for (const Polygon& own : std::get<Mesh>(glass.geometry)) {
        if (!touch(own, face, close * size)) continue;
        const double depth = std::abs(own.normal().dot(box.center() - own.corners[0]));
        factor = std::min(factor, 1.0 - gap * size / std::max(depth, 1e-300));
      }
    }
  }
  return factor;
}

}  // namespace

std::vector<std::string> leave_air_around_glass(Scene& scene) {
  Imath::Box3d box;
  for (const Shape& shape : scene.shapes) box.extendBy(bounds(shape));
  const double size = box.isEmpty() ? 0.0 : (box.max - box.center()).length();
  std::vector<std::string> notes;
  for (Shape& shape : scene.shapes) {
    auto* mesh = std::get_if<Mesh>(&shape.geometry);
    if (mesh == nullptr || shape.bsdf.kind != Bsdf::Kind::dielectric) continue;
    const double factor = shrinking(scene, shape, size);
    if (factor == 1.0) continue;
    const std::string who =
        fmt::format("the glass {}touches another surface", shape.id.empty() ? "" : shape.id + " ");
    if (!(factor > 0.5)) {
      notes.push_back(who + ", and which of them light meets first is undefined: move one");
      continue;
    }
    const Vec3 middle = bounds(shape).center();
    for (Polygon& face : *mesh) {
      for (Vec3& corner : face.corners) corner = middle + (corner - middle) * factor;
    }
    notes.push_back(
        fmt::format("{}: it is drawn smaller by {:.2g}, with air in between", who, 1.0 - factor));
  }
  return notes;
}

}  // namespace plumb
