// SPDX-License-Identifier: Apache-2.0

#include "radiosity/convex.h"

#include <algorithm>
#include <cmath>

namespace plumb::radiosity {
namespace {

using Heights = std::array<double, Convex::most>;

Parts cut(const Convex& polygon, const Heights& heights) {
  Parts parts;
  bool is_before = false, is_behind = false;
  for (int i = 0; i < polygon.size; ++i) {
    const size_t a = size_t(i), b = size_t(i + 1 == polygon.size ? 0 : i + 1);
    const double at_a = heights[a], at_b = heights[b];
    is_before = is_before || at_a > 0.0;
    is_behind = is_behind || at_a < 0.0;
    if (at_a >= 0.0) parts.before.add(polygon.corners[a]);
    if (at_a <= 0.0) parts.behind.add(polygon.corners[a]);
    if ((at_a > 0.0 && at_b < 0.0) || (at_a < 0.0 && at_b > 0.0)) {
      const Vec3& from = polygon.corners[a];
      const Vec3 between = from + (polygon.corners[b] - from) * (at_a / (at_a - at_b));
      parts.before.add(between);
      parts.behind.add(between);
    }
  }
  if (!is_before || parts.before.size < 3) parts.before.size = 0;
  if (!is_behind || parts.behind.size < 3) parts.behind.size = 0;
  return parts;
}

Heights heights(const Convex& polygon, const Side& side) {
  Heights result;
  for (int i = 0; i < polygon.size; ++i)
    result[size_t(i)] = side.height(polygon.corners[size_t(i)]);
  return result;
}

}  // namespace

bool Cone::misses(const Convex& polygon) const {
  return std::ranges::any_of(sides, [&](const Side& side) {
    for (int i = 0; i < polygon.size; ++i) {
      if (side.height(polygon.corners[size_t(i)]) > 0.0) return false;
    }
    return true;
  });
}

bool Cone::covers(const Convex& polygon) const {
  return std::ranges::all_of(sides, [&](const Side& side) {
    for (int i = 0; i < polygon.size; ++i) {
      if (side.height(polygon.corners[size_t(i)]) < 0.0) return false;
    }
    return true;
  });
}

Cone cone_of(const Convex& polygon, bool is_front, double size) {
  Cone cone;
  cone.sides.reserve(size_t(polygon.size));
  for (int i = 0; i < polygon.size; ++i) {
    const Vec3& a = polygon.corners[size_t(i)];
    const Vec3& b = polygon.corners[size_t((i + 1) % polygon.size)];
    const Vec3 normal = is_front ? b.cross(a) : a.cross(b);
    if (normal != Vec3(0.0)) cone.sides.emplace_back(normal, size);  // 0: equal corners
  }
  return cone;
}

Parts cut(const Convex& polygon, const Side& side) { return cut(polygon, heights(polygon, side)); }

Parts cut(const Convex& polygon, const Vec3& normal, double offset, double slack) {
  Heights heights;
  for (int i = 0; i < polygon.size; ++i) {
    const double h = normal.dot(polygon.corners[size_t(i)]) - offset;
    heights[size_t(i)] = std::abs(h) <= slack ? 0.0 : h;
  }
  return cut(polygon, heights);
}

void make_room(std::vector<Convex>& pieces) {
  constexpr int most_cuts = 5;  // of a cone
  for (size_t i = 0; i < pieces.size(); ++i) {
    const Convex whole = pieces[i];
    if (whole.size + most_cuts <= Convex::most) continue;
    const int middle = whole.size / 2;
    pieces[i].size = middle + 1;
    Convex rest;
    for (int k = middle; k <= whole.size; ++k) rest.add(whole.corners[size_t(k % whole.size)]);
    pieces.push_back(rest);
  }
}

void subtract(std::vector<Convex>& pieces, const Cone& cone) {
  make_room(pieces);
  const size_t count = pieces.size();
  for (size_t i = 0; i < count; ++i) {
    if (cone.misses(pieces[i])) continue;
    Convex rest = pieces[i];
    for (const Side& side : cone.sides) {
      const Heights at = heights(rest, side);
      if (*std::min_element(at.begin(), at.begin() + rest.size) >= 0.0) continue;
      const Parts parts = cut(rest, at);
      if (parts.behind.size > 0) pieces.push_back(parts.behind);
      rest = parts.before;
      if (rest.size == 0) break;
    }
    pieces[i].size = 0;
  }
  std::erase_if(pieces, [](const Convex& piece) { return piece.size == 0; });
}

}  // namespace plumb::radiosity
