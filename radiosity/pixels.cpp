// SPDX-License-Identifier: Apache-2.0

#include "radiosity/pixels.h"

#include <algorithm>
#include <cmath>

namespace plumb::radiosity {

Pixels::Pixels(const Faces& faces, const Camera& camera) : faces_(faces), camera_(camera) {
  const double side = 2.0 * camera.half_width() / camera.width;
  pixel_area_ = side * side;
  for (size_t face = 0; face < faces.list().size(); ++face) {
    const Face& seen = faces[face];
    if (seen.normal.dot(camera.origin) - seen.offset <= faces.slack()) continue;
    Sight sight{face, *cone_before(seen.polygon, face), {}};
    for (size_t polygon = 0; polygon < faces.polygon_count(); ++polygon) {
      const Place place = faces.place(face, polygon);
      const bool is_before = place == Place::before || place == Place::across;
      if (polygon == seen.polygon || !(is_before || faces.is_on_top(polygon, face))) continue;
      if (const auto cone = cone_before(polygon, face)) sight.obstacles.push_back(*cone);
    }
    sights_.push_back(std::move(sight));
  }
}

// Of the part of a polygon that is before the face's plane, or in it, as seen from the camera.
std::optional<Cone> Pixels::cone_before(size_t polygon, size_t face) const {
  const Face& front = faces_.front(polygon);
  const double height = front.normal.dot(camera_.origin) - front.offset;
  if (std::abs(height) <= faces_.slack()) return {};
  Convex part;
  for (const Vec3& corner : front.outline.corners) part.add(corner - camera_.origin);
  if (faces_.place(face, polygon) == Place::across) {
    const Face& of = faces_[face];
    part = cut(part, of.normal, of.offset - of.normal.dot(camera_.origin), faces_.slack()).before;
  }
  if (part.size == 0) return {};
  return cone_of(part, height > 0.0, 1.0);
}

std::vector<Fragment> Pixels::fragments(int x, int y) const {
  Convex square;
  for (const auto& [right, down] : {std::pair(0, 0), {0, 1}, {1, 1}, {1, 0}}) {
    square.add(camera_.direction(x + right, y + down));
  }
  std::vector<Fragment> fragments;
  std::vector<Convex> pieces;
  for (const Sight& sight : sights_) {
    if (sight.cone.misses(square)) continue;
    Convex part = square;
    for (const Side& side : sight.cone.sides) part = cut(part, side).before;
    if (part.size == 0) continue;
    pieces.assign(1, part);
    for (const Cone& cone : sight.obstacles) subtract(pieces, cone);
    for (const Convex& piece : pieces) fragments.push_back({sight.face, piece});
  }
  return fragments;
}

double Pixels::area(const Vec3& a, const Vec3& b, const Vec3& c) const {
  return std::abs(camera_.forward.dot((b - a).cross(c - a))) / (2.0 * pixel_area_);
}

double Pixels::share(const Fragment& fragment) const {
  double sum = 0.0;
  const auto& corners = fragment.part.corners;
  for (size_t i = 2; i < size_t(fragment.part.size); ++i) {
    sum += area(corners[0], corners[i - 1], corners[i]);
  }
  return sum;
}

bool Pixels::is_smooth(const Fragment& fragment) const {
  const auto& c = fragment.part.corners;
  if (fragment.part.size != 4 || share(fragment) < 1.0 - 1e-9) return false;
  const Vec3 middle = meet((c[0] + c[2]) * 0.5, fragment.face);
  double radius = 0.0;
  for (size_t i = 0; i < 4; ++i) {
    radius = std::max(radius, (meet(c[i], fragment.face) - middle).length());
  }
  return faces_.nearness(fragment.face, middle, radius) <= 0.3;
}

Vec3 Pixels::meet(const Vec3& direction, size_t face) const {
  const Face& of = faces_[face];
  const double height = of.offset - of.normal.dot(camera_.origin);
  return camera_.origin + direction * (height / of.normal.dot(direction));
}

Rgb Pixels::at(const Vec3& direction, size_t face, Eye& eye, const Light& light) const {
  eye.move_to(face, meet(direction, face));
  return light(eye);
}

Rgb Pixels::over_triangle(const std::array<Vec3, 3>& corners, size_t face, Quadrature quadrature,
                          Eye& eye, const Light& light) const {
  const auto& [a, b, c] = corners;
  std::array<Rgb, 3> values;
  Rgb most(0.0), spread(0.0);
  for (size_t i = 0; i < 3; ++i) {
    values[i] = at((a + b + c) / 6.0 + corners[i] * 0.5, face, eye, light);
  }
  for (int k = 0; k < 3; ++k) {
    const auto [low, high] = std::minmax({values[0][k], values[1][k], values[2][k]});
    most[k] = high;
    spread[k] = high - low;
  }
  if (quadrature.depth == 0 || spread.length() <= quadrature.spread * most.length()) {
    return (values[0] + values[1] + values[2]) * (area(a, b, c) / 3.0);
  }
  const Vec3 ab = (a + b) * 0.5, bc = (b + c) * 0.5, ca = (c + a) * 0.5;
  --quadrature.depth;
  Rgb sum(0.0);
  for (const auto& quarter : {std::array{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}}) {
    sum += over_triangle(quarter, face, quadrature, eye, light);
  }
  return sum;
}

Rgb Pixels::integrate(const Fragment& fragment, const std::optional<Quadrature>& quadrature,
                      Eye& eye, const Light& light) const {
  const auto& c = fragment.part.corners;
  if (!quadrature) return at((c[0] + c[2]) * 0.5, fragment.face, eye, light);
  Rgb sum(0.0);
  for (size_t i = 2; i < size_t(fragment.part.size); ++i) {
    sum += over_triangle({c[0], c[i - 1], c[i]}, fragment.face, *quadrature, eye, light);
  }
  return sum;
}

}  // namespace plumb::radiosity
