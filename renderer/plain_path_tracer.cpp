// SPDX-License-Identifier: Apache-2.0

// A pixel's value is the integral over paths x0 x1 ... xn from the camera to a lamp, for all n
// (Veach 1997, section 8.2, with each area integral but the first turned into one over directions),
//
//   sum over n of  integral of  filter(x0 x1) * product over i of f_i cos_i * Le(xn)
//
// where f_i is the BSDF and cos_i the cosine of the direction that leaves x_i. The estimate is that
// integrand over the density with which the path has been sampled: each vertex multiplies the
// `throughput` by f cos / pdf. The last direction, that to the lamp, is sampled in two ways: as any
// other, and by a point of the lamp (next event estimation). The balance heuristic weights the two
// samples (multiple importance sampling, MIS; section 9.2.2). A throughput of T goes on with the
// probability q, as T / q (Russian roulette).
#include "renderer/plain_path_tracer.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <random>
#include <utility>

namespace plumb {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double delta = std::numeric_limits<double>::infinity();  // the pdf of the only direction

double balance_heuristic(double p, double q) { return p == delta ? 1.0 : p / (p + q); }

double area(const Surface& surface) {
  if (surface.sphere() != nullptr) return 4.0 * pi * std::pow(surface.sphere()->radius, 2);
  const auto& c = surface.polygon()->corners;
  return (c[1] - c[0]).cross(c.back() - c[0]).length() / (c.size() == 3 ? 2.0 : 1.0);
}

constexpr double sky_pdf = 1.0 / (4.0 * pi);  // all directions alike

// The direction whose cosine to the unit vector `axis` is given, turned around it by a part of the
// full circle.
Vec3 direction_around(const Vec3& axis, double cosine, double part) {
  const Vec3 other = std::abs(axis.x) < 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  const Vec3 x = axis.cross(other).normalized();
  const double angle = 2.0 * pi * part;
  const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
  return (x * std::cos(angle) + axis.cross(x) * std::sin(angle)) * sine + axis * cosine;
}

// What Fresnel's equations say is reflected of unpolarised light that meets, at that cosine, a
// smooth border, beyond which the refractive index is `n` times that on this side (Born and Wolf,
// Principles of Optics, sections 1.5 and 14.2: the squares of both amplitudes' ratios).
double fresnel(double cosine, const std::complex<double>& n) {
  const auto beyond = std::sqrt(n * n - (1.0 - cosine * cosine));  // n times the cosine there
  const auto across = (cosine - beyond) / (cosine + beyond);
  const auto in_plane = (n * n * cosine - beyond) / (n * n * cosine + beyond);
  return (std::norm(across) + std::norm(in_plane)) / 2.0;
}

// Of metals: what the reflectance is multiplied by.
Vec3 fresnel(double cosine, const Bsdf& bsdf) {
  Vec3 reflected(1.0);
  for (int c = 0; c < 3 && bsdf.is_metal(); ++c)
    reflected[c] = fresnel(cosine, {bsdf.eta[c], bsdf.k[c]});
  return reflected;
}

double squared_tangent(double cosine) { return 1.0 / (cosine * cosine) - 1.0; }

// GGX: of tiny mirrors the density of those whose normal has that cosine, and the share of them
// that others don't hide (Walter et al., "Microfacet Models for Refraction through Rough Surfaces",
// EGSR 2007, equations 33 and 34).
double ggx(double alpha, double cosine) {
  const double spread = alpha * alpha + squared_tangent(cosine);
  return std::pow(alpha / (cosine * cosine * spread), 2) / pi;
}

double visible(double alpha, double cosine) {
  return 2.0 / (1.0 + std::sqrt(1.0 + alpha * alpha * squared_tangent(cosine)));
}

// A surface that scatters light, which leads to it from `view`, to many directions.
struct Scattering {
  const Bsdf& bsdf;
  Vec3 normal, view;

  // The BSDF's value, for directions above the surface.
  Vec3 f(const Vec3& direction) const {
    if (bsdf.kind == Bsdf::Kind::diffuse) return bsdf.reflectance / pi;
    const Vec3 half = (view + direction).normalized();
    const double in = normal.dot(view), out = normal.dot(direction);
    return bsdf.reflectance * fresnel(half.dot(view), bsdf) *
           (ggx(bsdf.alpha, normal.dot(half)) * visible(bsdf.alpha, in) * visible(bsdf.alpha, out) /
            (4.0 * in * out));
  }

  double pdf(const Vec3& direction) const {
    if (bsdf.kind == Bsdf::Kind::diffuse) return normal.dot(direction) / pi;
    const Vec3 half = (view + direction).normalized();
    const double cosine = normal.dot(half);
    return ggx(bsdf.alpha, cosine) * cosine / (4.0 * half.dot(view));
  }

  // By that density: the cosine of diffuse light is the square root of an even number; a mirror's
  // normal is drawn in proportion to what it covers of the surface (equation 35).
  Vec3 sample(double u, double v) const {
    if (bsdf.kind == Bsdf::Kind::diffuse) return direction_around(normal, std::sqrt(1.0 - u), v);
    const double tangent = bsdf.alpha * std::sqrt(u / (1.0 - u));
    const Vec3 half = direction_around(normal, 1.0 / std::hypot(1.0, tangent), v);
    return half * (2.0 * half.dot(view)) - view;
  }
};

class Path {
 public:
  Path(const PlainScene& scene, const BounceRange& bounces, std::seed_seq& seed, int64_t& rays)
      : scene_(scene), bounces_(bounces), random_(seed), rays_(rays) {}

  Vec3 radiance(int64_t pixel, const std::function<bool(int64_t)>& is_abandoned) {
    const Camera& camera = scene_.model.camera;
    const double x = sample_filter(static_cast<int>(pixel % camera.width), camera.width);
    const double y = sample_filter(static_cast<int>(pixel / camera.width), camera.height);
    ray_ = {camera.origin, camera.direction(x, y).normalized()};
    for (int bounces = 0; bounces % 1024 != 1023 || !is_abandoned(bounces); ++bounces) {
      const auto [surface, distance] = nearest(ray_);
      if (surface == nullptr) {
        const double weight = bounces_.contains(bounces) ? balance_heuristic(pdf_, sky_pdf) : 0.0;
        return radiance_ + throughput_ * scene_.model.sky * weight;
      }
      const Vec3 point = ray_.at(distance);
      const bool is_front = surface->normal(point).dot(ray_.direction) < 0.0;
      const Vec3 normal = surface->normal(point) * (is_front ? 1.0 : -1.0);
      const Bsdf& bsdf = surface->shape->bsdf;
      if (is_front && bounces_.contains(bounces)) {
        const double weight = balance_heuristic(pdf_, lamp_pdf(*surface, ray_, distance));
        radiance_ += throughput_ * surface->shape->radiance * weight;
      }
      if (!(is_front || bsdf.two_sided) || bounces >= bounces_.last) break;
      if (!bsdf.is_specular() && bounces_.contains(bounces + 1)) {
        const Scattering scattering{bsdf, normal, -ray_.direction};
        add_lamp(point, scattering);
        add_sky(point, scattering);
        add_points(point, scattering);
      }
      ray_ = {point, sample_direction(normal, bsdf, is_front ? bsdf.ior : 1.0 / bsdf.ior)};
      const double survival =
          std::min(1.0, 3.0 * std::ranges::max({throughput_.x, throughput_.y, throughput_.z}));
      if (random() >= survival) break;
      throughput_ /= survival;
    }
    return radiance_;
  }

 private:
  double random() { return static_cast<double>(random_() >> 11) * 0x1p-53; }

  std::pair<const Surface*, double> nearest(const Ray& ray) {
    ++rays_;
    return find_nearest(scene_.surfaces, ray, scene_.margin);
  }

  // A coordinate in the picture, in proportion to the pixel's filter.
  double sample_filter(int pixel, int size) {
    const Filter& filter = scene_.model.camera.filter;
    while (true) {
      const double from_middle = (2.0 * random() - 1.0) * filter.radius();
      const double x = pixel + 0.5 + from_middle;
      const bool counts = filter.crosses_border || (x >= 0.0 && x <= size);
      if (counts && random() * filter.weight(0.0) < filter.weight(from_middle)) return x;
    }
  }

  // The density, with respect to solid angle at the ray's origin, of the point at that distance on
  // a lamp whose points are sampled evenly by area: that by area, times distance^2 / cosine. It
  // includes the chance that this lamp is chosen.
  double lamp_pdf(const Surface& lamp, const Ray& ray, double distance) const {
    const double chance = scene_.choice[size_t(&lamp - scene_.surfaces.data())];
    const double cosine = -lamp.normal(ray.at(distance)).dot(ray.direction);
    return chance / area(lamp) * distance * distance / cosine;
  }

  Vec3 sample_point(const Surface& lamp) {
    double u = random(), v = random();
    if (const Sphere* sphere = lamp.sphere()) {
      return sphere->center + direction_around({0, 0, 1}, 2.0 * u - 1.0, v) * sphere->radius;
    }
    const auto& c = lamp.polygon()->corners;
    if (c.size() == 3 && u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
    return c[0] + (c[1] - c[0]) * u + (c.back() - c[0]) * v;
  }

  // Next event estimation: adds the light of a point that is sampled on a lamp.
  void add_lamp(const Vec3& point, const Scattering& scattering) {
    const auto& choice = scene_.choice;
    size_t i = 0;
    for (double u = random(); i + 1 < choice.size() && u >= choice[i]; ++i) u -= choice[i];
    if (choice.empty() || choice[i] == 0.0) return;  // there's no lamp
    const Surface& lamp = scene_.surfaces[i];
    const Vec3 on_lamp = sample_point(lamp);
    const double distance = (on_lamp - point).length();
    const Ray ray{point, (on_lamp - point) / distance};
    if (lamp.normal(on_lamp).dot(ray.direction) >= 0.0) return;
    const double pdf = lamp_pdf(lamp, ray, distance);
    const double weight = balance_heuristic(pdf, scattering.pdf(ray.direction));
    add_light(ray, distance, scattering, lamp.shape->radiance / pdf * weight);
  }

  void add_sky(const Vec3& point, const Scattering& scattering) {
    if (scene_.model.sky == Rgb(0.0)) return;
    const double cosine = 2.0 * random() - 1.0;
    const Ray ray{point, direction_around(scattering.normal, cosine, random())};
    const double weight = balance_heuristic(sky_pdf, scattering.pdf(ray.direction));
    add_light(ray, delta, scattering, scene_.model.sky / sky_pdf * weight);
  }

  // The inverse-square law.
  void add_points(const Vec3& point, const Scattering& scattering) {
    for (const PointLamp& lamp : scene_.model.points) {
      const double distance = (lamp.position - point).length();
      const Ray ray{point, (lamp.position - point) / distance};
      add_light(ray, distance, scattering, lamp.intensity / (distance * distance));
    }
  }

  // Adds what the surface scatters of light that comes from that distance, if nothing is in the
  // way.
  void add_light(const Ray& ray, double distance, const Scattering& scattering,
                 const Vec3& radiance) {
    const double cosine = scattering.normal.dot(ray.direction);
    if (!(cosine > 0.0) || nearest(ray).second < distance - scene_.margin) return;
    radiance_ += throughput_ * scattering.f(ray.direction) * cosine * radiance;
  }

  // Samples the BSDF, and multiplies the throughput by f * cosine / pdf. Beyond the surface the
  // refractive index is `n` times that on this side.
  Vec3 sample_direction(const Vec3& normal, const Bsdf& bsdf, double n) {
    if (bsdf.is_specular()) return sample_specular(normal, bsdf, n);
    const Scattering scattering{bsdf, normal, -ray_.direction};
    const double u = random(), v = random();
    const Vec3 direction = scattering.sample(u, v);
    pdf_ = scattering.pdf(direction);
    const double cosine = std::max(0.0, normal.dot(direction));
    throughput_ *= cosine > 0.0 ? scattering.f(direction) * cosine / pdf_ : Vec3(0.0);
    return direction;
  }

  // f and pdf have the same delta. Of glass, what Fresnel's equations say is reflected is the
  // chance of reflection; Snell's law says where the rest goes.
  Vec3 sample_specular(const Vec3& normal, const Bsdf& bsdf, double n) {
    pdf_ = delta;
    const double cosine = -normal.dot(ray_.direction);
    const Vec3 along = ray_.direction + normal * cosine;
    if (bsdf.kind == Bsdf::Kind::dielectric && random() >= fresnel(cosine, n)) {
      throughput_ *= bsdf.transmittance / (n * n);
      const Vec3 sine = along / n;
      return (sine - normal * std::sqrt(std::max(0.0, 1.0 - sine.length2()))).normalized();
    }
    throughput_ *= bsdf.reflectance * fresnel(cosine, bsdf);
    return (along + normal * cosine).normalized();
  }

  const PlainScene& scene_;
  const BounceRange& bounces_;
  std::mt19937_64 random_;
  int64_t& rays_;
  Ray ray_;
  double pdf_ = delta;  // of the ray's direction
  Vec3 throughput_{1.0}, radiance_{0.0};
};

}  // namespace

PlainScene::PlainScene(const Scene& scene) : model(scene), surfaces(list_surfaces(scene)) {
  double size = 0.0, total = 0.0;
  for (const Surface& surface : surfaces) {
    size = std::max(size, std::sqrt(area(surface)));
    choice.push_back(area(surface) * surface.shape->radiance.dot(Vec3(1.0)));
    total += choice.back();
  }
  for (double& power : choice) power /= std::max(total, std::numeric_limits<double>::min());
  margin = 1e-7 * size;
}

Vec3 trace_path(const PlainScene& scene, const Settings& settings, int64_t pixel, int64_t sample,
                const std::function<bool(int64_t)>& is_abandoned, int64_t& rays) {
  std::seed_seq seed{int64_t{settings.seed}, pixel, sample};
  return Path(scene, settings.bounces, seed, rays).radiance(pixel, is_abandoned);
}

}  // namespace plumb
