// SPDX-License-Identifier: Apache-2.0

#include "radiosity/elements.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace plumb::radiosity {
namespace {

constexpr double smallest = 1.0 / 32.0;  // radius, in parts of Faces::detail()

using Symmetric = std::array<Vec3, 3>;

// By the adjugate.
Symmetric inverse(const Symmetric& m) {
  Symmetric result{m[1].cross(m[2]), m[2].cross(m[0]), m[0].cross(m[1])};
  const double determinant = m[0].dot(result[0]);
  for (Vec3& row : result) row /= determinant;
  return result;
}

Vec3 multiply(const Symmetric& m, const Vec3& v) { return {m[0].dot(v), m[1].dot(v), m[2].dot(v)}; }

void add_point(Element& element, const Vec3& point, double area) {
  element.point[size_t(element.points)] = point;
  element.area[size_t(element.points++)] = area;
}

void add_points(Element& element, const Vec3& normal) {
  const auto& c = element.corners;
  if (element.size == 3) {
    const double area = normal.dot((c[1] - c[0]).cross(c[2] - c[0])) / 6.0;
    const Vec3 sum = c[0] + c[1] + c[2];
    for (size_t i = 0; i < 3; ++i) add_point(element, sum / 6.0 + c[i] * 0.5, area);
    return;
  }
  const double gauss = 0.5 / std::sqrt(3.0);
  for (const double s : {0.5 - gauss, 0.5 + gauss}) {
    for (const double t : {0.5 - gauss, 0.5 + gauss}) {
      const Vec3 low = c[0] + (c[1] - c[0]) * s, high = c[3] + (c[2] - c[3]) * s;
      const Vec3 along = (c[1] - c[0]) * (1.0 - t) + (c[2] - c[3]) * t;
      add_point(element, low + (high - low) * t, normal.dot(along.cross(high - low)) / 4.0);
    }
  }
}

// What two linear functions make, summed over the points of an element.
Symmetric products(const Element& element, const Face& face) {
  Symmetric sum{Vec3(0.0), Vec3(0.0), Vec3(0.0)};
  for (size_t q = 0; q < size_t(element.points); ++q) {
    const Vec3 parts = element.parts(face, element.point[q]);
    for (int i = 0; i < 3; ++i) sum[size_t(i)] += parts * (parts[i] * element.area[q]);
  }
  return sum;
}

void join(const Element& parent, Element& child, const Face& face) {
  const Symmetric of_parent = inverse(products(parent, face));
  Matrix moments;  // of the child's function with the parent's
  for (size_t q = 0; q < size_t(child.points); ++q) {
    const Vec3 own = child.parts(face, child.point[q]), to = parent.parts(face, child.point[q]);
    for (int i = 0; i < 3; ++i) moments.rows[size_t(i)] += own * (to[i] * child.area[q]);
  }
  for (size_t i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k)
      child.to_parent.rows[i] += moments.rows[size_t(k)] * of_parent[i][k];
  }
  const double shrink = child.radius / parent.radius;
  child.from_parent.rows = {parent.parts(face, child.center), Vec3(0.0, shrink, 0.0),
                            Vec3(0.0, 0.0, shrink)};
}

using Segment = std::array<Vec3, 2>;

// Where a face is touched, or almost, by what stands on it, or goes through it.
std::vector<Segment> contacts(const Faces& faces, size_t face) {
  std::vector<Segment> segments;
  const Face& on = faces[face];
  const auto height = [&](const Vec3& point) { return on.normal.dot(point) - on.offset; };
  for (size_t polygon = 0; polygon < faces.polygon_count(); ++polygon) {
    const Place place = faces.place(face, polygon);
    if (place == Place::behind || polygon == on.polygon) continue;
    Convex part;
    for (const Vec3& corner : faces.front(polygon).outline.corners) part.add(corner);
    const double almost = smallest / 4.0 * faces.detail_of(faces.front(polygon).shape);
    if (place == Place::across) part = cut(part, on.normal, on.offset, faces.slack()).before;
    for (int i = 0; i < part.size; ++i) {
      const Vec3& a = part.corners[size_t(i)];
      const Vec3& b = part.corners[size_t((i + 1) % part.size)];
      if (std::max(height(a), height(b)) > almost) continue;
      segments.push_back({a - on.normal * height(a), b - on.normal * height(b)});
    }
  }
  return segments;
}

// A face cut along these: so no element is half in the dark below what stands there.
std::vector<Convex> pieces_of(const Faces& faces, size_t face,
                              const std::vector<Segment>& along_these) {
  std::vector<Convex> pieces(1);
  for (const Vec3& corner : faces[face].outline.corners) pieces[0].add(corner);
  for (const auto& [a, b] : along_these) {
    const Vec3 across = faces[face].normal.cross(b - a).normalized(), along = (b - a).normalized();
    make_room(pieces);
    const size_t count = pieces.size();
    for (size_t i = 0; i < count; ++i) {
      const Parts parts = cut(pieces[i], across, across.dot(a), faces.slack());
      if (parts.before.size == 0 || parts.behind.size == 0) continue;
      const Parts to_b = cut(parts.before, -along, -along.dot(b), faces.slack());
      if (cut(to_b.before, along, along.dot(a), faces.slack()).before.size == 0) continue;
      pieces[i] = parts.before;
      pieces.push_back(parts.behind);
    }
  }
  return pieces;
}

}  // namespace

void Matrix::add_to(Linear<Rgb>& sum, const Linear<Rgb>& factor) const {
  for (size_t i = 0; i < 3; ++i) {
    sum[i] += factor[0] * rows[i].x + factor[1] * rows[i].y + factor[2] * rows[i].z;
  }
}

Element::Element(const Faces& faces, size_t on, std::span<const Vec3> outline)
    : face(on), size(int(outline.size())) {
  std::ranges::copy(outline, corners.begin());
  const Face& of = faces[face];
  add_points(*this, of.normal);
  center = Vec3(0.0);
  for (size_t q = 0; q < size_t(points); ++q) {
    center += point[q] * area[q];
    whole += area[q];
  }
  center /= whole;
  radius = 0.0;
  for (const Vec3& corner : outline) radius = std::max(radius, (corner - center).length());
  const Symmetric matrix = inverse(products(*this, of));
  for (size_t q = 0; q < size_t(points); ++q) {
    fit[q] = multiply(matrix, parts(of, point[q])) * area[q];
  }
}

Vec3 Element::parts(const Face& of, const Vec3& at) const {
  const Vec3 offset = (at - center) / radius;
  return {1.0, offset.dot(of.u), offset.dot(of.v)};
}

std::array<Element, 2> Element::halves(const Faces& faces) const {
  const auto& c = corners;
  const auto half = [&](std::initializer_list<Vec3> outline) {
    Element result(faces, face, std::span(outline.begin(), outline.size()));
    join(*this, result, faces[face]);
    return result;
  };
  const auto middle = [&](size_t i, size_t k) { return (c[i] + c[k]) * 0.5; };
  if (size == 3) {
    size_t i = 0;  // where the longest side begins
    const auto length = [&](size_t k) { return (c[(k + 1) % 3] - c[k]).length2(); };
    for (const size_t k : {1, 2}) i = length(k) > length(i) ? k : i;
    const size_t k = (i + 1) % 3, opposite = (i + 2) % 3;
    const Vec3 m = middle(i, k);
    return {half({c[i], m, c[opposite]}), half({m, c[k], c[opposite]})};
  }
  const Vec3 a = middle(0, 1), b = middle(1, 2), d = middle(2, 3), e = middle(3, 0);
  if ((b - e).length2() > (d - a).length2()) {
    return {half({c[0], a, d, c[3]}), half({a, c[1], c[2], d})};
  }
  return {half({c[0], c[1], b, e}), half({e, b, c[2], c[3]})};
}

std::vector<Element> parts_of(const Faces& faces, size_t face, bool is_cut) {
  std::vector<Element> parts;
  for (const Convex& piece :
       pieces_of(faces, face, is_cut ? contacts(faces, face) : std::vector<Segment>())) {
    const auto& c = piece.corners;
    for (int i = 2; i < piece.size; i += 2) {
      std::vector<Vec3> outline{c[0], c[size_t(i - 1)], c[size_t(i)]};
      if (i + 1 < piece.size) outline.push_back(c[size_t(i + 1)]);
      const Element part(faces, face, outline);
      const bool is_flat = part.whole <= faces.slack() * faces.size();  // its corners are in a line
      if (!is_flat) parts.push_back(part);
    }
  }
  return parts;
}

Elements::Elements(const Faces& faces, size_t most) : faces_(faces), most_(most) {
  // Radii, in parts of the scene's size; and over the distance from an edge.
  constexpr double largest = 1.0 / 12.0, grading = 0.5;
  const double size = faces.size();
  for (size_t face = 0; face < faces.list().size(); ++face) {
    if (!faces[face].reflects()) continue;
    for (const Element& part : parts_of(faces, face, true)) add(part);
  }
  roots_ = list_.size();
  for (size_t i = 0; i < list_.size(); ++i) {
    const Element& element = list_[i];
    const bool is_split =
        i < roots_ || element.radius > largest * size ||
        (element.radius > smallest * element.detail && element.nearness > grading);
    if (is_split) split(i);
  }
}

void Elements::add(Element element) {
  element.nearness = faces_.nearness(element.face, element.center, element.radius);
  element.detail = faces_.detail(element.face, element.center);
  list_.push_back(element);
}

void Elements::refine(std::vector<double> unevenness, double allowed) {
  std::vector<double> sorted;
  for (size_t i = 0; i < list_.size(); ++i) {
    if (!list_[i].has_children()) sorted.push_back(unevenness[i]);
  }
  if (sorted.empty()) return;
  const auto middle = sorted.begin() + std::ptrdiff_t(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  allowed = std::min(allowed, *middle);
  for (size_t i = 0; i < list_.size(); ++i) {
    if (list_[i].has_children() || unevenness[i] <= allowed) continue;
    split(i);
    const double most = std::min(unevenness[i], 8.0 * allowed);
    for (const int child : {list_[i].child, list_[i].child + 1}) {
      const Element& half = list_[size_t(child)];
      unevenness.push_back(most * half.radius / list_[i].radius *
                           std::pow(half.nearness / list_[i].nearness, 2) * list_[i].detail /
                           half.detail);
    }
  }
}

void Elements::split(size_t i) {
  if (list_.size() + 2 > most_) {
    throw std::length_error(
        fmt::format("more than {} elements don't fit into half of the memory", leaves()));
  }
  const std::array<Element, 2> halves = list_[i].halves(faces_);
  list_[i].child = static_cast<int>(list_.size());
  for (const Element& half : halves) add(half);
}

void Elements::pull(std::vector<Linear<Rgb>>& functions) const {
  for (size_t i = list_.size(); i-- > 0;) {
    if (!list_[i].has_children()) continue;
    functions[i] = dark;
    for (const int c : {list_[i].child, list_[i].child + 1}) {
      list_[size_t(c)].to_parent.add_to(functions[i], functions[size_t(c)]);
    }
  }
}

void Elements::push(std::vector<Linear<Rgb>>& functions) const {
  for (size_t i = 0; i < list_.size(); ++i) {
    if (!list_[i].has_children()) continue;
    for (const int c : {list_[i].child, list_[i].child + 1}) {
      list_[size_t(c)].from_parent.add_to(functions[size_t(c)], functions[i]);
    }
  }
}

}  // namespace plumb::radiosity
