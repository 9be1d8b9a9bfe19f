#include "renderer/packed_scene.h"

#include <Imath/ImathBox.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <stdexcept>

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

Imath::Box3d bounds(const std::vector<Shape>& shapes) {
  Imath::Box3d box;
  for (const Shape& shape : shapes) {
    if (const auto* sphere = std::get_if<Sphere>(&shape.geometry)) {
      box.extendBy(sphere->center - Vec3(sphere->radius));
      box.extendBy(sphere->center + Vec3(sphere->radius));
    } else {
      for (const Polygon& face : std::get<Mesh>(shape.geometry)) {
        for (const Vec3& corner : face.corners) box.extendBy(corner);
      }
    }
  }
  return box;
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

// One flat face or one sphere of a shape, in the normalised space.
struct Surface {
  const Shape* shape;
  std::variant<Polygon, Sphere> geometry;
  bool of_solid = false;
};

std::vector<Surface> list_surfaces(const Scene& scene, const Vec3& middle, double scale) {
  std::vector<Surface> surfaces;
  for (const Shape& shape : scene.shapes) {
    if (const auto* sphere = std::get_if<Sphere>(&shape.geometry)) {
      surfaces.push_back(
          {&shape, Sphere{(sphere->center - middle) * scale, sphere->radius * scale}});
      continue;
    }
    const auto& mesh = std::get<Mesh>(shape.geometry);
    const bool is_solid = !shape.is_lamp() && is_convex_solid(mesh);
    for (Polygon face : mesh) {
      for (Vec3& corner : face.corners) corner = (corner - middle) * scale;
      if (shape.is_lamp() && !face.is_rectangle()) {
        throw std::invalid_argument("a lamp must be a sphere or made of rectangles");
      }
      surfaces.push_back({&shape, std::move(face), is_solid});
    }
  }
  return surfaces;
}

// Whether no part of the scene lies on one of the polygon's sides.
bool bounds_the_scene(const Polygon& polygon, const std::vector<Surface>& surfaces) {
  const Vec3 normal = polygon.normal();
  double lowest = 0.0;
  double highest = 0.0;
  const auto include = [&](const Vec3& point, double radius) {
    const double height = normal.dot(point - polygon.corners[0]);
    lowest = std::min(lowest, height - radius);
    highest = std::max(highest, height + radius);
  };
  for (const Surface& surface : surfaces) {
    if (const auto* sphere = std::get_if<Sphere>(&surface.geometry)) {
      include(sphere->center, sphere->radius);
    } else {
      for (const Vec3& c : std::get<Polygon>(surface.geometry).corners) include(c, 0.0);
    }
  }
  return lowest >= -Polygon::rounding || highest <= Polygon::rounding;
}

// The first surface in the plane of surface `i`, or itself.
int first_coplanar(const std::vector<Surface>& surfaces, int i) {
  const auto* polygon = std::get_if<Polygon>(&surfaces[size_t(i)].geometry);
  if (polygon == nullptr) return i;
  const auto lies_in_plane = [&](const Surface& surface) {
    const auto* other = std::get_if<Polygon>(&surface.geometry);
    return other != nullptr && std::ranges::all_of(polygon->corners, [&](const Vec3& corner) {
             return std::abs(other->normal().dot(corner - other->corners[0])) <= Polygon::rounding;
           });
  };
  return static_cast<int>(std::ranges::find_if(surfaces, lies_in_plane) - surfaces.begin());
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
void add_surface(const Surface& surface, bool starts_solid, double growth, T id, T plane,
                 PackedShapes<T>& shapes) {
  if (const auto* sphere = std::get_if<Sphere>(&surface.geometry)) {
    shapes.spheres.push_back({pack<T>(sphere->center), static_cast<T>(sphere->radius), id});
    return;
  }
  const auto& polygon = std::get<Polygon>(surface.geometry);
  if (surface.of_solid) {
    if (starts_solid) shapes.solids.emplace_back();
    shapes.solids.back().faces.push_back(
        {pack_plane<T>(polygon.normal(), polygon.corners[0], growth), id});
    shapes.solids.back().faces.back().plane.id = plane;
  } else if (polygon.is_parallelogram()) {
    shapes.parallelograms.push_back(pack_parallelogram<T>(polygon, growth, id));
    shapes.parallelograms.back().plane.id = plane;
  } else {
    shapes.polygons.push_back(pack_polygon<T>(polygon, growth, id));
    shapes.polygons.back().plane.id = plane;
  }
}

template <typename T>
PackedLamp<T> pack_lamp(const Surface& surface, T id) {
  PackedLamp<T> lamp{};
  lamp.id = id;
  lamp.radiance = pack<T>(surface.shape->radiance);
  if (const auto* sphere = std::get_if<Sphere>(&surface.geometry)) {
    lamp.kind = PackedLamp<T>::Kind::sphere;
    lamp.corner = pack<T>(sphere->center);
    lamp.radius = static_cast<T>(sphere->radius);
    lamp.area = static_cast<T>(4.0 * std::numbers::pi * sphere->radius * sphere->radius);
    return lamp;
  }
  const auto& polygon = std::get<Polygon>(surface.geometry);
  const Vec3 x = polygon.corners[1] - polygon.corners[0];
  const Vec3 y = polygon.corners.back() - polygon.corners[0];
  lamp.kind = PackedLamp<T>::Kind::rectangle;
  lamp.corner = pack<T>(polygon.corners[0]);
  lamp.x = pack<T>(x.normalized());
  lamp.y = pack<T>(y.normalized());
  lamp.normal = pack<T>(polygon.normal());
  lamp.x_length = static_cast<T>(x.length());
  lamp.y_length = static_cast<T>(y.length());
  lamp.area = static_cast<T>(x.length() * y.length());
  return lamp;
}

// A lamp is chosen in proportion to its power.
template <typename T>
void choose_by_power(std::vector<PackedLamp<T>>& lamps) {
  const auto power = [](const PackedLamp<T>& lamp) {
    return double{lamp.area} * (double{lamp.radiance.x} + lamp.radiance.y + lamp.radiance.z);
  };
  const double total = std::transform_reduce(lamps.begin(), lamps.end(), 0.0, std::plus{}, power);
  double begin = 0.0;
  for (PackedLamp<T>& lamp : lamps) {
    lamp.choice_begin = static_cast<T>(begin);
    lamp.probability = static_cast<T>(power(lamp) / total);
    begin += power(lamp) / total;
  }
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
void set_row(SurfaceTable<T>& table, int id, int plane, const Surface& surface, double growth) {
  using Table = SurfaceTable<T>;
  const auto set = [&](int column, double value) {
    table.column(column)[id] = static_cast<T>(value);
  };
  const auto set_vector = [&](int column, const Vec3& v) {
    for (int i = 0; i < 3; ++i) set(column + i, v[i]);
  };
  const Bsdf& bsdf = surface.shape->bsdf;
  set_vector(Table::reflectance, bsdf.reflectance);
  set(Table::mirror, bsdf.kind == Bsdf::Kind::conductor);
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
PackedCamera<T> pack_camera(const Camera& camera, const Vec3& middle, double scale) {
  const double half_width = camera.half_width();
  const double pixel = 2.0 * half_width / camera.width;
  const double half_height = pixel * camera.height / 2.0;
  return {.origin = pack<T>((camera.origin - middle) * scale),
          .corner = pack<T>(camera.forward - camera.right * half_width + camera.up * half_height),
          .x_pixel = pack<T>(camera.right * pixel),
          .y_pixel = pack<T>(camera.up * -pixel),
          .width = camera.width,
          .height = camera.height};
}

}  // namespace

template <typename T>
PackedScene<T>::PackedScene(const Scene& scene) {
  const Imath::Box3d box = bounds(scene.shapes);
  const Vec3 middle = box.isEmpty() ? Vec3(0.0) : box.center();
  const double radius = box.isEmpty() ? 0.0 : (box.max - middle).length();
  const double scale = radius > 0.0 ? 1.0 / radius : 1.0;
  camera = pack_camera<T>(scene.camera, middle, scale);

  const double reach = std::max(1.0, ((scene.camera.origin - middle) * scale).length());
  const double growth = rounding_errors * reach * std::numeric_limits<T>::epsilon() / 2.0;

  const std::vector<Surface> list = list_surfaces(scene, middle, scale);
  surfaces.count = static_cast<int>(list.size());
  surfaces.stride = static_cast<int>((list.size() / 64 + 1) * 64);
  surfaces.values.assign(size_t{SurfaceTable<T>::columns} * size_t(surfaces.stride), T{0});
  for (int i = 0; i < static_cast<int>(list.size()); ++i) {
    const Surface& surface = list[size_t(i)];
    const T id = static_cast<T>(i);
    const int first = first_coplanar(list, i);
    const T plane = static_cast<T>(first);
    const bool starts_solid = i == 0 || list[size_t(i) - 1].shape != surface.shape;
    add_surface<T>(surface, starts_solid, growth, id, plane, shapes);
    const auto* polygon = std::get_if<Polygon>(&surface.geometry);
    if (polygon == nullptr || surface.of_solid || !bounds_the_scene(*polygon, list)) {
      add_surface<T>(surface, starts_solid, growth, id, plane, occluders);
    }
    if (surface.shape->is_lamp()) lamps.push_back(pack_lamp<T>(surface, id));
    set_row(surfaces, i, first, surface, growth);
    has_coplanar |= first != i;
    has_mirrors |= surface.shape->bsdf.kind == Bsdf::Kind::conductor;
    has_two_sided |= surface.shape->bsdf.two_sided;
  }
  choose_by_power(lamps);
}

template struct PackedScene<float>;
template struct PackedScene<double>;

}  // namespace plumb
