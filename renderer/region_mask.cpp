#include "renderer/region_mask.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <variant>

namespace plumb {
namespace {

constexpr int steps = 4;  // across a pixel or a lamp
constexpr double miss = std::numeric_limits<double>::infinity();

// Of a ray's length: closer than this to its ends nothing is hit.
constexpr double margin = 1e-7;

struct Ray {
  Vec3 origin;
  Vec3 direction;

  Vec3 at(double distance) const { return origin + direction * distance; }
};

// One flat face or one sphere of a shape.
struct Face {
  const Shape* shape;
  std::variant<Polygon, Sphere> geometry;
  Vec3 flat_normal;

  Vec3 normal(const Vec3& point) const {
    const auto* sphere = std::get_if<Sphere>(&geometry);
    return sphere == nullptr ? flat_normal : (point - sphere->center).normalized();
  }

  // In lengths of the ray's direction.
  double distance(const Ray& ray) const {
    const auto* sphere = std::get_if<Sphere>(&geometry);
    return sphere == nullptr ? distance(ray, std::get<Polygon>(geometry)) : distance(ray, *sphere);
  }

 private:
  double distance(const Ray& ray, const Polygon& polygon) const {
    const std::vector<Vec3>& corners = polygon.corners;
    const double t = (corners[0] - ray.origin).dot(flat_normal) / ray.direction.dot(flat_normal);
    if (!(t > margin)) return miss;
    for (size_t i = 0; i < corners.size(); ++i) {
      const Vec3 edge = corners[(i + 1) % corners.size()] - corners[i];
      if (edge.cross(ray.at(t) - corners[i]).dot(flat_normal) < 0.0) return miss;
    }
    return t;
  }

  static double distance(const Ray& ray, const Sphere& sphere) {
    const Vec3 offset = ray.origin - sphere.center;
    const double a = ray.direction.length2();
    const double b = offset.dot(ray.direction);
    const double discriminant = b * b - a * (offset.length2() - sphere.radius * sphere.radius);
    if (discriminant < 0.0) return miss;
    const double root = std::sqrt(discriminant);
    if (-b - root > margin * a) return (-b - root) / a;
    return -b + root > margin * a ? (-b + root) / a : miss;
  }
};

std::vector<Face> list_faces(const Scene& scene) {
  std::vector<Face> faces;
  for (const Shape& shape : scene.shapes) {
    if (const auto* sphere = std::get_if<Sphere>(&shape.geometry)) {
      faces.push_back({&shape, *sphere, Vec3(0.0)});
      continue;
    }
    for (const Polygon& polygon : std::get<Mesh>(shape.geometry)) {
      faces.push_back({&shape, polygon, polygon.normal()});
    }
  }
  return faces;
}

std::pair<const Face*, double> first_hit(const std::vector<Face>& faces, const Ray& ray) {
  std::pair<const Face*, double> nearest{nullptr, miss};
  for (const Face& face : faces) {
    const double distance = face.distance(ray);
    if (distance < nearest.second) nearest = {&face, distance};
  }
  return nearest;
}

// A point of the lamp: of its rectangle, or of the disc that a sphere shows to `point`.
Vec3 lamp_point(const Face& lamp, const Vec3& point, double u, double v) {
  if (const auto* polygon = std::get_if<Polygon>(&lamp.geometry)) {
    const std::vector<Vec3>& c = polygon->corners;
    return c[0] + (c[1] - c[0]) * u + (c[3] - c[0]) * v;
  }
  const auto& sphere = std::get<Sphere>(lamp.geometry);
  const Vec3 axis = (point - sphere.center).normalized();
  const Vec3 side = axis.cross(std::abs(axis.x) < 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0)).normalized();
  const double angle = u * 2.0 * std::numbers::pi;
  const Vec3 radial = side * std::cos(angle) + axis.cross(side) * std::sin(angle);
  return sphere.center + radial * (v * sphere.radius) + axis * sphere.radius * 1.01;
}

// Which of a shape's sides a face is for one who looks through the camera.
std::string side(const Face& face, const Camera& camera) {
  if (std::holds_alternative<Sphere>(face.geometry)) return "";
  const double x = face.flat_normal.dot(camera.right);
  const double y = face.flat_normal.dot(camera.up);
  const double z = face.flat_normal.dot(camera.forward);
  if (std::abs(z) >= std::max(std::abs(x), std::abs(y))) return z < 0.0 ? "front" : "back";
  if (std::abs(x) >= std::abs(y)) return x < 0.0 ? "left" : "right";
  return y < 0.0 ? "bottom" : "top";
}

// "lit", "penumbra" or "umbra"; nothing for a lamp.
std::string shadow(const std::vector<Face>& faces, const Face& face, const Ray& ray,
                   const Vec3& point) {
  if (face.shape->is_lamp()) return "";
  const Vec3 normal = face.normal(point);
  const double sign = normal.dot(ray.direction) < 0.0 ? 1.0 : -1.0;
  bool is_lit = false;
  bool is_shaded = false;
  for (const Face& lamp : faces) {
    if (!lamp.shape->is_lamp()) continue;
    for (int i = 0; i <= steps; ++i) {
      for (int j = 0; j <= steps; ++j) {
        const Vec3 goal = lamp_point(lamp, point, i / double{steps}, j / double{steps});
        const Ray shadow_ray{point, goal - point};
        const bool is_seen = sign * normal.dot(shadow_ray.direction) > 0.0 &&
                             lamp.normal(goal).dot(shadow_ray.direction) < 0.0 &&
                             first_hit(faces, shadow_ray).second > 1.0 - margin;
        (is_seen ? is_lit : is_shaded) = true;
        if (is_lit && is_shaded) return "penumbra";
      }
    }
  }
  return is_lit ? "lit" : "umbra";
}

class RegionFinder {
 public:
  RegionFinder(const Scene& scene, RegionKind kind)
      : camera_(scene.camera), kind_(kind), faces_(list_faces(scene)) {
    for (const Face& face : faces_) sides_[face.shape].insert(side(face, camera_));
  }

  // The name of the region that the pixel is in, or nothing.
  std::string of_pixel(int x, int y) const {
    std::string name = at(x, y);
    for (int i = 0; i <= steps; ++i) {
      for (int j = 0; j <= steps; ++j) {
        if (at(x + i / double{steps}, y + j / double{steps}) != name) return "";
      }
    }
    return name;
  }

 private:
  std::string at(double x, double y) const {
    const double half = camera_.half_width();
    const double pixel = 2.0 * half / camera_.width;
    const Ray ray{camera_.origin, camera_.forward + camera_.right * (x * pixel - half) +
                                      camera_.up * (0.5 * camera_.height * pixel - y * pixel)};
    const auto [face, distance] = first_hit(faces_, ray);
    if (face == nullptr) return "";
    if (kind_ == RegionKind::shadow) return shadow(faces_, *face, ray, ray.at(distance));
    const bool has_sides = kind_ == RegionKind::side && sides_.at(face->shape).size() > 1;
    if (!has_sides) return face->shape->id;
    return fmt::format("{} {}", face->shape->id, side(*face, camera_));
  }

  const Camera& camera_;
  RegionKind kind_;
  std::vector<Face> faces_;
  std::map<const Shape*, std::set<std::string>> sides_;
};

}  // namespace

RegionMask region_mask(const Scene& scene, RegionKind kind) {
  const int width = scene.camera.width;
  const int height = scene.camera.height;
  const RegionFinder finder(scene, kind);
  std::vector<std::string> names(size_t(width) * size_t(height));
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x)
      names[size_t(y) * size_t(width) + size_t(x)] = finder.of_pixel(x, y);
  });
  RegionMask mask;
  std::map<std::string, int> indices{{"", -1}};
  for (const std::string& name : names) {
    const auto [entry, is_new] = indices.try_emplace(name, int(mask.names.size()));
    if (is_new) mask.names.push_back(name);
    mask.regions.push_back(entry->second);
  }
  return mask;
}

}  // namespace plumb
