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

// Moves a face inwards and all that is behind it in proportion; by which factor the glass has
// become thinner along the face's normal. Does nothing where that would be a half or less.
double make_thinner(Mesh& glass, const Polygon& face, double by) {
  const Vec3 normal = face.normal();
  const double front = normal.dot(face.corners[0]);
  double back = front;
  for (const Polygon& other : glass) {
    for (const Vec3& corner : other.corners) back = std::min(back, normal.dot(corner));
  }
  const double factor = 1.0 - by / std::max(front - back, by);
  if (!(factor > 0.5)) return factor;
  for (Polygon& other : glass) {
    for (Vec3& corner : other.corners) {
      corner -= normal * ((1.0 - factor) * (normal.dot(corner) - back));
    }
  }
  return factor;
}

// The faces of a mesh, to be found by where they are.
class Places {
 public:
  explicit Places(const Mesh& mesh) {
    for (const Polygon& face : mesh) {
      boxes_.emplace_back(bounds(Mesh{face}), &face);
      widest_ = std::max(widest_, boxes_.back().first.size().x);
    }
    std::ranges::sort(boxes_, {}, left);
  }

  // Calls visit(face) for those whose boxes meet this one.
  void find(const Imath::Box3d& box, const auto& visit) const {
    auto i = std::ranges::lower_bound(boxes_, box.min.x - widest_, {}, left);
    for (; i != boxes_.end() && left(*i) <= box.max.x; ++i) {
      if (i->first.intersects(box)) visit(*i->second);
    }
  }

 private:
  using Place = std::pair<Imath::Box3d, const Polygon*>;
  static double left(const Place& place) { return place.first.min.x; }

  std::vector<Place> boxes_;
  double widest_ = 0.0;
};

// The least of the factors by which the glass had to become thinner; 1: nothing touches it.
double part_from_others(Shape& glass, const std::vector<Shape>& shapes, double size) {
  const double tolerance = close * size;
  auto& mesh = std::get<Mesh>(glass.geometry);
  const Places places(mesh);
  double least = 1.0;
  for (const Shape& other : shapes) {
    const auto* faces = std::get_if<Mesh>(&other.geometry);
    if (&other == &glass || faces == nullptr) continue;
    for (const Polygon& face : *faces) {
      places.find(grown(bounds(Mesh{face}), tolerance), [&](const Polygon& own) {
        if (touch(own, face, tolerance)) {
          least = std::min(least, make_thinner(mesh, own, gap * size));
        }
      });
    }
  }
  return least;
}

}  // namespace

std::vector<std::string> leave_air_around_glass(Scene& scene) {
  const double size = scene.radius();
  std::vector<std::string> notes;
  for (Shape& shape : scene.shapes) {
    const bool is_mesh = std::holds_alternative<Mesh>(shape.geometry);
    if (!is_mesh || shape.bsdf.kind != Bsdf::Kind::dielectric) continue;
    const double factor = part_from_others(shape, scene.shapes, size);
    if (factor == 1.0) continue;
    const std::string who = fmt::format("the glass {} touches another surface", shape.id);
    notes.push_back(factor > 0.5
                        ? fmt::format("{}: it is drawn thinner by {:.2g} %, with air in between",
                                      who, 100.0 * (1.0 - factor))
                        : who + ", and which of them light meets first is undefined: move one");
  }
  return notes;
}

}  // namespace plumb
