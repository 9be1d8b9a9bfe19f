// SPDX-License-Identifier: Apache-2.0

// Radiance that is known exactly, for every method, sampler and precision.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include "tests/test_scenes.h"

namespace plumb::test {
namespace {

constexpr double pi = std::numbers::pi;

struct Case {
  std::string name;
  Scene scene;
  double radiance;  // expected in every pixel's mean, all channels
  BounceRange bounces;
  double patience = 1.0;  // by how much its standard error may be larger than the others'
};

// Irradiance at p, facing n, from a polygon of radiance 1 that is all above p's horizon: Lambert
// 1760, half the sum over the edges of the angle they are seen at times the normal's component
// along the edge's plane. Corners are clockwise seen from p.
double lambert(const std::vector<Vec3>& corners, const Vec3& p, const Vec3& n) {
  double sum = 0.0;
  for (size_t i = 0; i < corners.size(); ++i) {
    const Vec3 a = corners[i] - p;
    const Vec3 b = corners[(i + 1) % corners.size()] - p;
    const Vec3 normal = a.cross(b);
    sum += std::atan2(normal.length(), a.dot(b)) * normal.normalized().dot(n);
  }
  return std::abs(sum) / 2.0;
}

// A point on a wall, lit by a polygon of radiance 1 that faces down. Seen from in front. The wall
// may itself be a lamp, on this side or the other.
Case polygon_lamp(const std::string& name, const std::vector<Vec3>& lamp, const Vec3& point,
                  const Vec3& normal, double front = 0.0, double back = 0.0) {
  constexpr double albedo = 0.75;
  const Vec3 side = (std::abs(normal.y) < 0.5 ? Vec3(0, 1, 0) : Vec3(0, 0, 1)).cross(normal);
  const Vec3 up = normal.cross(side);
  Scene scene;
  Shape wall = parallelogram(point - side * 0.25 - up * 0.25, side * 0.5, up * 0.5,
                             diffuse(albedo, true), front + back);
  auto& corners = std::get<Mesh>(wall.geometry)[0].corners;
  if (back > 0.0) std::reverse(corners.begin(), corners.end());
  Mesh faces{{lamp}};
  if (lamp.size() > 4) {
    faces = {{{lamp[0], lamp[1], lamp[2]}}, {{lamp[0], lamp[2], lamp[3], lamp[4]}}};
  }
  scene.shapes = {wall, {"lamp", faces, diffuse(0.0), Rgb(1.0)}};
  scene.camera = camera(point + normal * 0.02 + side * 0.4 - up * 0.1, point, pinpoint);
  return {name, scene, albedo / pi * lambert(lamp, point, normal), {1, 1}};
}

Case rectangle_lamp(const std::string& name, const Vec3& corner, const Vec3& x, const Vec3& y,
                    const Vec3& point, const Vec3& normal) {
  return polygon_lamp(name, {corner, corner + x, corner + x + y, corner + y}, point, normal);
}

std::vector<Case> rectangle_lamps() {
  const Vec3 x(1, 0, 0);
  const Vec3 z(0, 0, 1);
  return {
      rectangle_lamp("below", {-0.5, 2, -0.5}, x, z, {0.1, 0, 0.2}, {0, 1, 0}),
      rectangle_lamp("aside", {0.5, 2, -1.5}, x, z, {0, 0, 0}, {0, 1, 0}),
      rectangle_lamp("tilted", {1.5, 2, -0.5}, x, z, {0, 0, 0}, Vec3(0.6, 0.8, 0)),
      rectangle_lamp("large_and_near", {-2, 0.2, -2}, x * 4, z * 4, {0.3, 0, 0.1}, {0, 1, 0}),
      // A wall beside the lamp, 3 % and 0.5 % of the lamp's size below its plane.
      rectangle_lamp("grazing", {-0.5, 0.03, 0.1}, x, z, {0.1, 0, 0}, {0, 0, 1}),
      rectangle_lamp("more_grazing", {-2, 0.005, 0.02}, x * 4, z, {0.1, 0, 0}, {0, 0, 1}),
      // The Cornell box's back wall, 68.3 and 8.3 units below the lamp's plane; units are halved
      // lamp depths.
      rectangle_lamp("cornell_480", {-65 / 52.5, 68.3 / 52.5, 227.2 / 52.5}, x * (130 / 52.5),
                     z * 2, {0, 0, 0}, {0, 0, 1}),
      rectangle_lamp("cornell_540", {-65 / 52.5, 8.3 / 52.5, 227.2 / 52.5}, x * (130 / 52.5), z * 2,
                     {0, 0, 0}, {0, 0, 1}),
  };
}

std::vector<Case> polygon_lamps() {
  const Vec3 up(0, 1, 0);
  const std::vector<Vec3> triangle{{-0.5, 1, -0.4}, {0.6, 1, -0.2}, {0.1, 1, 0.7}};
  const std::vector<Vec3> trapezium{
      {-0.9, 0.7, -0.6}, {0.9, 0.7, -0.6}, {0.3, 0.7, 0.8}, {-0.2, 0.7, 0.8}};
  const std::vector<Vec3> pentagon{
      {-0.6, 1.2, -0.6}, {0.6, 1.2, -0.6}, {0.8, 1.2, 0.3}, {0, 1.2, 0.9}, {-0.8, 1.2, 0.3}};
  const Vec3 aslant(0.6, 0.8, 0);
  Case tilted_triangle = polygon_lamp("triangle_tilted", triangle, {0.1, 0, 0.2}, up);
  tilted_triangle.scene = tilted(tilted_triangle.scene);
  return {
      polygon_lamp("triangle", triangle, {0.1, 0, 0.2}, up), tilted_triangle,
      polygon_lamp("triangle_near", {{-3, 0.2, -2}, {3, 0.2, -2}, {0, 0.2, 4}}, {0.3, 0, 0.1}, up),
      polygon_lamp("triangle_far", {{-0.6, 5, -0.4}, {0.6, 5, -0.4}, {0, 5, 0.8}}, {0, 0, 0}, up),
      // Beside the triangle's edge, 3 % of its size below its plane.
      polygon_lamp("triangle_grazing", {{-0.5, 0.03, 0.1}, {0.5, 0.03, 0.1}, {0, 0.03, 1.1}},
                   {0.1, 0, 0}, {0, 0, 1}),
      polygon_lamp("trapezium", trapezium, {0.1, 0, 0.2}, up),
      polygon_lamp("pentagon", pentagon, {0.1, 0, 0.2}, aslant),
      polygon_lamp("onto_a_lamp", triangle, {0.1, 0, 0.2}, up, 3.0),
      polygon_lamp("onto_a_lamps_back", trapezium, {0.1, 0, 0.2}, aslant, 0.0, 3.0)};
}

// E = pi L sin^2(theta) cos(tilt): the whole sphere is above the horizon.
Case sphere_lamp(const std::string& name, double radius, double distance, double tilt) {
  constexpr double albedo = 0.75;
  Scene scene;
  scene.shapes = {
      parallelogram({-0.5, 0, -0.5}, {0, 0, 1}, {1, 0, 0}, diffuse(albedo)),
      sphere(Vec3(std::sin(tilt), std::cos(tilt), 0) * distance, radius, diffuse(0.0), 1.0)};
  scene.camera = camera({-0.4, 0.03, 0.05}, {0, 0, 0}, pinpoint);
  const double sine = radius / distance;
  return {name, scene, albedo * sine * sine * std::cos(tilt), {1, 1}};
}

// A point that lamps of all kinds light, none before another, each as if it were alone. The
// brightest of all turns its back.
Case lamps_of_all_kinds(const std::string& name, bool is_tilted) {
  const Vec3 x(1, 0, 0), z(0, 0, 1), up(0, 1, 0), point(0, 0, 0);
  const std::vector<Vec3> triangle{{-0.5, 1, -0.4}, {0.6, 1, -0.2}, {0.1, 1, 0.7}};
  Case c = polygon_lamp(name, triangle, point, up);
  const Case alone = rectangle_lamp("", {1.5, 2, -0.5}, x, z, point, up);
  c.scene.shapes.push_back(parallelogram({1.5, 2, -0.5}, x, z, diffuse(0.0), 3.0));
  const Case round = sphere_lamp("", 0.2, 1.5, -0.9);
  c.scene.shapes.push_back(round.scene.shapes.back());
  c.scene.shapes.back().radiance = Rgb(5.0);
  c.scene.shapes.push_back(parallelogram({-0.5, 1, 2}, z, x, diffuse(0.0), 50.0));
  c.radiance += 3.0 * alone.radiance + 5.0 * round.radiance;
  if (is_tilted) c.scene = tilted(c.scene);
  return c;
}

// Every wall emits 1 and reflects a: radiance is 1 + a + a^2 + ... = 1 / (1 - a) everywhere, and a
// perfect mirror in the room shows nothing else.
Case furnace(const std::string& name, double albedo, bool with_mirror) {
  Scene scene;
  scene.shapes = room({-1, -1, -1}, {1, 1.5, 1}, diffuse(albedo), 1.0);
  if (with_mirror) scene.shapes.push_back(sphere({0.2, -0.3, 0.1}, 0.5, mirror(1.0)));
  scene.camera = camera({-0.7, 0.6, -0.8}, {0.2, -0.2, 0.1}, 60.0);
  return {name, scene, 1.0 / (1.0 - albedo), {}};
}

// The same with walls of triangles, and in it lamps of all kinds that reflect as much and emit as
// much: nothing of them is seen. Also tilted, because rounding is not in a world of right angles.
Case crowded_furnace(const std::string& name, double albedo, bool is_tilted) {
  Case c = furnace(name, albedo, true);
  const auto walls = c.scene.shapes;
  c.scene.shapes.clear();
  for (const Shape& wall : walls) {
    const auto* mesh = std::get_if<Mesh>(&wall.geometry);
    if (mesh == nullptr) {
      c.scene.shapes.push_back(wall);
      continue;
    }
    const auto& corners = mesh->front().corners;
    c.scene.shapes.push_back(polygon({corners[0], corners[1], corners[2]}, wall.bsdf, 1.0));
    c.scene.shapes.push_back(polygon({corners[0], corners[2], corners[3]}, wall.bsdf, 1.0));
  }
  const Bsdf bsdf = diffuse(albedo);
  c.scene.shapes.push_back(sphere({-0.6, 1.0, 0.5}, 0.3, bsdf, 1.0));
  c.scene.shapes.push_back(icosphere({0.6, 0.9, 0.5}, 0.3, 0, bsdf, 1.0));
  // A cube that stands on the floor, and one that touches it.
  for (const Vec3& low : {Vec3(-0.9, -1, 0.4), Vec3(-0.5, -1, 0.4)}) {
    for (Shape& side : room(low, low + Vec3(0.4, 0.5, 0.4), bsdf, 1.0)) {
      auto& face = std::get<Mesh>(side.geometry)[0];
      std::reverse(face.corners.begin(), face.corners.end());
      c.scene.shapes.push_back(side);
    }
  }
  if (is_tilted) c.scene = tilted(c.scene);
  c.patience = 5.0;  // between the cubes lamps touch
  return c;
}

// A plate that emits 1 above a diffuse one of the same size: the mean radiance over the lower plate
// is albedo times the form factor of two equal parallel rectangles. The camera sees the lower plate
// exactly, and a pinhole camera in front of a plate samples its area evenly.
Case facing_plates() {
  constexpr double albedo = 0.75;
  const double x = 1.5;  // sides over distance
  const double y = 1.5;
  Scene scene;
  scene.shapes = {parallelogram({-x / 2, 0, -y / 2}, {0, 0, y}, {x, 0, 0}, diffuse(albedo)),
                  parallelogram({-x / 2, 1, -y / 2}, {x, 0, 0}, {0, 0, y}, diffuse(0.0), 1.0)};
  scene.camera = camera({0, 0.9, 0}, {0, 0, 0}, 2.0 * std::atan(x / 2 / 0.9) * 180.0 / pi);
  const double rx = std::sqrt(1 + x * x);
  const double ry = std::sqrt(1 + y * y);
  const double factor =
      2 / (pi * x * y) *
      (std::log(rx * ry / std::sqrt(1 + x * x + y * y)) + x * ry * std::atan(x / ry) +
       y * rx * std::atan(y / rx) - x * std::atan(x) - y * std::atan(y));
  return {"facing_plates", scene, albedo * factor, {1, 1}};
}

// A lamp of radius r in the middle of a white sphere of radius R, with the albedos b and a. All of
// the sphere is lit the same, and sees the lamp under f = (r / R)^2 of its hemisphere, and the lamp
// sees nothing but the sphere, so w = a (f (1 + b w) + (1 - f) w): w = a f / (1 - a (1 - f + f b)).
Case integrating_sphere(const std::string& name, double lamp_albedo, bool two_sided) {
  constexpr double albedo = 0.8;
  Scene scene;
  scene.shapes = {sphere({0, 0, 0}, 2.0, diffuse(albedo, true)),
                  sphere({0, 0, 0}, 0.5, diffuse(lamp_albedo, two_sided), 1.0)};
  scene.camera = camera({0.9, 0.3, -0.8}, {1.8, 0.2, -1}, 30.0);
  const double f = 0.25 * 0.25;
  return {name, scene, albedo * f / (1 - albedo * (1 - f + f * lamp_albedo)), {}};
}

std::vector<Case> cases() {
  std::vector<Case> all = rectangle_lamps();
  for (const Case& c : polygon_lamps()) all.push_back(c);
  all.push_back(sphere_lamp("sphere_above", 0.5, 2.0, 0.0));
  all.push_back(sphere_lamp("sphere_aslant", 0.5, 1.2, 1.0));
  all.push_back(sphere_lamp("sphere_near", 1.0, 1.02, 0.1));
  all.push_back(lamps_of_all_kinds("lamps_of_all_kinds", false));
  all.push_back(lamps_of_all_kinds("lamps_of_all_kinds_tilted", true));
  all.push_back(furnace("furnace_50", 0.5, false));
  all.push_back(furnace("furnace_95", 0.95, false));
  all.push_back(furnace("furnace_80_with_mirror", 0.8, true));
  all.push_back(facing_plates());
  all.push_back(integrating_sphere("integrating_sphere", 0.0, false));
  all.push_back(integrating_sphere("integrating_sphere_with_white_lamp", 0.9, true));
  all.push_back(crowded_furnace("crowded_furnace", 0.8, false));
  all.push_back(crowded_furnace("crowded_furnace_tilted", 0.6, true));
  return all;
}

using Combination = std::tuple<Method, Sampler, Precision>;

class ClosedForm : public testing::TestWithParam<std::tuple<Combination, int>> {};

TEST_P(ClosedForm, IsMetWithinFourStandardErrors) {
  const auto& [combination, number] = GetParam();
  const auto& [method, sampler, precision] = combination;
  const Case c = cases()[size_t(number)];
  const Settings settings{.method = method,
                          .sampler = sampler,
                          .precision = precision,
                          .seed = 1,
                          .bounces = c.bounces};
  const double slow = method == Method::plain ? 3e-3 : 1e-3;
  const bool is_sampled = method == Method::nee || method == Method::mis;
  const double wanted = (is_sampled ? 2e-4 : slow) * c.patience;
  const Measurement m = measure_until(c.scene, settings, wanted);
  EXPECT_LE(m.standard_error, wanted * m.mean) << c.name;
  EXPECT_NEAR(m.mean, c.radiance, 4.0 * m.standard_error + 1e-6 * c.radiance)
      << c.name << ": " << (m.mean / c.radiance - 1.0) * 100.0 << " % off, standard error "
      << m.standard_error / c.radiance * 100.0 << " %";
}

std::string name_of(const testing::TestParamInfo<ClosedForm::ParamType>& info) {
  const auto& [combination, number] = info.param;
  const auto& [method, sampler, precision] = combination;
  const char* methods[] = {"bsdf", "nee", "mis", "plain"};
  return std::string(methods[int(method)]) +
         (sampler == Sampler::sobol ? "_sobol" : "_independent") +
         (precision == Precision::float32 ? "_float_" : "_double_") + cases()[size_t(number)].name;
}

INSTANTIATE_TEST_SUITE_P(
    All, ClosedForm,
    testing::Combine(testing::Combine(testing::Values(Method::bsdf, Method::nee, Method::mis),
                                      testing::Values(Sampler::independent, Sampler::sobol),
                                      testing::Values(Precision::float32, Precision::float64)),
                     testing::Range(0, static_cast<int>(cases().size()))),
    name_of);

INSTANTIATE_TEST_SUITE_P(Plain, ClosedForm,
                         testing::Combine(testing::Values(Combination(Method::plain,
                                                                      Sampler::independent,
                                                                      Precision::float64)),
                                          testing::Range(0, static_cast<int>(cases().size()))),
                         name_of);

const Settings plain{.method = Method::plain,
                     .sampler = Sampler::independent,
                     .precision = Precision::float64,
                     .bounces = {}};

// A convex lamp that reflects lights nothing of itself, and nothing else is there: it looks as it
// emits on its front, and black on its back. Another lamp in its plane does not light it, either.
TEST(ConvexLamp, LooksAsItEmits) {
  const Bsdf white = diffuse(0.9, true);
  Scene plates;
  plates.shapes = {parallelogram({-9, -9, 0}, {9, 0, 0}, {0, 18, 0}, white, 2.0),
                   polygon({{0, -9, 0}, {9, -9, 0}, {9, 9, 0}}, white, 2.0),
                   polygon({{0, -9, 0}, {9, 9, 0}, {0, 9, 0}}, white, 2.0)};
  Scene cube, ball, facets;
  for (Shape& side : room({-1, -1, -1}, {1, 1, 1}, white, 2.0)) {
    auto& face = std::get<Mesh>(side.geometry)[0];
    std::reverse(face.corners.begin(), face.corners.end());
    cube.shapes.push_back(side);
  }
  ball.shapes = {sphere({0, 0, 0}, 1.0, white, 2.0)};
  facets.shapes = {icosphere({0, 0, 0}, 1.0, 2, white, 2.0)};
  for (Scene scene : {plates, cube, ball, facets}) {
    for (const bool is_outside : {true, false}) {
      // Through the inside of a closed lamp its backs are seen.
      const bool is_flat = scene.shapes[0].id == "parallelogram" && scene.shapes.size() == 3;
      const Vec3 eye = is_outside ? Vec3(0.4, 0.5, 2.2) : is_flat ? Vec3(0, 0, -2) : Vec3(0, 0, 0);
      scene.camera = camera(eye, {0.1, 0.1, 0}, is_outside ? 20.0 : 100.0);
      for (const Method method : {Method::bsdf, Method::nee, Method::mis}) {
        for (const Precision precision : {Precision::float32, Precision::float64}) {
          const Settings settings{.method = method, .precision = precision, .bounces = {}};
          const std::vector<float> mean = render_film(tilted(scene), settings, {0, 64}).mean();
          const float expected = is_outside ? 2.0f : 0.0f;
          EXPECT_EQ(mean, std::vector<float>(mean.size(), expected))
              << scene.shapes[0].id << int(method) << int(precision) << is_outside;
        }
      }
      // The plain path tracer does not know that a surface can't light itself: its light passes the
      // lamp's plane by rounding alone.
      for (const float value : render_film(tilted(scene), plain, {0, 4}).mean()) {
        EXPECT_NEAR(value, is_outside ? 2.0f : 0.0f, 1e-20f) << scene.shapes[0].id;
      }
    }
  }
}

// A furnace shines the same everywhere inside, also where a camera outside looks into it through
// the backs of its walls. Without that it sees the backs, which are black.
TEST(Furnace, ShinesThroughTheBacksOfItsWalls) {
  Case c = furnace("furnace_from_outside", 0.5, true);
  c.scene.camera = camera({-3.0, 3.5, -4.0}, {0.0, 0.2, 0.0}, 14.0);
  for (const bool is_tilted : {false, true}) {
    Scene scene = is_tilted ? tilted(c.scene) : c.scene;
    for (const Precision precision : {Precision::float32, Precision::float64}) {
      for (const Method method : {Method::bsdf, Method::nee, Method::mis}) {
        for (const Sampler sampler : {Sampler::independent, Sampler::sobol}) {
          const Settings settings{.method = method,
                                  .sampler = sampler,
                                  .precision = precision,
                                  .seed = 1,
                                  .bounces = {}};
          scene.camera.sees_through_backs = false;
          const std::vector<float> backs = render_film(scene, settings, {0, 16}).mean();
          EXPECT_EQ(backs, std::vector<float>(backs.size(), 0.0f));
          scene.camera.sees_through_backs = true;
          const Film film = render_film(scene, settings, {0, 4096});
          const Measurement m = measure(film);
          EXPECT_LE(m.standard_error, 1e-3 * c.radiance);
          EXPECT_NEAR(m.mean, c.radiance, 4.0 * m.standard_error + 1e-6 * c.radiance);
          // No pixel is left out: each is within seven standard errors of a pixel, all of them
          // known together, because four replicates tell little of one.
          const std::vector<float> mean = film.mean();
          const double pixel = m.standard_error * std::sqrt(static_cast<double>(mean.size()) / 3.0);
          for (const float value : mean) EXPECT_NEAR(value, c.radiance, 7.0 * pixel);
        }
      }
    }
  }
}

TEST(UnlitScene, IsExactlyBlack) {
  Scene scene;
  scene.shapes = room({-1, -1, -1}, {1, 1, 1}, diffuse(0.9));
  scene.shapes.push_back(sphere({0, 0, 0}, 0.3, mirror(0.9)));
  scene.camera = camera({-0.7, 0.6, -0.8}, {0, 0, 0}, 60.0);
  std::vector<Settings> all{plain};
  for (const Method method : {Method::bsdf, Method::nee, Method::mis}) {
    all.push_back({.method = method, .bounces = {}});
  }
  for (const Settings& settings : all) {
    const Film film = render_film(scene, settings, {0, 64});
    EXPECT_EQ(film.mean(), std::vector<float>(film.mean().size(), 0.0f));
    EXPECT_EQ(film.variance(), std::vector<float>(film.mean().size(), 0.0f));
  }
}

TEST(EmptyScene, IsExactlyBlack) {
  Scene scene;
  scene.camera = camera({0, 0, 0}, {0, 0, 1}, 60.0);
  const Film film = render_film(scene, {.bounces = {}}, {0, 8});
  EXPECT_EQ(film.mean(), std::vector<float>(film.mean().size(), 0.0f));
}

TEST(Lambert, AgreesWithTheFactorOfAParallelRectangleOverItsCorner) {
  const double x = 0.7;  // sides over height
  const double y = 1.9;
  const double rx = std::sqrt(1 + x * x);
  const double ry = std::sqrt(1 + y * y);
  const double factor = (x / rx * std::atan(y / rx) + y / ry * std::atan(x / ry)) / (2 * pi);
  const std::vector<Vec3> lamp{{0, 1, 0}, {x, 1, 0}, {x, 1, y}, {0, 1, y}};
  EXPECT_NEAR(lambert(lamp, {0, 0, 0}, {0, 1, 0}), pi * factor, 1e-14);
}

}  // namespace
}  // namespace plumb::test
