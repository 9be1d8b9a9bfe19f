// SPDX-License-Identifier: Apache-2.0

// Small scenes and measurements that several tests share.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "renderer/film.h"
#include "renderer/render.h"
#include "scene/scene.h"

namespace plumb::test {

inline Bsdf diffuse(double albedo, bool two_sided = false) {
  return {.reflectance = Rgb(albedo), .two_sided = two_sided};
}

inline Bsdf mirror(double reflectance) {
  return {.kind = Bsdf::Kind::conductor, .reflectance = Rgb(reflectance)};
}

inline Bsdf metal(const Rgb& eta, const Rgb& k) {
  return {.kind = Bsdf::Kind::conductor, .reflectance = Rgb(1.0), .eta = eta, .k = k};
}

inline Bsdf rough_metal(double alpha, const Rgb& eta, const Rgb& k) {
  Bsdf bsdf = metal(eta, k);
  bsdf.alpha = alpha;
  return bsdf;
}

inline Bsdf glass(double ior) {
  return {.kind = Bsdf::Kind::dielectric, .reflectance = Rgb(1.0), .two_sided = true, .ior = ior};
}

// A parallelogram with the corners c, c + x, c + x + y, c + y; it faces along x cross y.
inline Shape parallelogram(const Vec3& c, const Vec3& x, const Vec3& y, const Bsdf& bsdf,
                           double radiance = 0.0) {
  return {"parallelogram", Mesh{Polygon{{c, c + x, c + x + y, c + y}}}, bsdf, Rgb(radiance)};
}

inline Shape sphere(const Vec3& center, double radius, const Bsdf& bsdf, double radiance = 0.0) {
  return {"sphere", Sphere{center, radius}, bsdf, Rgb(radiance)};
}

// A convex polygon of three or four corners; it faces where they are counter-clockwise.
inline Shape polygon(const std::vector<Vec3>& corners, const Bsdf& bsdf, double radiance = 0.0) {
  return {"polygon", Mesh{Polygon{corners}}, bsdf, Rgb(radiance)};
}

// A ball of 20 * 4^levels triangles that lie on no side beyond the sphere.
inline Shape icosphere(const Vec3& center, double radius, int levels, const Bsdf& bsdf,
                       double radiance = 0.0) {
  const double t = (1.0 + std::sqrt(5.0)) / 2.0;
  const Vec3 v[] = {{-1, t, 0},  {1, t, 0},  {-1, -t, 0}, {1, -t, 0}, {0, -1, t},  {0, 1, t},
                    {0, -1, -t}, {0, 1, -t}, {t, 0, -1},  {t, 0, 1},  {-t, 0, -1}, {-t, 0, 1}};
  constexpr size_t faces[20][3] = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                   {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                   {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                   {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  Mesh mesh;
  for (const auto& f : faces) mesh.push_back({{v[f[0]], v[f[1]], v[f[2]]}});
  for (int level = 0; level < levels; ++level) {
    Mesh finer;
    for (const Polygon& face : mesh) {
      const auto& c = face.corners;
      const Vec3 ab = (c[0] + c[1]).normalized(), bc = (c[1] + c[2]).normalized(),
                 ca = (c[2] + c[0]).normalized();
      for (const Polygon& part : {Polygon{{c[0].normalized(), ab, ca}},
                                  {{c[1].normalized(), bc, ab}},
                                  {{c[2].normalized(), ca, bc}},
                                  {{ab, bc, ca}}}) {
        finer.push_back(part);
      }
    }
    mesh = finer;
  }
  for (Polygon& face : mesh) {
    for (Vec3& corner : face.corners) corner = center + corner.normalized() * radius;
  }
  return {"icosphere", mesh, bsdf, Rgb(radiance)};
}

// The six walls of a box from `low` to `high`, facing inwards.
inline std::vector<Shape> room(const Vec3& low, const Vec3& high, const Bsdf& bsdf,
                               double radiance = 0.0) {
  const Vec3 d = high - low;
  const Vec3 x(d.x, 0, 0);
  const Vec3 y(0, d.y, 0);
  const Vec3 z(0, 0, d.z);
  return {parallelogram(low, x, y, bsdf, radiance),    parallelogram(low, y, z, bsdf, radiance),
          parallelogram(low, z, x, bsdf, radiance),    parallelogram(high, -y, -x, bsdf, radiance),
          parallelogram(high, -z, -y, bsdf, radiance), parallelogram(high, -x, -z, bsdf, radiance)};
}

// The scene, turned by an odd angle around an odd axis.
inline Scene tilted(Scene scene) {
  const Vec3 axis = Vec3(0.36, 0.48, 0.8);
  const double c = std::cos(0.7), s = std::sin(0.7);
  const auto turn = [&](Vec3& v) {
    v = v * c + axis.cross(v) * s + axis * (axis.dot(v) * (1.0 - c));
  };
  for (Vec3* v :
       {&scene.camera.origin, &scene.camera.forward, &scene.camera.right, &scene.camera.up}) {
    turn(*v);
  }
  for (PointLamp& point : scene.points) turn(point.position);
  for (Shape& shape : scene.shapes) {
    if (auto* ball = std::get_if<Sphere>(&shape.geometry)) {
      turn(ball->center);
      continue;
    }
    for (Polygon& face : std::get<Mesh>(shape.geometry)) {
      for (Vec3& corner : face.corners) turn(corner);
    }
  }
  return scene;
}

// A camera at `origin` that looks at `target`.
inline Camera camera(const Vec3& origin, const Vec3& target, double fov_degrees, int size = 16) {
  Camera c;
  c.origin = origin;
  c.forward = (target - origin).normalized();
  const Vec3 aside = std::abs(c.forward.y) < 0.9 ? Vec3(0, 1, 0) : Vec3(1, 0, 0);
  c.right = c.forward.cross(aside).normalized();
  c.up = c.right.cross(c.forward);
  c.fov_degrees = fov_degrees;
  c.width = c.height = size;
  return c;
}

// So narrow that all pixels see one point.
constexpr double pinpoint = 1e-4;

// The mean over all pixels and channels, and its standard error.
struct Measurement {
  double mean = 0.0;
  double standard_error = 0.0;
};

inline Measurement measure(const Film& film) {
  Measurement result;
  const std::vector<float> means = film.mean();
  for (const float value : means) result.mean += double{value};
  // Channels share their paths: their errors add up, pixels' don't.
  double variance = 0.0;
  const std::vector<float> variances = film.variance();
  for (size_t p = 0; p < variances.size(); p += 3) {
    const double error = std::sqrt(double{variances[p]}) + std::sqrt(double{variances[p + 1]}) +
                         std::sqrt(double{variances[p + 2]});
    variance += error * error;
  }
  const auto n = static_cast<double>(means.size());
  return {result.mean / n, std::sqrt(variance) / n};
}

inline Film render_film(const Scene& scene, const Settings& settings, const SampleRange& samples) {
  Film film(scene.camera.width, scene.camera.height);
  render(scene, settings, {.samples = samples}, film);
  return film;
}

// Renders until the standard error is below this fraction of the mean.
inline Measurement measure_until(const Scene& scene, const Settings& settings,
                                 double relative_error) {
  constexpr int64_t most = int64_t{1} << 24;
  Film film(scene.camera.width, scene.camera.height);
  Measurement result;
  for (SampleRange samples{0, 256}; samples.first < most;) {
    render(scene, settings, {.samples = samples}, film);
    result = measure(film);
    const double ratio = result.standard_error / (relative_error * result.mean);
    if (ratio <= 1.0) break;
    const double wanted = 1.1 * ratio * ratio * static_cast<double>(samples.last);
    samples = {samples.last, std::min(2 * samples.last, static_cast<int64_t>(wanted) / 4 * 4 + 4)};
  }
  return result;
}

}  // namespace plumb::test
