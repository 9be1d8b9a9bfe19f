// SPDX-License-Identifier: Apache-2.0

// Convex polygons as they are seen from a point, and what is left of them behind others: exactly,
// by cutting them along planes through the point. All corners are relative to that point.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "scene/scene.h"

namespace plumb::radiosity {

struct Convex {
  static constexpr int most = 16;  // corners; each cut may add one
  int size = 0;                    // 0: nothing, else at least 3
  std::array<Vec3, most> corners;

  Convex() = default;
  // Most have four corners of sixteen.
  Convex(const Convex& other) { *this = other; }
  Convex& operator=(const Convex& other) {
    size = other.size;
    std::copy_n(other.corners.begin(), size, corners.begin());
    return *this;
  }

  void add(const Vec3& corner) { corners[size_t(size++)] = corner; }
};

// A plane through the origin. What is closer to it than rounding tells lies in it, so that shared
// edges leave no slivers.
struct Side {
  Vec3 normal;  // of any length
  double slack;

  // `size` bounds the coordinates of what is cut.
  Side(const Vec3& towards, double size)
      : normal(towards),
        slack(1e-13 * size * (std::abs(towards.x) + std::abs(towards.y) + std::abs(towards.z))) {}

  // Positive on the side of the normal, 0 in the plane; in units of the normal's length.
  double height(const Vec3& point) const {
    const double h = normal.dot(point);
    return std::abs(h) <= slack ? 0.0 : h;
  }
};

// All directions in which a convex polygon is seen.
struct Cone {
  std::vector<Side> sides;  // their normals point inwards

  // No point of the polygon is inside; or all are. Both may also be false of one that is outside,
  // beyond two sides.
  bool misses(const Convex& polygon) const;
  bool covers(const Convex& polygon) const;
};

// The cone of a flat convex polygon, relative to the origin, whose plane the origin isn't in.
// `is_front`: the corners are counter-clockwise for who looks from the origin.
Cone cone_of(const Convex& polygon, bool is_front, double size);

// The parts of a polygon before and behind a plane.
struct Parts {
  Convex before, behind;
};
Parts cut(const Convex& polygon, const Side& side);
Parts cut(const Convex& polygon, const Vec3& normal, double offset, double slack);

// Halves the pieces with so many corners that five cuts might add more than there is room for.
void make_room(std::vector<Convex>& pieces);

// Takes away from each of the pieces what lies in the cone.
void subtract(std::vector<Convex>& pieces, const Cone& cone);

}  // namespace plumb::radiosity
