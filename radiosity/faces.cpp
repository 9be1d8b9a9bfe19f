// SPDX-License-Identifier: Apache-2.0

#include "radiosity/faces.h"

#include <Imath/ImathBox.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace plumb::radiosity {
namespace {

using Box = Imath::Box<Vec3>;

void extend(Box& box, std::span<const Vec3> corners) {
  for (const Vec3& corner : corners) box.extendBy(corner);
}

const char* why_refused(const Shape& shape) {
  if (std::holds_alternative<Sphere>(shape.geometry)) return "a sphere";
  switch (shape.bsdf.kind) {
    case Bsdf::Kind::diffuse: return nullptr;
    case Bsdf::Kind::dielectric: return "of glass";
    case Bsdf::Kind::conductor: return shape.bsdf.is_metal() ? "of metal" : "a mirror";
  }
  return nullptr;
}

void refuse_all_but_matte_polygons(const Scene& scene) {
  std::string refused;
  for (const Shape& shape : scene.shapes) {
    const char* why = why_refused(shape);
    if (why != nullptr) refused += fmt::format("\n  '{}' is {}", shape.id, why);
  }
  if (scene.has_sky()) refused += "\n  a sky ('constant' emitter)";
  if (!scene.points.empty()) refused += "\n  point lamps: they have no size";
  if (scene.camera.filter.kind != Filter::Kind::box || scene.camera.filter.size != 0.5) {
    refused +=
        "\n  a filter other than <rfilter type=\"box\"/>: a pixel is the mean over its square";
  }
  if (refused.empty()) return;
  throw Refusal("radiosity is for matte polygons, lamps among them, but there is:" + refused);
}

bool is_seen(Place place) { return place == Place::before || place == Place::across; }

Place place_of(const Polygon& polygon, const Face& face, double slack) {
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (const Vec3& corner : polygon.corners) {
    const double height = face.normal.dot(corner) - face.offset;
    least = std::min(least, height);
    most = std::max(most, height);
  }
  if (most <= slack) return least >= -slack ? Place::inside : Place::behind;
  return least >= -slack ? Place::before : Place::across;
}

[[noreturn]] void refuse_memory(size_t faces, size_t bytes) {
  throw std::length_error(fmt::format(
      "what may be between each two of {} faces needs {:.2g} GB or more, and half of the "
      "memory is less: radiosity is for some hundred faces",
      faces, double(bytes) / 1e9));
}

double distance(const Vec3& point, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double t = std::clamp((point - a).dot(along) / along.length2(), 0.0, 1.0);
  return (point - a - along * t).length();
}

Face make_face(const Polygon& outline, const Shape& shape, size_t index, size_t polygon) {
  const auto& c = outline.corners;
  Face face{.outline = outline,
            .normal = outline.normal(),
            .offset = 0.0,
            .u = (c[1] - c[0]).normalized(),
            .v = Vec3(0.0),
            .shape = index,
            .polygon = polygon,
            .reflectance = shape.bsdf.reflectance,
            .radiance = shape.radiance};
  for (const Vec3& corner : c) face.offset += face.normal.dot(corner) / double(c.size());
  face.v = face.normal.cross(face.u);
  return face;
}

}  // namespace

Faces::Faces(const Scene& scene, size_t most_bytes, const Work& work) {
  refuse_all_but_matte_polygons(scene);
  for (size_t i = 0; i < scene.shapes.size(); ++i) add(scene.shapes[i], i);
  Box box;
  box.extendBy(scene.camera.origin);
  for (const Face& face : faces_) extend(box, face.outline.corners);
  size_ = box.size().length();
  slack_ = Polygon::rounding * size_;
  find_extents(scene.shapes.size());
  const size_t count = faces_.size();
  bytes_ = count * fronts_.size() * sizeof(Place) + count * count * sizeof(View);
  if (bytes_ > most_bytes) refuse_memory(count, bytes_);
  find_places(work);
  for (size_t p = 0; p < fronts_.size(); ++p) {
    if (p == 0 || front(p).shape != front(p - 1).shape) find_solid(p);
  }
  find_views(most_bytes, work);
}

void Faces::add(const Shape& shape, size_t index) {
  for (Polygon outline : std::get<Mesh>(shape.geometry)) {
    if (shape.is_lamp()) lamps_.push_back(faces_.size());
    fronts_.push_back(faces_.size());
    has_back_.push_back(shape.bsdf.two_sided);
    faces_.push_back(make_face(outline, shape, index, fronts_.size() - 1));
    if (!shape.bsdf.two_sided) continue;
    std::reverse(outline.corners.begin(), outline.corners.end());
    faces_.push_back(make_face(outline, shape, index, fronts_.size() - 1));
    faces_.back().radiance = Rgb(0.0);
  }
}

// If the polygons of a shape, from the first one on, are a solid's.
void Faces::find_solid(size_t first) {
  Solid solid;
  Vec3 missing(0.0);  // area, along the normal: those of a closed surface add up to nothing
  std::vector<std::array<Vec3, 2>> edges;
  for (size_t p = first; p < fronts_.size() && front(p).shape == front(first).shape; ++p) {
    const auto& c = front(p).outline.corners;
    solid.polygons.push_back(p);
    for (size_t i = 0; i < c.size(); ++i) {
      edges.push_back({c[i], c[(i + 1) % c.size()]});
      missing -= c[i].cross(edges.back()[1]) * 0.5;
    }
  }
  if (solid.polygons.size() < 3) return;
  const auto is_within = [&](const Vec3& normal, double offset) {
    return std::ranges::all_of(
        edges, [&](const auto& edge) { return normal.dot(edge[0]) - offset <= slack_; });
  };
  for (const size_t p : solid.polygons) {
    if (!is_within(front(p).normal, front(p).offset)) return;
  }
  const auto touch = [&](const Vec3& a, const Vec3& b) { return (a - b).length() <= slack_; };
  for (const auto& [a, b] : edges) {
    const bool is_shared = std::ranges::any_of(
        edges, [&](const auto& edge) { return touch(edge[0], b) && touch(edge[1], a); });
    if (is_shared) continue;
    if (missing.length() <= slack_ * size_) return;
    if (!solid.open) solid.open = Imath::Plane3d(a, missing.normalized());
    const Vec3& normal = solid.open->normal;
    const double offset = solid.open->distance;
    const bool is_in_plane =
        std::abs(normal.dot(a) - offset) <= slack_ && std::abs(normal.dot(b) - offset) <= slack_;
    if (!is_in_plane || !is_within(normal, offset)) return;
  }
  solids_.push_back(solid);
}

void Faces::find_extents(size_t shapes) {
  std::vector<Box> boxes(shapes);
  for (const Face& face : faces_) extend(boxes[face.shape], face.outline.corners);
  for (const Box& box : boxes) extents_.push_back(box.isEmpty() ? 0.0 : box.size().length());
}

void Faces::find_places(const Work& work) {
  places_.resize(faces_.size() * fronts_.size());
  work.for_each("faces", places_.size(), [&](size_t i) {
    const size_t polygon = i % fronts_.size();
    places_[i] = place_of(front(polygon).outline, faces_[i / fronts_.size()], slack_);
  });
}

bool Faces::is_on_top(size_t polygon, size_t face) const {
  if (polygon >= faces_[face].polygon || place(face, polygon) != Place::inside) return false;
  return has_back_[polygon] || front(polygon).normal.dot(faces_[face].normal) > 0.0;
}

double Faces::distance(const Vec3& point, size_t polygon) const {
  const auto& c = front(polygon).outline.corners;
  double least = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < c.size(); ++i) {
    least = std::min(least, radiosity::distance(point, c[i], c[(i + 1) % c.size()]));
  }
  return least;
}

double Faces::nearness(size_t face, const Vec3& center, double radius) const {
  double least = std::numeric_limits<double>::infinity();
  for (size_t polygon = 0; polygon < polygon_count(); ++polygon) {
    if (is_seen(place(face, polygon))) least = std::min(least, distance(center, polygon));
  }
  return radius / std::max(radius, least);
}

double Faces::detail(size_t face, const Vec3& point) const {
  double least = size_;
  for (size_t polygon = 0; polygon < polygon_count(); ++polygon) {
    const size_t shape = front(polygon).shape;
    if (shape == faces_[face].shape || detail_of(shape) >= least) continue;
    if (!is_seen(place(face, polygon))) continue;
    const double away = largest_detail * distance(point, polygon);
    least = std::min(least, std::max(detail_of(shape), away));
  }
  return least;
}

void Faces::find_views(size_t most_bytes, const Work& work) {
  const size_t count = faces_.size();
  views_.resize(count * count);
  std::atomic<size_t> bytes = bytes_;
  work.for_each("views", views_.size(), [&](size_t i) {
    views_[i] = find_view(i / count, i % count);
    views_[i].obstacles.shrink_to_fit();
    bytes += views_[i].obstacles.size() * sizeof(int);
    if (bytes > most_bytes) refuse_memory(count, bytes);
  });
  bytes_ = bytes;
}

View Faces::find_view(size_t from, size_t to) const {
  View view;
  const Face &a = faces_[from], &b = faces_[to];
  view.is_any = is_seen(place(from, b.polygon)) && is_seen(place(to, a.polygon));
  if (!view.is_any) return view;
  view.is_cut = place(from, b.polygon) == Place::across;
  for (size_t q = 0; q < fronts_.size(); ++q) {
    const bool is_between = q != a.polygon && q != b.polygon && is_seen(place(from, q)) &&
                            (is_seen(place(to, q)) || is_on_top(q, to));
    if (is_between && may_block(q, a.outline.corners, b.outline.corners))
      view.obstacles.push_back(static_cast<int>(q));
  }
  return view;
}

bool Faces::may_block(size_t polygon, std::span<const Vec3> a, std::span<const Vec3> b) const {
  const Face& obstacle = front(polygon);
  bool is_before = false, is_behind = false;
  Box both, own;
  for (const std::span<const Vec3>& part : {a, b}) {
    extend(both, part);
    for (const Vec3& corner : part) {
      const double height = obstacle.normal.dot(corner) - obstacle.offset;
      is_before = is_before || height > -slack_;
      is_behind = is_behind || height < slack_;
    }
  }
  extend(own, obstacle.outline.corners);
  const Vec3 room(slack_);
  return is_before && is_behind && both.intersects(Box(own.min - room, own.max + room));
}

}  // namespace plumb::radiosity
