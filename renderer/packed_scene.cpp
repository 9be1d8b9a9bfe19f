// SPDX-License-Identifier: Apache-2.0

#include "renderer/packed_scene.h"

#include <Imath/ImathBox.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "scene/surfaces.h"

namespace plumb {
namespace {

// A point of a surface is off by at most eight roundings: three for each of two dot products and
// one for each of two sums; and so is the test of where it lies.
constexpr double rounding_errors = 16.0;

template <typename T>
PackedVec3<T> pack(const Vec3& v) {
  return {static_cast<T>(v.x), static_cast<T>(v.y), static_cast<T>(v.z)};
}

// The plane through `point`, moved by `shift` along its normal.
template <typename T>
Plane<T> pack_plane(const Vec3& normal, const Vec3& point, double shift = 0.0) {
  return {pack<T>(normal), static_cast<T>(-normal.dot(point) - shift)};
}

// Whether every edge lies between two faces, and no corner above any face.
bool is_convex_solid(const Mesh& mesh) {
  std::vector<std::pair<Vec3, Vec3>> edges;
  for (const Polygon& face : mesh) {
    for (size_t i = 0; i < face.corners.size(); ++i) {
      edges.emplace_back(face.corners[i], face.corners[(i + 1) % face.corners.size()]);
    }
  }
  const auto has_opposite = [&](const auto& edge) {
    return std::ranges::count(edges, std::pair(edge.second, edge.first)) == 1;
  };
  const auto is_below = [&](const Polygon& face) {
    const Vec3 normal = face.normal();
    const double size = (face.corners[2] - face.corners[0]).length();
    return std::ranges::all_of(edges, [&](const auto& edge) {
      return normal.dot(edge.first - face.corners[0]) <= Polygon::rounding * size;
    });
  };
  return std::ranges::all_of(edges, has_opposite) && std::ranges::all_of(mesh, is_below);
}

// A surface in the normalised space, and how rays are tested against it.
struct PlacedSurface : Surface {
  bool of_solid = false;
  bool of_tree = false;
};

// Meshes of more faces are tested by way of a tree, which costs more for smaller ones; a face of a
// solid costs a fifth of another.
constexpr size_t max_faces_without_tree = 32;
constexpr size_t max_faces_of_solid = 128;

std::vector<PlacedSurface> place_surfaces(const Scene& scene, const Vec3& middle, double scale) {
  std::vector<PlacedSurface> placed;
  for (Surface& surface : list_surfaces(scene)) {
    const auto* mesh = std::get_if<Mesh>(&surface.shape->geometry);
    const bool is_first = placed.empty() || placed.back().shape != surface.shape;
    const bool is_solid = is_first
                              ? mesh != nullptr && !surface.shape->is_lamp() &&
                                    mesh->size() <= max_faces_of_solid && is_convex_solid(*mesh)
                              : placed.back().of_solid;
    const bool is_large = mesh != nullptr && !is_solid && mesh->size() > max_faces_without_tree;
    if (auto* polygon = std::get_if<Polygon>(&surface.geometry)) {
      for (Vec3& corner : polygon->corners) corner = (corner - middle) * scale;
      surface.flat_normal = polygon->normal();
    } else {
      auto& sphere = std::get<Sphere>(surface.geometry);
      sphere = {(sphere.center - middle) * scale, sphere.radius * scale};
    }
    placed.push_back({std::move(surface), is_solid, is_large});
  }
  return placed;
}

// How far the scene reaches behind the polygon, as a negative number, and before it.
std::pair<double, double> reach(const PlacedSurface& wall,
                                const std::vector<PlacedSurface>& surfaces) {
  const Vec3& normal = wall.flat_normal;
  const auto& polygon = std::get<Polygon>(wall.geometry);
  double lowest = 0.0;
  double highest = 0.0;
  const auto include = [&](const Vec3& point, double radius) {
    const double distance = normal.dot(point - polygon.corners[0]);
    lowest = std::min(lowest, distance - radius);
    highest = std::max(highest, distance + radius);
  };
  for (const PlacedSurface& surface : surfaces) {
    if (const auto* sphere = std::get_if<Sphere>(&surface.geometry)) {
      include(sphere->center, sphere->radius);
    } else {
      for (const Vec3& c : std::get<Polygon>(surface.geometry).corners) include(c, 0.0);
    }
  }
  return {lowest, highest};
}

// Whether no part of the scene lies on one of the polygon's sides.
bool bounds_the_scene(const PlacedSurface& wall, const std::vector<PlacedSurface>& surfaces) {
  const auto [lowest, highest] = reach(wall, surfaces);
  return lowest >= -Polygon::rounding || highest <= Polygon::rounding;
}

// The planes behind which the camera is and through which it looks (Camera::sees_through_backs).
template <typename T>
std::vector<Plane<T>> list_backs(const Vec3& eye, const std::vector<PlacedSurface>& surfaces) {
  constexpr double size = 1.0 / 50.0;
  std::vector<Plane<T>> backs;
  for (const PlacedSurface& surface : surfaces) {
    const auto* polygon = std::get_if<Polygon>(&surface.geometry);
    const bool is_wall = polygon != nullptr && !surface.of_solid && !surface.of_tree;
    if (!is_wall || surface.shape->bsdf.two_sided) continue;
    const Vec3& corner = polygon->corners[0];
    if (surface.flat_normal.dot(eye - corner) >= 0.0) continue;
    if (reach(surface, surfaces).first < -size) continue;
    backs.push_back(pack_plane<T>(surface.flat_normal, corner));
  }
  return backs;
}

// For each surface, the first one that lies in its plane, be it itself. Planes that are the same
// have the same normals but for rounding, whose x tells quickly that most are not.
std::vector<int> first_coplanar(const std::vector<PlacedSurface>& surfaces) {
  std::vector<std::pair<double, size_t>> by_normal;
  for (size_t i = 0; i < surfaces.size(); ++i) {
    by_normal.emplace_back(std::abs(surfaces[i].flat_normal.x), i);
  }
  std::ranges::sort(by_normal);
  std::vector<int> first;
  for (size_t i = 0; i < surfaces.size(); ++i) {
    first.push_back(static_cast<int>(i));
    const auto* polygon = std::get_if<Polygon>(&surfaces[i].geometry);
    if (polygon == nullptr) continue;
    const auto& c = polygon->corners;
    const double size = std::min((c[1] - c[0]).length(), (c[2] - c[1]).length());
    const double x = std::abs(surfaces[i].flat_normal.x);
    const double rounding = std::max(1e-4, 4.0 * Polygon::rounding / size);
    for (auto near = std::ranges::lower_bound(by_normal, std::pair(x - rounding, size_t{0}));
         near != by_normal.end() && near->first <= x + rounding; ++near) {
      const PlacedSurface& other = surfaces[near->second];
      const auto* flat = std::get_if<Polygon>(&other.geometry);
      if (flat == nullptr || static_cast<int>(near->second) >= first[i]) continue;
      const bool is_coplanar = std::ranges::all_of(c, [&](const Vec3& corner) {
        return std::abs(other.flat_normal.dot(corner - flat->corners[0])) <= Polygon::rounding;
      });
      if (is_coplanar) first[i] = static_cast<int>(near->second);
    }
  }
  return first;
}

// The first face of the same solid that lies in the face's plane, as one of two triangles of a
// quad: it stands for both.
int first_of_side(const std::vector<PlacedSurface>& surfaces, const std::vector<int>& planes,
                  int face) {
  int first = face;
  const auto at = [&](int i) -> const PlacedSurface& { return surfaces[size_t(i)]; };
  for (int i = face; i >= 0 && at(i).of_solid && at(i).shape == at(face).shape; --i) {
    if (planes[size_t(i)] == planes[size_t(face)]) first = i;
  }
  return first;
}

template <typename T>
PackedParallelogram<T> pack_parallelogram(const Polygon& polygon, double growth, T id) {
  const Vec3 normal = polygon.normal();
  const auto& c = polygon.corners;
  const Vec3 middle = (c[0] + c[2]) * 0.5;
  const Vec3 sides[2] = {c[1] - c[0], c[3] - c[0]};
  PackedParallelogram<T> packed;
  packed.plane = pack_plane<T>(normal, c[0]);
  for (int i = 0; i < 2; ++i) {
    const Vec3 across = sides[1 - i].cross(normal).normalized();
    const double half_width = std::abs(across.dot(sides[i])) / 2.0 + growth;
    packed.slabs[i] = pack_plane<T>(across / half_width, middle);
  }
  packed.id = id;
  return packed;
}

template <typename T>
PackedPolygon<T> pack_polygon(const Polygon& polygon, double growth, T id) {
  const Vec3 normal = polygon.normal();
  const auto& c = polygon.corners;
  PackedPolygon<T> packed;
  packed.plane = pack_plane<T>(normal, c[0]);
  for (size_t i = 0; i < 4; ++i) {
    const Vec3& from = c[std::min(i, c.size() - 1)];
    const Vec3& to = c[(std::min(i, c.size() - 1) + 1) % c.size()];
    const Vec3 outward = (to - from).cross(normal).normalized();
    packed.edges[i] = pack_plane<T>(outward, from, growth);
  }
  packed.id = id;
  return packed;
}

template <typename T>
PackedSphere<T> pack_sphere(const Sphere& sphere, T id) {
  return {pack<T>(sphere.center), static_cast<T>(sphere.radius), id};
}

template <typename T>
void add_surface(const PlacedSurface& surface, bool starts_solid, double growth, T id, T plane,
                 PackedShapes<T>& shapes) {
  if (const auto* sphere = std::get_if<Sphere>(&surface.geometry)) {
    shapes.spheres.push_back(pack_sphere<T>(*sphere, id));
    return;
  }
  const auto& polygon = std::get<Polygon>(surface.geometry);
  if (surface.of_solid) {
    if (starts_solid) shapes.solids.emplace_back();
    shapes.solids.back().faces.push_back(
        {pack_plane<T>(polygon.normal(), polygon.corners[0], growth), id});
    shapes.solids.back().faces.back().plane.id = plane;
  } else if (surface.of_tree) {
    shapes.tree.faces.push_back(pack_polygon<T>(polygon, growth, id));
    shapes.tree.faces.back().plane.id = plane;
  } else if (polygon.is_parallelogram()) {
    shapes.parallelograms.push_back(pack_parallelogram<T>(polygon, growth, id));
    shapes.parallelograms.back().plane.id = plane;
  } else {
    shapes.polygons.push_back(pack_polygon<T>(polygon, growth, id));
    shapes.polygons.back().plane.id = plane;
  }
}

// The box of all points that the grown polygon's edges leave inside: its corners move outwards by
// more where they are sharp. Twice the growth more covers what rounding adds to a hit point and to
// the test of the box.
Imath::Box3d grown_bounds(const PlacedSurface& surface, double growth) {
  const auto& c = std::get<Polygon>(surface.geometry).corners;
  Imath::Box3d box;
  for (size_t i = 0; i < c.size(); ++i) {
    const Vec3& corner = c[(i + 1) % c.size()];
    const Vec3 before = (corner - c[i]).cross(surface.flat_normal).normalized();
    const Vec3 after = (c[(i + 2) % c.size()] - corner).cross(surface.flat_normal).normalized();
    box.extendBy(corner + (before + after) * (growth / std::max(1.0 + before.dot(after), 1e-9)));
  }
  return {box.min - Vec3(2.0 * growth), box.max + Vec3(2.0 * growth)};
}

// Makes the tree over its faces, which it puts into another order.
template <typename T>
class TreeBuilder {
 public:
  TreeBuilder(const std::vector<PlacedSurface>& surfaces, double growth, PackedTree<T>& tree)
      : tree_(tree), left_(tree.faces) {
    for (const auto& face : left_) {
      boxes_.push_back(grown_bounds(surfaces[static_cast<size_t>(face.id)], growth));
      order_.push_back(order_.size());
    }
    tree.faces.clear();
    if (!left_.empty()) add_node(order_.begin(), order_.end());
  }

 private:
  using Place = std::vector<size_t>::iterator;

  // Halves the faces where their middles are farthest apart, down to a few, which are tested faster
  // than further boxes.
  void add_node(Place begin, Place end) {
    constexpr auto max_in_leaf = 4;
    Imath::Box3d box, middles;
    for (Place face = begin; face != end; ++face) {
      box.extendBy(boxes_[*face]);
      middles.extendBy(boxes_[*face].center());
    }
    const auto axis = static_cast<int>(middles.majorAxis());
    const size_t node = tree_.nodes.size();
    tree_.nodes.push_back({pack<T>(box.min), pack<T>(box.max), 0, 0, axis});
    if (end - begin <= max_in_leaf) {
      tree_.nodes[node].first = static_cast<int>(tree_.faces.size());
      tree_.nodes[node].count = static_cast<int>(end - begin);
      for (Place face = begin; face != end; ++face) tree_.faces.push_back(left_[*face]);
      return;
    }
    const Place half = begin + (end - begin) / 2;
    std::nth_element(begin, half, end, [&](size_t a, size_t b) {
      const double x = boxes_[a].center()[axis], y = boxes_[b].center()[axis];
      return x != y ? x < y : a < b;  // the same tree by every standard library
    });
    add_node(begin, half);
    tree_.nodes[node].first = static_cast<int>(tree_.nodes.size());
    add_node(half, end);
  }

  PackedTree<T>& tree_;
  std::vector<PackedPolygon<T>> left_;
  std::vector<Imath::Box3d> boxes_;
  std::vector<size_t> order_;
};

double sum(const Rgb& radiance) { return radiance.dot(Rgb(1.0)); }

// A sky's irradiance counts as a lamp's strength at the distance 1.
template <typename T>
PackedLamp<T> pack_sky(const Rgb& sky, double brightest) {
  PackedLamp<T> lamp{};
  lamp.kind = PackedLamp<T>::Kind::sky;
  lamp.id = -1;
  lamp.plane = -2;  // no surface's
  lamp.radiance = pack<T>(sky);
  lamp.strength = static_cast<T>(sum(sky) / brightest * std::numbers::pi);
  return lamp;
}

template <typename T>
PackedLamp<T> pack_point(const PointLamp& point, const Vec3& middle, double scale,
                         double brightest) {
  PackedLamp<T> lamp{};
  lamp.kind = PackedLamp<T>::Kind::point;
  lamp.id = lamp.plane = -2;
  const Rgb intensity = point.intensity * (scale * scale);
  lamp.radiance = pack<T>(intensity);
  lamp.origin = lamp.middle = pack<T>((point.position - middle) * scale);
  lamp.strength = static_cast<T>(sum(intensity) / brightest);
  return lamp;
}

template <typename T>
PackedLamp<T> pack_lamp(const PlacedSurface& surface, T id, T plane, double brightest) {
  PackedLamp<T> lamp{};
  lamp.id = id;
  lamp.plane = plane;
  lamp.radiance = pack<T>(surface.shape->radiance);
  // Sets what chooses the lamp, but for its kind.
  const auto set_strength = [&](double seen_area, const Vec3& center, double reach) {
    lamp.strength = static_cast<T>(sum(surface.shape->radiance) / brightest * seen_area);
    lamp.middle = pack<T>(center);
    lamp.squared_reach = static_cast<T>(reach * reach);
  };
  if (const auto* sphere = std::get_if<Sphere>(&surface.geometry)) {
    lamp.kind = PackedLamp<T>::Kind::sphere;
    lamp.origin = pack<T>(sphere->center);
    lamp.radius = static_cast<T>(sphere->radius);
    const double disc = std::numbers::pi * sphere->radius * sphere->radius;
    lamp.area = static_cast<T>(4.0 * disc);
    set_strength(disc, sphere->center, sphere->radius);
    return lamp;
  }
  const auto& polygon = std::get<Polygon>(surface.geometry);
  const Vec3 x = polygon.corners[1] - polygon.corners[0];
  const Vec3 y = polygon.corners.back() - polygon.corners[0];
  lamp.origin = pack<T>(polygon.corners[0]);
  lamp.normal = pack<T>(surface.flat_normal);
  if (polygon.corners.size() == 3) {
    lamp.kind = PackedLamp<T>::Kind::triangle;
    lamp.x = pack<T>(x);
    lamp.y = pack<T>(y);
    lamp.area = static_cast<T>(x.cross(y).length() / 2.0);
    set_strength(lamp.area, polygon.corners[0] + (x + y) / 3.0, std::max(x.length(), y.length()));
    return lamp;
  }
  lamp.kind = PackedLamp<T>::Kind::rectangle;
  lamp.x = pack<T>(x.normalized());
  lamp.y = pack<T>(y.normalized());
  lamp.x_length = static_cast<T>(x.length());
  lamp.y_length = static_cast<T>(y.length());
  lamp.area = static_cast<T>(x.length() * y.length());
  set_strength(lamp.area, polygon.corners[0] + (x + y) / 2.0, (x + y).length() / 2.0);
  return lamp;
}

// Whether part of the other surface is where a lamp or a mirror shines: before a flat one.
bool shines_at(const PlacedSurface& from, const PlacedSurface& to, bool two_sided) {
  if (std::holds_alternative<Sphere>(from.geometry)) return true;
  const auto [lowest, highest] = reach(from, {to});
  return highest > Polygon::rounding || (two_sided && lowest < -Polygon::rounding);
}

// More would cost more than they are worth: chance finds such light.
constexpr size_t max_mirrored_lamps = 128;

// The mirrors that a lamp shines at and that may throw its light elsewhere, but for those of large
// meshes.
template <typename T>
std::vector<PackedMirror<T>> list_mirrors(const PlacedSurface& of_lamp, double growth,
                                          const std::vector<PlacedSurface>& surfaces,
                                          const std::vector<int>& planes) {
  std::vector<PackedMirror<T>> mirrors;
  for (size_t i = 0; i < surfaces.size(); ++i) {
    const PlacedSurface& surface = surfaces[i];
    const Bsdf& bsdf = surface.shape->bsdf;
    if (!bsdf.is_mirror() || surface.of_tree) continue;
    if (!shines_at(of_lamp, surface, false) || !shines_at(surface, of_lamp, bsdf.two_sided))
      continue;
    PackedMirror<T> mirror{};
    mirror.two_sided = bsdf.two_sided;
    mirror.reflectance = pack<T>(bsdf.reflectance);
    mirror.eta = pack<T>(bsdf.eta);
    mirror.k = pack<T>(bsdf.k);
    if (const auto* sphere = std::get_if<Sphere>(&surface.geometry)) {
      mirror.is_sphere = true;
      mirror.sphere = pack_sphere<T>(*sphere, static_cast<T>(i));
    } else {
      const T id = static_cast<T>(first_of_side(surfaces, planes, static_cast<int>(i)));
      mirror.face = pack_polygon<T>(std::get<Polygon>(surface.geometry), growth, id);
      mirror.face.plane.id = static_cast<T>(planes[i]);
    }
    mirrors.push_back(mirror);
  }
  return mirrors;
}

// How far the polygon's middle is from its nearest edge.
double inner_radius(const Polygon& polygon, const Vec3& middle) {
  double radius = std::numeric_limits<double>::max();
  for (size_t i = 0; i < polygon.corners.size(); ++i) {
    const Vec3& from = polygon.corners[i];
    const Vec3 edge = (polygon.corners[(i + 1) % polygon.corners.size()] - from).normalized();
    radius = std::min(radius, edge.cross(middle - from).length());
  }
  return radius;
}

template <typename T>
void set_row(SurfaceTable<T>& table, int id, int plane, const PlacedSurface& surface,
             double growth) {
  using Table = SurfaceTable<T>;
  const auto set = [&](int column, double value) {
    table.column(column)[id] = static_cast<T>(value);
  };
  const auto set_vector = [&](int column, const Vec3& v) {
    for (int i = 0; i < 3; ++i) set(column + i, v[i]);
  };
  const Bsdf& bsdf = surface.shape->bsdf;
  set_vector(Table::reflectance, bsdf.reflectance);
  set_vector(Table::transmittance, bsdf.transmittance);
  set_vector(Table::eta, bsdf.eta);
  set_vector(Table::k, bsdf.k);
  set(Table::mirror, bsdf.is_mirror());
  set(Table::alpha, bsdf.alpha);
  set(Table::ior, bsdf.kind == Bsdf::Kind::dielectric ? bsdf.ior : 0.0);
  set(Table::two_sided, bsdf.two_sided);
  set(Table::plane, plane);
  if (const auto* sphere = std::get_if<Sphere>(&surface.geometry)) {
    set_vector(Table::point, sphere->center);
    set(Table::scale, sphere->radius);
    set(Table::sphere, 1.0);
    return;
  }
  const auto& polygon = std::get<Polygon>(surface.geometry);
  const auto& corners = polygon.corners;
  const Vec3 middle = std::accumulate(corners.begin(), corners.end(), Vec3(0.0)) /
                      static_cast<double>(corners.size());
  set_vector(Table::normal, polygon.normal());
  set_vector(Table::point, middle);
  set(Table::scale, 1.0 - std::min(0.5, 4.0 * growth / inner_radius(polygon, middle)));
}

template <typename T>
PackedFilter<T> pack_filter(const Filter& filter) {
  PackedFilter<T> packed;
  packed.crosses_border = filter.crosses_border;
  if (filter.kind == Filter::Kind::box) return packed;
  constexpr int shares = 1024;
  constexpr int steps = 64 * shares;
  std::vector<double> sums{0.0};  // of the weights, by the midpoint rule
  const double step = 2.0 * filter.radius() / steps;
  const auto position = [&](double i) { return i * step - filter.radius(); };
  for (int i = 0; i < steps; ++i) {
    sums.push_back(sums.back() + filter.weight(position(i + 0.5)));
  }
  for (int share = 0, i = 0; share <= shares; ++share) {
    const double sum = sums.back() * share / shares;
    while (i + 1 < steps && sums[size_t(i) + 1] < sum) ++i;
    const double weight = sums[size_t(i) + 1] - sums[size_t(i)];
    packed.offsets.push_back(static_cast<T>(position(i + (sum - sums[size_t(i)]) / weight)));
  }
  return packed;
}

template <typename T>
PackedCamera<T> pack_camera(const Camera& camera, const Vec3& middle, double scale) {
  const double half_width = camera.half_width();
  const double pixel = 2.0 * half_width / camera.width;
  const double half_height = pixel * camera.height / 2.0;
  return {.origin = pack<T>((camera.origin - middle) * scale),
          .corner = pack<T>(camera.forward - camera.right * half_width + camera.up * half_height),
          .x_pixel = pack<T>(camera.right * pixel),
          .y_pixel = pack<T>(camera.up * -pixel),
          .filter = pack_filter<T>(camera.filter),
          .width = camera.width,
          .height = camera.height};
}

}  // namespace

template <typename T>
T PackedFilter<T>::share_below(T offset) const {
  const auto above = std::ranges::upper_bound(offsets, offset);
  if (above == offsets.begin()) return 0;
  if (above == offsets.end()) return 1;
  const T part = (offset - above[-1]) / (above[0] - above[-1]);
  return (static_cast<T>(above - offsets.begin() - 1) + part) / static_cast<T>(offsets.size() - 1);
}

double float_growth(const Scene& scene) {
  const Imath::Box3d box = scene.bounds();
  const double eye = (scene.camera.origin - box.center()).length();
  const double size = std::max((box.max - box.center()).length(), eye);
  return rounding_errors * size * std::numeric_limits<float>::epsilon() / 2.0;
}

template struct PackedFilter<float>;
template struct PackedFilter<double>;

template <typename T>
PackedScene<T>::PackedScene(const Scene& scene) {
  const Imath::Box3d box = scene.bounds();
  const Vec3 middle = box.isEmpty() ? Vec3(0.0) : box.center();
  const double scale = 1.0 / scene.radius();
  camera = pack_camera<T>(scene.camera, middle, scale);

  const Vec3 eye = (scene.camera.origin - middle) * scale;
  const double growth =
      rounding_errors * std::max(1.0, eye.length()) * std::numeric_limits<T>::epsilon() / 2.0;

  const std::vector<PlacedSurface> list = place_surfaces(scene, middle, scale);
  if (scene.camera.sees_through_backs) camera.backs = list_backs<T>(eye, list);
  surfaces.count = static_cast<int>(list.size());
  surfaces.stride = static_cast<int>((list.size() / 64 + 1) * 64);
  surfaces.values.assign(size_t{SurfaceTable<T>::columns} * size_t(surfaces.stride), T{0});
  const std::vector<int> planes = first_coplanar(list);
  const double brightest = scene.brightness();
  has_sky = scene.has_sky();
  const bool is_open = has_sky || !scene.points.empty();
  size_t mirrored_lamps = 0;
  for (int i = 0; i < static_cast<int>(list.size()); ++i) {
    const PlacedSurface& surface = list[size_t(i)];
    const T id = static_cast<T>(i);
    const int first = planes[size_t(i)];
    const T plane = static_cast<T>(first);
    const bool starts_solid = i == 0 || list[size_t(i) - 1].shape != surface.shape;
    const bool is_counted = first_of_side(list, planes, i) != i;  // with another face of the solid
    if (!is_counted) add_surface<T>(surface, starts_solid, growth, id, plane, shapes);
    const auto* polygon = std::get_if<Polygon>(&surface.geometry);
    const bool is_wall = polygon != nullptr && !surface.of_solid && !surface.of_tree;
    if (!is_counted && (!is_wall || is_open || !bounds_the_scene(surface, list))) {
      add_surface<T>(surface, starts_solid, growth, id, plane, occluders);
    }
    if (surface.shape->is_lamp()) {
      lamps.push_back(pack_lamp<T>(surface, id, plane, brightest));
      lamps.back().mirrors = list_mirrors<T>(surface, growth, list, planes);
      mirrored_lamps += lamps.back().mirrors.size();
    }
    set_row(surfaces, i, first, surface, growth);
    has_coplanar |= first != i;
    const Bsdf& bsdf = surface.shape->bsdf;
    has_mirrors |= bsdf.is_mirror();
    has_all_materials |= bsdf.is_metal() || bsdf.alpha > 0.0 || bsdf.kind == Bsdf::Kind::dielectric;
    has_two_sided |= bsdf.two_sided;
  }
  if (has_sky) lamps.push_back(pack_sky<T>(scene.sky, brightest));
  for (const PointLamp& point : scene.points) {
    lamps.push_back(pack_point<T>(point, middle, scale, brightest));
  }
  has_mirrored_lamps = mirrored_lamps > 0 && mirrored_lamps <= max_mirrored_lamps;
  if (!has_mirrored_lamps) {
    for (PackedLamp<T>& lamp : lamps) lamp.mirrors.clear();
  }
  const TreeBuilder<T> tree(list, growth, shapes.tree);
  const TreeBuilder<T> tree_of_occluders(list, growth, occluders.tree);
}

template struct PackedScene<float>;
template struct PackedScene<double>;

}  // namespace plumb
