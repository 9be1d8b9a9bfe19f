// SPDX-License-Identifier: Apache-2.0

// Rough metals: what they reflect against quadrature, for every method, sampler and precision.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

#include "tests/closed_forms.h"
#include "tests/test_scenes.h"

namespace plumb::test {
namespace {

constexpr double pi = std::numbers::pi;
using Index = std::complex<double>;

// Fresnel's laws of sines and tangents.
double reflectance(double angle, Index n) {
  if (angle < 1e-9) return std::norm((n - 1.0) / (n + 1.0));
  const Index beyond = std::asin(std::sin(angle) / n);
  return (std::norm(std::sin(angle - beyond) / std::sin(angle + beyond)) +
          std::norm(std::tan(angle - beyond) / std::tan(angle + beyond))) /
         2.0;
}

// Smith's shadowing of GGX by its Lambda.
double unshadowed(double alpha, double cosine) {
  const double tangent = std::tan(std::acos(std::min(cosine, 1.0)));
  return 1.0 / (1.0 + (std::sqrt(1.0 + alpha * alpha * tangent * tangent) - 1.0) / 2.0);
}

struct Plate {
  double alpha, angle;  // to the normal, from which it is seen
  Index n;
};

Vec3 view_of(const Plate& plate) { return {std::sin(plate.angle), std::cos(plate.angle), 0}; }

// What it reflects of a sky of radiance 1: the integral of f times the cosine. Half vectors are
// drawn as the microfacets' projected areas are: of the square [0, 1] x [0, 1] the middles of
// cells, by the map whose density is D cos; light is reflected with the weight F G (view . half) /
// (cos cos).
double of_a_sky(const Plate& plate) {
  constexpr int rows = 1000, columns = 500;
  const Vec3 view = view_of(plate);
  double sum = 0.0;
  for (int i = 0; i < rows; ++i) {
    const double u = (i + 0.5) / rows;
    const double tangent = plate.alpha * std::sqrt(u / (1.0 - u));
    const double cosine = 1.0 / std::hypot(1.0, tangent), sine = tangent * cosine;
    for (int j = 0; j < columns; ++j) {
      const double turn = pi * (j + 0.5) / columns;  // the other half is the same
      const Vec3 half(sine * std::cos(turn), cosine, sine * std::sin(turn));
      const double facing = half.dot(view);
      const Vec3 out = half * (2.0 * facing) - view;
      if (facing <= 0.0 || out.y <= 0.0) continue;
      sum += reflectance(std::acos(std::min(facing, 1.0)), plate.n) *
             unshadowed(plate.alpha, view.y) * unshadowed(plate.alpha, out.y) * facing /
             (view.y * cosine);
    }
  }
  return sum / (double(rows) * columns);
}

struct Lamp {
  Vec3 corner, x, y;
};

// The same of a lamp of radiance 1 that faces down, as an integral over its area.
double of_a_lamp(const Plate& plate, const Lamp& lamp) {
  constexpr int n = 600;
  const Vec3 view = view_of(plate);
  double sum = 0.0;
  for (int i = 0; i < n * n; ++i) {
    const Vec3 point =
        lamp.corner + lamp.x * ((i % n + 0.5) / n) + lamp.y * ((double(i / n) + 0.5) / n);
    const Vec3 out = point.normalized(), half = (view + out).normalized();
    const double tangent = std::tan(std::acos(std::min(half.y, 1.0)));
    const double spread = 1.0 + tangent * tangent / (plate.alpha * plate.alpha);
    const double density =
        1.0 / (pi * plate.alpha * plate.alpha * std::pow(half.y, 4) * spread * spread);
    sum += reflectance(std::acos(half.dot(view)), plate.n) * density *
           unshadowed(plate.alpha, view.y) * unshadowed(plate.alpha, out.y) / (4.0 * view.y) *
           out.y / point.length2();
  }
  return sum * lamp.x.length() * lamp.y.length() / (double(n) * n);
}

Scene plate_scene(const Plate& plate) {
  Scene scene;
  scene.shapes = {
      parallelogram({-1, 0, -1}, {0, 0, 2}, {2, 0, 0},
                    rough_metal(plate.alpha, Rgb(plate.n.real()), Rgb(plate.n.imag())))};
  scene.camera = camera(view_of(plate) * 0.15, {0, 0, 0}, pinpoint);  // below the lamp
  return scene;
}

constexpr Plate plates[] = {
    {0.01, 0.3, {0.2, 3.9}}, {0.1, 0.0, {0.2, 3.9}}, {0.1, 1.2, {4.4, 5.2}}, {0.3, 0.7, {1.5, 0.0}},
    {0.5, 1.45, {0.2, 3.9}}, {1.0, 0.5, {2.4, 6.3}}, {1.0, 1.3, {0.2, 3.9}}};

class RoughMetal : public testing::TestWithParam<std::tuple<Combination, int>> {
 protected:
  void expect(const Scene& scene, double radiance, double patience) {
    const Combination& combination = std::get<0>(GetParam());
    const Method method = std::get<Method>(combination);
    if (method == Method::nee && plate.alpha < 0.3) GTEST_SKIP() << "hardly ever meets the lobe";
    constexpr double of_quadrature = 1e-4;
    expect_met({"", scene, radiance, {1, 1}, patience}, combination,
               method == Method::plain ? 3e-3 : 5e-4, of_quadrature);
  }

  const Plate& plate = plates[std::get<1>(GetParam())];
};

TEST_P(RoughMetal, ReflectsOfASkyAllThatItDoesNotSwallow) {
  Scene scene = plate_scene(plate);
  scene.sky = Rgb(1.0);
  expect(tilted(scene), of_a_sky(plate), 1.0);
}

// A rectangle that stands about where a smooth mirror would show it.
TEST_P(RoughMetal, ReflectsOfALampWhatComesFromThere) {
  Scene scene = plate_scene(plate);
  const double middle = -0.2 * std::min(std::tan(plate.angle), 1.5);
  const Lamp lamp{{middle - 0.25, 0.2, -0.15}, {0.5, 0, 0}, {0, 0, 0.3}};
  scene.shapes.push_back(parallelogram(lamp.corner, lamp.x, lamp.y, diffuse(0.0), 1.0));
  expect(tilted(scene), of_a_lamp(plate, lamp), 2.0);
}

std::string plate_name_of(const testing::TestParamInfo<RoughMetal::ParamType>& info) {
  const auto& [combination, number] = info.param;
  const Plate& plate = plates[number];
  return name_of(combination) + "alpha_" + std::to_string(std::lround(100 * plate.alpha)) + "_at_" +
         std::to_string(std::lround(plate.angle * 180.0 / pi));
}

constexpr int count = std::size(plates);
INSTANTIATE_TEST_SUITE_P(All, RoughMetal,
                         testing::Combine(all_combinations, testing::Range(0, count)),
                         plate_name_of);
INSTANTIATE_TEST_SUITE_P(Plain, RoughMetal,
                         testing::Combine(plain_combination, testing::Range(0, count)),
                         plate_name_of);

}  // namespace
}  // namespace plumb::test
