// Small scenes and measurements that several tests share.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "renderer/film.h"
#include "renderer/render.h"
#include "renderer/scene.h"

namespace plumb::test {

inline Bsdf diffuse(double albedo, bool two_sided = false) {
  return {Bsdf::Kind::diffuse, Rgb(albedo), two_sided};
}

inline Bsdf mirror(double reflectance) { return {Bsdf::Kind::conductor, Rgb(reflectance), false}; }

// A parallelogram with the corners c, c + x, c + x + y, c + y; it faces along x cross y.
inline Shape parallelogram(const Vec3& c, const Vec3& x, const Vec3& y, const Bsdf& bsdf,
                           double radiance = 0.0) {
  return {"parallelogram", Mesh{Polygon{{c, c + x, c + x + y, c + y}}}, bsdf, Rgb(radiance)};
}

inline Shape sphere(const Vec3& center, double radius, const Bsdf& bsdf, double radiance = 0.0) {
  return {"sphere", Sphere{center, radius}, bsdf, Rgb(radiance)};
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
