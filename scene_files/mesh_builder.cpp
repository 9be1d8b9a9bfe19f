// SPDX-License-Identifier: Apache-2.0

#include "scene_files/mesh_builder.h"

#include <algorithm>
#include <cmath>

namespace plumb {
namespace {

// Unit vectors that differ by less are the same: files hold few digits.
constexpr double same_direction = 1e-3;

// Of a triangle: whether it has an area.
bool is_flat_and_convex(const Polygon& polygon) {
  const auto& c = polygon.corners;
  const Vec3 normal = polygon.normal();
  double size = 0.0;
  for (const Vec3& corner : c) size = std::max(size, (corner - c[0]).length());
  for (size_t i = 0; i < c.size(); ++i) {
    const Vec3 in = c[(i + 1) % c.size()] - c[i];
    const Vec3 out = c[(i + 2) % c.size()] - c[(i + 1) % c.size()];
    if (!(std::abs(normal.dot(c[i] - c[0])) <= 1e-6 * size)) return false;
    if (!(in.cross(out).dot(normal) > 1e-12 * size * size)) return false;
  }
  return true;
}

}  // namespace

MeshBuilder::MeshBuilder(const Imath::M44d& to_world)
    : to_world_(to_world), normals_to_world_(to_world.inverse().transposed()) {}

void MeshBuilder::add_vertex(const Vec3& v) {
  vertices_.push_back(v * to_world_);
  normal_at_.emplace_back();
}

void MeshBuilder::add_normal(const Vec3& n) {
  Vec3 normal;
  normals_to_world_.multDirMatrix(n, normal);
  normals_.push_back(normal.normalized());
}

void MeshBuilder::add_face(const std::vector<Corner>& corners) {
  Polygon face;
  for (const Corner& corner : corners) face.corners.push_back(vertices_[corner.vertex]);
  if (corners.size() <= 4 && is_flat_and_convex(face)) return keep(face, corners);
  bool is_folded = false;
  std::optional<Vec3> first;  // triangle's normal
  for (size_t i = 2; i < corners.size(); ++i) {
    const Polygon triangle{{face.corners[0], face.corners[i - 1], face.corners[i]}};
    if (is_flat_and_convex(triangle)) {
      if (!first) first = triangle.normal();
      is_folded |= triangle.normal().dot(*first) < 0.0;
      keep(triangle, {corners[0], corners[i - 1], corners[i]});
    } else {
      ++mesh_.without_area;
    }
  }
  mesh_.folded += is_folded ? 1 : 0;
}

void MeshBuilder::keep(const Polygon& face, const std::vector<Corner>& corners) {
  const Vec3 normal = face.normal();
  const auto is_same = [&](const Vec3& n) { return (n - normal).length() < same_direction; };
  for (const Corner& corner : corners) {
    mesh_.lacks_normals |= !corner.normal;
    if (!corner.normal) continue;
    mesh_.has_normals = true;
    mesh_.normals_are_flat &= is_same(normals_[*corner.normal]);
  }
  for (const Corner& corner : corners) {
    auto& first = normal_at_[corner.vertex];
    if (first) mesh_.shares_corners |= !is_same(*first);
    first = normal;
  }
  mesh_.faces.push_back(face);
}

}  // namespace plumb
