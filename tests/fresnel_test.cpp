// SPDX-License-Identifier: Apache-2.0

// Glass and metals against Fresnel's equations and Snell's law, for every method, sampler and
// precision. A camera that sees one point looks at them from a known angle.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

#include "scene_files/air_gap.h"
#include "tests/closed_forms.h"
#include "tests/test_scenes.h"

namespace plumb::test {
namespace {

constexpr double pi = std::numbers::pi;
using Index = std::complex<double>;

// Fresnel's laws of sines and tangents.
double reflectance(double angle, Index n) {
  if (angle == 0.0) return std::norm((n - 1.0) / (n + 1.0));
  const Index beyond = std::asin(std::sin(angle) / n);
  return (std::norm(std::sin(angle - beyond) / std::sin(angle + beyond)) +
          std::norm(std::tan(angle - beyond) / std::tan(angle + beyond))) /
         2.0;
}

std::string degrees(double angle) { return std::to_string(std::lround(angle * 180.0 / pi)); }

// A box whose corners are the same bits in all faces, facing outwards.
Shape block(const Vec3& low, const Vec3& high, const Bsdf& bsdf) {
  Mesh faces;
  for (const Shape& side : room(low, high, bsdf)) {
    faces.push_back(std::get<Mesh>(side.geometry)[0]);
    std::reverse(faces.back().corners.begin(), faces.back().corners.end());
  }
  return {"block", faces, bsdf, Rgb(0.0)};
}

// The same in triangles, too many for a solid.
Shape fine_block(const Vec3& low, const Vec3& high, const Bsdf& bsdf) {
  const Shape coarse = block(low, high, bsdf);
  Mesh faces;
  constexpr int n = 5;
  for (const Polygon& face : std::get<Mesh>(coarse.geometry)) {
    const auto& c = face.corners;
    const auto at = [&](int i, int j) {
      return c[0] + (c[1] - c[0]) * (double(i) / n) + (c[3] - c[0]) * (double(j) / n);
    };
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        faces.push_back({{at(i, j), at(i + 1, j), at(i + 1, j + 1)}});
        faces.push_back({{at(i, j), at(i + 1, j + 1), at(i, j + 1)}});
      }
    }
  }
  return {"fine_block", faces, bsdf, Rgb(0.0)};
}

Camera aimed(double angle, double distance, double height = 0.0) {
  return camera(Vec3(std::sin(angle), std::cos(angle), 0) * distance + Vec3(0, height, 0),
                {0, height, 0}, pinpoint);
}

// A wide pane seen from above, between two half spaces of which one shines with 1. Light is
// reflected to and fro in it: in all t^2 (1 - R)^2 / (1 - (r R)^2) goes through a pane that tints
// what it reflects by r and what goes through a surface by t; and what is reflected is
// r R + t^2 (1 - R)^2 r R / (1 - (r R)^2).
Case pane(double angle, double ior, bool from_above, double r, double t, bool is_fine) {
  Bsdf bsdf = glass(ior);
  bsdf.reflectance = Rgb(r);
  bsdf.transmittance = Rgb(t);
  Scene scene;
  const Vec3 low(-60, -0.1, -60), high(60, 0.1, 60);
  const Vec3 x(800, 0, 0), z(0, 0, 800);
  scene.shapes = {is_fine ? fine_block(low, high, bsdf) : block(low, high, bsdf),
                  from_above ? parallelogram({-400, 50, -400}, x, z, diffuse(0.0), 1.0)
                             : parallelogram({-400, -50, -400}, z, x, diffuse(0.0), 1.0)};
  scene.camera = aimed(angle, 3.0);
  const double f = reflectance(angle, ior), loss = t * t * (1 - f) * (1 - f) / (1 - r * r * f * f);
  return {std::string(is_fine ? "fine_" : "") + (from_above ? "reflecting_" : "clear_") +
              (t < 1.0 ? "tinted_" : "") + "pane_at_" + degrees(angle),
          scene,
          from_above ? r * f * (1 + loss) : loss,
          {},
          from_above ? 5.0 : 1.0};
}

// A mirror at an angle, which shows a bright sky.
Case metal_at(const std::string& name, double angle, double eta, double k) {
  Scene scene;
  scene.shapes = {parallelogram({-1, 0, -1}, {0, 0, 2}, {2, 0, 0}, metal(Rgb(eta), Rgb(k))),
                  parallelogram({-99, 9, -99}, {198, 0, 0}, {0, 0, 198}, diffuse(0.0), 1.0)};
  scene.camera = aimed(angle, 1.0);
  return {name + "_at_" + degrees(angle), scene, reflectance(angle, {eta, k})};
}

// A metal ball in a room that shines with 1 and reflects nothing, met at that angle.
Case metal_ball(double angle) {
  Scene scene;
  scene.shapes = room({-2, -2, -2}, {2, 2, 2}, diffuse(0.0), 1.0);
  scene.shapes.push_back(sphere({0, -1, 0}, 1.0, metal(Rgb(0.2), Rgb(3.9))));
  scene.camera = aimed(angle, 0.5);
  return {"metal_ball_at_" + degrees(angle), tilted(scene), reflectance(angle, {0.2, 3.9})};
}

// A black lamp in the middle of a glass ball, met at an angle: of its radiance, of which the glass
// holds n^2 times as much as the air, 1 - R gets out.
Case lamp_in_a_ball(double angle, double ior) {
  Scene scene;
  scene.shapes = {sphere({0, -1, 0}, 1.0, glass(ior)), sphere({0, -1, 0}, 0.7, diffuse(0.0), 1.0)};
  scene.camera = aimed(angle, 2.0);
  return {"lamp_in_a_ball_at_" + degrees(angle), scene,
          (1.0 - reflectance(angle, ior)) / (ior * ior)};
}

// A camera in glass, that sees a room of radiance 1: in glass that is n^2, whatever is reflected.
Case inside_a_ball(double ior) {
  Scene scene;
  scene.shapes = room({-2, -2, -2}, {2, 2, 2}, diffuse(0.0), 1.0);
  scene.shapes.push_back(sphere({0, 0, 0}, 1.0, glass(ior)));
  scene.camera = camera({0.3, 0.1, 0.2}, {1, 0, 0}, 90.0);
  return {"inside_a_ball", scene, ior * ior};
}

// A prism of 45 degrees that turns light by total reflection: only the two faces that it meets
// straight reflect some, and what they reflect comes back the same way, to the camera's dark side.
Case prism() {
  const Vec3 a(0, 0, -9), b(1, 0, -9), c(0, 1, -9), depth(0, 0, 18);
  Scene scene;
  const Mesh faces{{{a, c, b}},
                   {{a + depth, b + depth, c + depth}},
                   {{a, b, b + depth, a + depth}},
                   {{b, c, c + depth, b + depth}},
                   {{c, a, a + depth, c + depth}}};
  scene.shapes = {{"prism", faces, glass(1.5), Rgb(0.0)},
                  parallelogram({-9, -2, -9}, {0, 0, 18}, {18, 0, 0}, diffuse(0.0), 1.0)};
  scene.camera = camera({-1, 0.4, 0}, {0, 0.4, 0}, pinpoint);
  const double f = reflectance(0.0, 1.5);
  return {"prism", scene, (1 - f) * (1 - f) / (1 - f * f)};
}

// Glass in a room whose walls emit 1 and reflect a: everything shines with 1 / (1 - a).
Case furnace(const std::string& name, const Shape& thing, double albedo) {
  Scene scene;
  scene.shapes = room({-1, -1, -1}, {1, 1.5, 1}, diffuse(albedo), 1.0);
  scene.shapes.push_back(thing);
  scene.camera = camera({-0.7, 0.6, -0.8}, {0.2, -0.2, 0.1}, 60.0);
  return {name, tilted(scene), 1.0 / (1.0 - albedo), {}, albedo > 0.0 ? 4.0 : 1.0};
}

// A point of a floor under a lamp that covers the sky from one angle on: E = pi L sin^2(angle).
// Between them is a ball that is there in name only.
Case ball_of_air() {
  constexpr double albedo = 0.75, radius = 1.0, distance = 2.0;
  Scene scene;
  scene.shapes = {parallelogram({-0.5, 0, -0.5}, {0, 0, 1}, {1, 0, 0}, diffuse(albedo)),
                  sphere({0, distance, 0}, radius, diffuse(0.0), 1.0),
                  sphere({0.1, 0.5, 0}, 0.4, glass(1.0))};
  scene.camera = camera({-0.4, 0.03, 0.05}, {0, 0, 0}, pinpoint);
  return {"ball_of_air", scene, albedo * radius * radius / (distance * distance), {1, 3}, 4.0};
}

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const double angle : {0.0, 0.8, 1.4}) {
    all.push_back(pane(angle, 1.5, false, 1.0, 1.0, false));
    all.push_back(pane(angle, 1.5, true, 1.0, 1.0, false));
    all.push_back(lamp_in_a_ball(angle, 1.8));
    all.push_back(metal_ball(angle));
    all.push_back(metal_at("copper", angle, 0.2, 3.9));
    all.push_back(metal_at("mercury", angle, 2.4, 6.3));
    all.push_back(metal_at("quartz", angle, 1.7, 0.0));
  }
  all.push_back(pane(0.7, 1.5, false, 0.9, 0.8, false));
  all.push_back(pane(0.7, 2.4, true, 0.9, 0.8, false));
  all.push_back(pane(0.7, 1.5, false, 1.0, 1.0, true));
  all.push_back(pane(0.7, 0.8, false, 1.0, 1.0, false));
  all.back().name = "pane_of_air_in_water";
  all.push_back(inside_a_ball(1.5));
  all.push_back(prism());
  const Vec3 center(0.2, -0.3, 0.1);
  for (const double albedo : {0.0, 0.5}) {
    const std::string name = albedo == 0.0 ? "black_furnace" : "furnace";
    all.push_back(furnace(name + "_with_a_ball", sphere(center, 0.5, glass(1.5)), albedo));
    all.push_back(furnace(name + "_with_a_bubble", sphere(center, 0.5, glass(0.7)), albedo));
    all.push_back(furnace(name + "_with_a_diamond", icosphere(center, 0.5, 0, glass(2.4)), albedo));
    all.push_back(furnace(name + "_with_a_mesh", icosphere(center, 0.5, 2, glass(1.3)), albedo));
  }
  all.push_back(furnace("furnace_with_a_block_on_its_floor",
                        block({-0.3, -1, -0.4}, {0.3, -0.4, 0.2}, glass(1.5)), 0.5));
  leave_air_around_glass(all.back().scene);
  all.push_back(ball_of_air());
  return all;
}

class Fresnel : public testing::TestWithParam<std::tuple<Combination, int>> {};

TEST_P(Fresnel, IsMetWithinFourStandardErrors) {
  const auto& [combination, number] = GetParam();
  const bool is_plain = std::get<Method>(combination) == Method::plain;
  expect_met(cases()[size_t(number)], combination, is_plain ? 3e-3 : 5e-4, 3e-6);
}

std::string case_name_of(const testing::TestParamInfo<Fresnel::ParamType>& info) {
  const auto& [combination, number] = info.param;
  return name_of(combination) + cases()[size_t(number)].name;
}

INSTANTIATE_TEST_SUITE_P(All, Fresnel,
                         testing::Combine(all_combinations,
                                          testing::Range(0, static_cast<int>(cases().size()))),
                         case_name_of);

INSTANTIATE_TEST_SUITE_P(Plain, Fresnel,
                         testing::Combine(plain_combination,
                                          testing::Range(0, static_cast<int>(cases().size()))),
                         case_name_of);

}  // namespace
}  // namespace plumb::test
