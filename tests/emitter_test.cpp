// SPDX-License-Identifier: Apache-2.0

// A sky all around and lamps that are points: radiance that is known exactly.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/closed_forms.h"
#include "tests/test_scenes.h"

namespace plumb::test {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double albedo = 0.75;

// A small floor around the origin, seen from aside.
Scene floor_at_origin() {
  Scene scene;
  scene.shapes = {parallelogram({-0.5, 0, -0.5}, {0, 0, 1}, {1, 0, 0}, diffuse(albedo))};
  scene.camera = camera({-0.4, 0.03, 0.05}, {0, 0, 0}, pinpoint);
  return scene;
}

// Of a convex body every point sees half of the sky and nothing of the body.
Case convex_body(const std::string& name, const Shape& body) {
  Scene scene;
  scene.shapes = {body};
  scene.sky = Rgb(2.0);
  scene.camera = camera({1.5, 0.8, 1.0}, {0, 0, 0}, 5.0);
  return {name, tilted(scene), 2.0 * albedo, {}};
}

// White things under a white sky can't be told from it, wherever they touch, in whatever they are
// mirrored and through whatever glass they are seen.
Case white_things(bool with_lamps) {
  Scene scene;
  const Bsdf white = diffuse(1.0, true);
  const double glow = with_lamps ? 0.5 : 0.0;
  const auto reflects = [&](double radiance) { return diffuse(1.0 - radiance, true); };
  scene.shapes = {parallelogram({-2, -0.5, -2}, {0, 0, 4}, {4, 0, 0}, white),
                  sphere({0.5, 0, 0.2}, 0.5, reflects(glow), glow),
                  sphere({-0.5, 0, 0.2}, 0.5, mirror(1.0)),
                  sphere({0, 0, -0.8}, 0.5, glass(1.5)),
                  parallelogram({-0.4, -0.5, 0.8}, {0.8, 0, 0}, {0, 0.8, 0}, white),
                  polygon({{-1, -0.5, -1}, {-1, 0.5, 0}, {-1, -0.5, 1}}, white)};
  scene.sky = Rgb(1.0);
  scene.camera = camera({0.3, 1.1, -2.0}, {0, -0.1, 0}, 60.0);
  return {with_lamps ? "white_lamps" : "white_things", tilted(scene), 1.0};
}

// A black ball that stands on the floor hides r^3 / D^3 of what lights a point: at the distance D
// of its middle it is seen under pi sin^2 = pi r^2 / D^2, at an angle whose cosine is r / D.
Case beside_a_ball(double r, double aside) {
  Scene scene = floor_at_origin();
  scene.shapes.push_back(sphere({aside, r, 0}, r, diffuse(0.0)));
  scene.sky = Rgb(3.0);
  const double distance = std::hypot(aside, r);
  return {"beside_a_ball", scene, 3.0 * albedo * (1.0 - std::pow(r / distance, 3)), {}};
}

// Under a black lid with a window of w by w straight above, at the height h: the form factor of a
// square, and what the lid leaves free beside itself.
Case below_a_window(double w, double h, const Shape& in_window) {
  Scene scene = floor_at_origin();
  const double wide = 20.0, half = w / 2.0;
  const auto lid = [&](double x, double z, double dx, double dz) {
    return parallelogram({x, h, z}, {dx, 0, 0}, {0, 0, dz}, diffuse(0.0, true));
  };
  scene.shapes.push_back(lid(-wide, -wide, 2 * wide, wide - half));
  scene.shapes.push_back(lid(-wide, half, 2 * wide, wide - half));
  scene.shapes.push_back(lid(-wide, -half, wide - half, w));
  scene.shapes.push_back(lid(half, -half, wide - half, w));
  scene.shapes.push_back(in_window);
  scene.sky = Rgb(5.0);
  const auto factor = [h](double half_side) {
    const double root = std::hypot(half_side, h);
    return 4.0 / pi * half_side / root * std::atan(half_side / root);
  };
  return {"below_a_window_" + std::to_string(int(w * 10)),
          scene,
          5.0 * albedo * (factor(half) + 1.0 - factor(wide)),
          {1, 1},
          2.0};
}

Shape nowhere() { return sphere({0, -9, 0}, 0.1, diffuse(0.0)); }

// Half of the sky, a lamp that covers none of it, and a point, at once.
Case lamps_of_all_kinds(bool is_tilted) {
  Scene scene = floor_at_origin();
  const double sine = 0.25;
  scene.shapes.push_back(sphere({1.6, 1.2, 0}, 2.0 * sine, diffuse(0.0), 7.0));
  scene.sky = Rgb(0.5);
  scene.points = {{{0, 2, 1}, Rgb(9.0)}, {{-1, 1, 0}, Rgb(0.01)}, {{0, -1, 0}, Rgb(3.0)}};
  const double ball = sine * sine * 0.6;  // of all that lights the point, the ball's part
  const double points = 9.0 / 5.0 * 2.0 / std::sqrt(5.0) + 0.01 / 2.0 * std::sqrt(0.5);
  return {is_tilted ? "lamps_of_all_kinds_tilted" : "lamps_of_all_kinds",
          is_tilted ? tilted(scene) : scene,
          albedo * (0.5 * (1.0 - ball) + 7.0 * ball + points / pi)};
}

// The inverse-square law: I cos / d^2.
Case point_lamp(const std::string& name, const Vec3& position) {
  Scene scene = floor_at_origin();
  scene.points = {{position, Rgb(4.0)}};
  const double distance = position.length();
  return {name, tilted(scene), albedo / pi * 4.0 * position.y / std::pow(distance, 3)};
}

std::vector<Case> cases() {
  const auto window = parallelogram({-0.3, 0.5, -0.3}, {0.6, 0, 0}, {0, 0, 0.6}, glass(1.0));
  Case through_glass = below_a_window(0.4, 0.5, window);
  through_glass.name = "below_glass_that_is_none";
  through_glass.bounces = {1, 2};
  return {convex_body("ball", sphere({0, 0, 0}, 0.5, diffuse(albedo))),
          convex_body("diamond", icosphere({0, 0, 0}, 0.5, 0, diffuse(albedo))),
          convex_body("facets", icosphere({0, 0, 0}, 0.5, 2, diffuse(albedo))),
          white_things(false),
          white_things(true),
          beside_a_ball(0.5, 0.6),
          below_a_window(0.4, 0.5, nowhere()),
          below_a_window(1.5, 0.5, nowhere()),
          through_glass,
          lamps_of_all_kinds(false),
          lamps_of_all_kinds(true),
          point_lamp("point_above", {0, 2, 0}),
          point_lamp("point_aslant", {1, 0.3, -0.5}),
          point_lamp("point_close", {0.1, 0.2, 0})};
}

class EmitterWithoutShape : public testing::TestWithParam<std::tuple<Combination, int>> {};

TEST_P(EmitterWithoutShape, LightsAsItsClosedFormSays) {
  const auto& [combination, number] = GetParam();
  const Case c = cases()[size_t(number)];
  const Method method = std::get<Method>(combination);
  if (method == Method::bsdf && !c.scene.points.empty()) {
    EXPECT_THROW(render_film(c.scene, {.method = method, .bounces = {}}, {0, 4}),
                 std::invalid_argument);
    return;
  }
  expect_met(c, combination, method == Method::plain ? 3e-3 : 5e-4, 3e-6);
}

std::string case_name_of(const testing::TestParamInfo<EmitterWithoutShape::ParamType>& info) {
  const auto& [combination, number] = info.param;
  return name_of(combination) + cases()[size_t(number)].name;
}

INSTANTIATE_TEST_SUITE_P(All, EmitterWithoutShape,
                         testing::Combine(all_combinations,
                                          testing::Range(0, static_cast<int>(cases().size()))),
                         case_name_of);

INSTANTIATE_TEST_SUITE_P(Plain, EmitterWithoutShape,
                         testing::Combine(plain_combination,
                                          testing::Range(0, static_cast<int>(cases().size()))),
                         case_name_of);

const Settings sampled{.method = Method::mis, .seed = 1, .bounces = {}};

// A ball of radiance I / (pi r^2) that shrinks: the point is its limit. They are at the same
// distance of a box, whose shadow on the floor has an edge that grows sharp.
TEST(PointLamp, IsTheLimitOfSmallSpheres) {
  Scene point;
  point.shapes = {parallelogram({-2, 0, -2}, {0, 0, 4}, {4, 0, 0}, diffuse(albedo)),
                  parallelogram({-0.3, 0.5, -0.3}, {0, 0, 0.6}, {0.6, 0, 0}, diffuse(0.5, true))};
  point.camera = camera({1.0, 1.5, 1.5}, {0, 0, 0}, 60.0, 32);
  Scene ball = point;
  constexpr double radius = 1e-3;
  point.points = {{{0.2, 1.5, 0.1}, Rgb(3.0)}};
  ball.shapes.push_back(
      sphere({0.2, 1.5, 0.1}, radius, diffuse(0.0), 3.0 / (pi * radius * radius)));
  const std::vector<float> a = render_film(point, sampled, {0, 4096}).mean();
  const std::vector<float> b = render_film(ball, sampled, {0, 4096}).mean();
  double difference = 0.0, sum = 0.0;
  for (size_t i = 0; i < a.size(); ++i) {
    difference += double{a[i]} - double{b[i]};
    sum += double{a[i]};
  }
  EXPECT_NEAR(difference / sum, 0.0, 1e-3);
}

TEST(PointLamp, IsNotSeenAndLeavesDarkWhatIsInShadow) {
  Scene scene = floor_at_origin();
  scene.points = {{{0, 1, 0}, Rgb(5.0)}};
  scene.shapes.push_back(parallelogram({-0.1, 0.5, -0.1}, {0.2, 0, 0}, {0, 0, 0.2}, diffuse(0.0)));
  for (const float value : render_film(scene, sampled, {0, 16}).mean()) EXPECT_EQ(value, 0.0f);
  scene.camera = camera({2, 1, 0}, {0, 1, 0}, 20.0);
  for (const float value : render_film(scene, sampled, {0, 16}).mean()) EXPECT_EQ(value, 0.0f);
}

// What a picture shows of the sky is the sky, also where nothing else is.
TEST(Sky, IsSeen) {
  Scene empty;
  empty.sky = Rgb(0.1, 0.2, 0.3);
  empty.camera = camera({0, 0, 0}, {1, 0, 0}, 60.0);
  const std::vector<float> mean = render_film(empty, sampled, {0, 16}).mean();
  for (size_t i = 0; i < mean.size(); ++i) EXPECT_FLOAT_EQ(mean[i], float(empty.sky[int(i % 3)]));
}

}  // namespace
}  // namespace plumb::test
