// SPDX-License-Identifier: Apache-2.0

#include "scene/scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace plumb {

Vec3 Polygon::normal() const {
  Vec3 sum(0.0);
  for (size_t i = 0; i < corners.size(); ++i) {
    sum += (corners[i] - corners[0]).cross(corners[(i + 1) % corners.size()] - corners[0]);
  }
  return sum.normalized();
}

bool Polygon::is_parallelogram() const {
  if (corners.size() != 4) return false;
  const Vec3 gap = (corners[0] - corners[1]) + (corners[2] - corners[3]);
  const double size = (corners[2] - corners[0]).length() + (corners[3] - corners[1]).length();
  return gap.length() <= rounding * size;
}

bool Polygon::is_rectangle() const {
  if (!is_parallelogram()) return false;
  const Vec3 x = (corners[1] - corners[0]).normalized();
  const Vec3 y = (corners[3] - corners[0]).normalized();
  return std::abs(x.dot(y)) <= rounding;
}

std::vector<Vec3> part_beyond(const std::vector<Vec3>& corners, const Vec3& normal, double offset) {
  std::vector<Vec3> part;
  for (size_t i = 0; i < corners.size(); ++i) {
    const Vec3& a = corners[i];
    const Vec3& b = corners[(i + 1) % corners.size()];
    const double at_a = normal.dot(a) - offset;
    const double at_b = normal.dot(b) - offset;
    if (at_a > 0.0) part.push_back(a);
    if ((at_a > 0.0) != (at_b > 0.0)) part.push_back(a + (b - a) * (at_a / (at_a - at_b)));
  }
  return part;
}

double Filter::weight(double distance) const {
  const double x = distance / size;
  switch (kind) {
    case Kind::box: return 1.0;
    case Kind::tent: return std::max(0.0, 1.0 - std::abs(x));
    case Kind::gaussian: return std::max(0.0, std::exp(-x * x / 2.0) - std::exp(-8.0));
    // Harris, "On the use of windows for harmonic analysis with the discrete Fourier transform",
    // Proceedings of the IEEE 66(1), 1978, with the middle at 0.
    case Kind::blackman_harris: {
      const double angle = std::numbers::pi * std::clamp(x, -1.0, 1.0);
      return 0.35875 + 0.48829 * std::cos(angle) + 0.14128 * std::cos(2.0 * angle) +
             0.01168 * std::cos(3.0 * angle);
    }
  }
  return 0.0;
}

Vec3 Camera::direction(double x, double y) const {
  const double pixel = 2.0 * half_width() / width;
  return forward + right * (x * pixel - half_width()) + up * (half_height() - y * pixel);
}

double Camera::half_width() const {
  const double tangent = std::tan(fov_degrees * std::numbers::pi / 360.0);
  const double w = width;
  const double h = height;
  switch (fov_axis) {
    case FovAxis::x: return tangent;
    case FovAxis::y: return tangent * w / h;
    case FovAxis::diagonal: return tangent * w / std::hypot(w, h);
    case FovAxis::smaller: return w <= h ? tangent : tangent * w / h;
    case FovAxis::larger: return w >= h ? tangent : tangent * w / h;
  }
  return tangent;
}

Imath::Box3d bounds(const Mesh& mesh) {
  Imath::Box3d box;
  for (const Polygon& face : mesh) {
    for (const Vec3& corner : face.corners) box.extendBy(corner);
  }
  return box;
}

Imath::Box3d Shape::bounds() const {
  const auto* sphere = std::get_if<Sphere>(&geometry);
  if (sphere == nullptr) return plumb::bounds(std::get<Mesh>(geometry));
  return {sphere->center - Vec3(sphere->radius), sphere->center + Vec3(sphere->radius)};
}

Imath::Box3d Scene::bounds() const {
  Imath::Box3d box;
  for (const Shape& shape : shapes) box.extendBy(shape.bounds());
  return box;
}

double Scene::radius() const {
  const Imath::Box3d box = bounds();
  const double radius = box.isEmpty() ? 0.0 : (box.max - box.center()).length();
  return radius > 0.0 ? radius : 1.0;
}

double Scene::brightness() const {
  const auto sum = [](const Rgb& rgb) { return rgb.dot(Rgb(1.0)); };
  const double scale = 1.0 / radius();
  double brightness = sum(sky);
  for (const Shape& shape : shapes) brightness = std::max(brightness, sum(shape.radiance));
  for (const PointLamp& p : points) {
    brightness = std::max(brightness, sum(p.intensity) * scale * scale);
  }
  return brightness;
}

bool Scene::has_lamps() const {
  return has_sky() || !points.empty() || std::ranges::any_of(shapes, &Shape::is_lamp);
}

}  // namespace plumb
