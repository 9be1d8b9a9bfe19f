// SPDX-License-Identifier: Apache-2.0

#include "scene/light_origin.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include "light_origins/trace_selected.h"
#include "radiosity/radiosity.h"
#include "scene_files/scene_reader.h"
#include "tests/test_scenes.h"

namespace plumb {
namespace {

using test::diffuse;
using test::parallelogram;
using Way = LightOrigin::Way;
using Ids = std::vector<std::string>;

Scene small(const std::string& name) {
  Scene scene = read_scene(std::string(PLUMB_SCENES "/") + name + "/scene.xml");
  scene.camera.width = scene.camera.height = 24;
  return scene;
}

Ids ids_of(const Scene& scene) {
  Ids ids;
  for (const Shape& shape : scene.shapes) ids.push_back(shape.id);
  return ids;
}

Film draw(const Scene& scene, Settings settings, Way way, const Ids& ids) {
  const LightOrigin origin = light_origin(scene, way, ids);
  select_light(origin, settings);
  return test::render_film(scene, settings, {0, 16});
}

Film draw(const Scene& scene, const Settings& settings) {
  return test::render_film(scene, settings, {0, 16});
}

// Where lamps are sampled by way of mirrors, light that does not count has a part in what is
// chosen.
void expect_same_within_noise(const Film& a, const Film& b) {
  const test::Measurement x = test::measure(a), y = test::measure(b);
  EXPECT_NEAR(x.mean, y.mean, 5.0 * std::hypot(x.standard_error, y.standard_error));
}

// Up to the rounding of float sums.
void expect_same(const std::vector<float>& a, const std::vector<float>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], 1e-5 * (1.0 + double{b[i]})) << i;
}

using HowParam = std::tuple<std::string, Method, Sampler, Precision>;

class LightOrigins : public testing::TestWithParam<HowParam> {
 protected:
  Scene scene = small(std::get<0>(GetParam()));
  Settings settings{.method = std::get<1>(GetParam()),
                    .sampler = std::get<2>(GetParam()),
                    .precision = std::get<3>(GetParam()),
                    .bounces = {}};

  void compare(const Film& a, const Film& b) const {
    if (scene.name == "cornell") {
      expect_same(a.mean(), b.mean());
    } else {
      expect_same_within_noise(a, b);
    }
  }
};

TEST_P(LightOrigins, OfAllShapesAddUpToTheWhole) {
  const std::vector<float> whole = draw(scene, settings).mean();
  std::vector<float> sum(whole.size(), 0.0F);
  for (const std::string& id : ids_of(scene)) {
    const std::vector<float> part = draw(scene, settings, Way::last, {id}).mean();
    for (size_t i = 0; i < sum.size(); ++i) sum[i] += part[i];
  }
  expect_same(sum, whole);
  expect_same(draw(scene, settings, Way::last, ids_of(scene)).mean(), whole);
}

// Of black lamps, what comes straight from them is direct light, and the lamp itself.
TEST_P(LightOrigins, OfLampsAreDirectLight) {
  Ids lamps;
  for (const Shape& shape : scene.shapes) {
    if (shape.is_lamp()) lamps.push_back(shape.id);
  }
  const Film from_lamps = draw(scene, settings, Way::last, lamps);
  settings.bounces = {.first = 0, .last = 1};
  compare(from_lamps, draw(scene, settings));
}

TEST_P(LightOrigins, OfEveryReflectionAreTwoBouncesAndMore) {
  const Film reflected = draw(scene, settings, Way::any, ids_of(scene));
  settings.bounces = {.first = 2};
  compare(reflected, draw(scene, settings));
}

// There, one surface lies between lamp and what is seen.
TEST_P(LightOrigins, OfTwoBouncesAreTheSameEitherWay) {
  settings.bounces = {.first = 2, .last = 2};
  for (const std::string& id : ids_of(scene)) {
    expect_same(draw(scene, settings, Way::any, {id}).mean(),
                draw(scene, settings, Way::last, {id}).mean());
  }
}

std::string name_of(const testing::TestParamInfo<HowParam>& info) {
  const auto& [scene, method, sampler, precision] = info.param;
  constexpr const char* methods[] = {"Bsdf", "Nee", "Mis"};
  return scene + methods[static_cast<int>(method)] +
         (sampler == Sampler::sobol ? "Sobol" : "Independent") +
         (precision == Precision::float32 ? "Float" : "Double");
}

INSTANTIATE_TEST_SUITE_P(Any, LightOrigins,
                         testing::Combine(testing::Values("cornell", "seed", "spheres", "metals"),
                                          testing::Values(Method::bsdf, Method::nee, Method::mis),
                                          testing::Values(Sampler::independent, Sampler::sobol),
                                          testing::Values(Precision::float32, Precision::float64)),
                         name_of);

// A cube of side 2 whose walls all shine with radiance 1 and reflect a half of what comes, so that
// the radiance is 2 everywhere. The camera sees the middle of the floor. What comes from a wall is
// its form factor from there: for the ceiling that of four rectangles, a corner of each of which is
// above.
TEST(LightOriginInAFurnace, IsAsMuchAsTheFormFactor) {
  Scene scene;
  scene.camera = test::camera({0, 0, 0}, {0, 0, -1}, 0.1);
  scene.camera.width = scene.camera.height = 1;
  const auto wall = [&](const char* id, const Vec3& corner, const Vec3& a, const Vec3& b) {
    scene.shapes.push_back(parallelogram(corner, a, b, diffuse(0.5), 1.0));
    scene.shapes.back().id = id;
  };
  wall("floor", {-1, -1, -1}, {2, 0, 0}, {0, 2, 0});
  wall("ceiling", {-1, -1, 1}, {0, 2, 0}, {2, 0, 0});
  wall("left", {-1, -1, -1}, {0, 2, 0}, {0, 0, 2});
  wall("right", {1, -1, -1}, {0, 0, 2}, {0, 2, 0});
  wall("front", {-1, -1, -1}, {0, 0, 2}, {2, 0, 0});
  wall("back", {-1, 1, -1}, {2, 0, 0}, {0, 0, 2});

  // The ratio of a side to the height is a half (Howell's catalogue of configuration factors, B-3).
  const double root = std::sqrt(1.25);
  const double ceiling =
      4.0 * (2.0 * 0.5 / root * std::atan(0.5 / root)) / (2.0 * std::numbers::pi);
  const double side = (1.0 - ceiling) / 4.0;
  for (const Method method : {Method::bsdf, Method::nee, Method::mis}) {
    const auto check = [&](const Ids& ids, double expected) {
      const LightOrigin origin = light_origin(scene, Way::last, ids);
      Settings settings{.method = method, .bounces = {}};
      select_light(origin, settings);
      Film film = test::render_film(scene, settings, {0, int64_t{1} << 18});
      const test::Measurement result = test::measure(film);
      EXPECT_NEAR(result.mean, expected, 4.0 * result.standard_error + 1e-5) << ids[0];
      EXPECT_LT(result.standard_error, 2e-3);
    };
    check({"ceiling"}, ceiling);
    check({"left"}, side);
    check({"front", "back"}, 2.0 * side);
    check({"floor"}, 1.0);  // its own emission
  }
}

// Radiosity has no samples and no paths.
class LightOriginOfShapes : public testing::TestWithParam<std::tuple<const char*, Way>> {};

TEST_P(LightOriginOfShapes, IsTheSameByRadiosity) {
  const auto& [name, way] = GetParam();
  const Scene scene = small(name);
  const radiosity::Work quiet{[](const std::string&) {}, nullptr};
  for (const char* id : {"left_wall", "floor", "lamp"}) {
    const LightOrigin origin = light_origin(scene, way, {id});
    const radiosity::Picture exact = radiosity::draw(
        scene, {.bounces = {}, .origin = &origin, .level = 1, .most_bytes = size_t{1} << 30},
        quiet);
    double mean = 0.0;
    for (const float value : exact.rgb) mean += double{value} / double(exact.rgb.size());
    Settings settings{.bounces = {}};
    select_light(origin, settings);
    const test::Measurement noisy = test::measure(test::render_film(scene, settings, {0, 1024}));
    EXPECT_NEAR(noisy.mean, mean, 4.0 * noisy.standard_error + 1e-3 * mean) << id;
    EXPECT_LE(noisy.standard_error, 0.02 * mean) << id;
  }
}

INSTANTIATE_TEST_SUITE_P(Any, LightOriginOfShapes,
                         testing::Combine(testing::Values("cornell"),
                                          testing::Values(Way::last, Way::any)));

TEST(LightOrigin, KnowsTheShapesOfTheScene) {
  const Scene scene = small("cornell");
  EXPECT_THROW(light_origin(scene, Way::last, {"lefty"}), std::invalid_argument);
  const LightOrigin origin = light_origin(scene, Way::any, {"floor", "lamp"});
  EXPECT_EQ(std::ranges::count(origin.has_shape, 1), 2);
}

TEST(LightOrigin, IsNotKnownToThePlainPathTracer) {
  const Scene scene = small("cornell");
  EXPECT_THROW(draw(scene,
                    {.method = Method::plain,
                     .sampler = Sampler::independent,
                     .precision = Precision::float64,
                     .bounces = {}},
                    Way::last, {"floor"}),
               std::invalid_argument);
}

}  // namespace
}  // namespace plumb
