// SPDX-License-Identifier: Apache-2.0

// Which scenes want double. That float's pictures of the others are right, and those of the ones
// that are listed here wrong, is what stress_test.cpp and docs/stability.md tell.
#include "scene_files/precision.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <string>

#include "renderer/packed_scene.h"
#include "scene_files/scene_reader.h"
#include "tests/test_scenes.h"

namespace plumb::test {
namespace {

namespace fs = std::filesystem;

TEST(Precision, IsDoubleForTheStressScenesThatFloatGetsWrongAndForNoOther) {
  const std::set<std::string> wrong{"edge_on_lamp", "edge_pixel", "gap", "giant_sphere",
                                    "grazing_lamp"};
  std::set<std::string> found;
  for (const char* folder : {"cornell", "seed", "spheres", "metals", "stress", "stress/easy"}) {
    for (const auto& entry : fs::directory_iterator(fs::path(PLUMB_SCENES) / folder)) {
      if (entry.path().extension() != ".xml") continue;
      const Scene scene = read_scene(entry.path().string());
      if (!needs_double(scene).empty()) found.insert(scene.name);
    }
  }
  EXPECT_EQ(found, wrong);
}

constexpr double g = 1e-6;  // some 0.7 to 1.8 times float_growth() of the scenes below

// A floor and, at its edge, a shorter plate at any angle to it.
Scene plates(double gap, const Vec3& plate) {
  Scene scene;
  scene.shapes = {parallelogram({-1, 0, -0.4}, {0, 0, 0.8}, {1, 0, 0}, diffuse(0.5)),
                  parallelogram({gap, 0, -0.3}, {0, 0, 0.6}, plate, diffuse(0.5))};
  scene.camera = camera({-0.3, 1, 0}, {-0.3, 0, 0}, 60.0);
  return scene;
}

TEST(Precision, IsDoubleForGapsThatAreAFewGrowthsWide) {
  for (const Vec3& plate : {Vec3(0.6, 0, 0), Vec3(0.3, 0.5, 0), Vec3(0, 0.5, 0)}) {
    const auto is_double = [&](double gap) {
      Scene scene = plates(gap, plate);
      const std::string need = needs_double(scene);
      EXPECT_EQ(need.empty(), need.find("the gap between") == std::string::npos) << need;
      EXPECT_EQ(needs_double(tilted(scene)), need);
      return !need.empty();
    };
    for (const double none : {-0.01, 0.0, 5 * g, 1500 * g}) {
      EXPECT_FALSE(is_double(none)) << none / g;
    }
    for (const double gap : {20 * g, 100 * g, 500 * g}) EXPECT_TRUE(is_double(gap)) << gap / g;
  }
}

// As under a glass block that stands on a floor: see scene_files/air_gap.h.
TEST(Precision, IsFloatForGapsBesideGlass) {
  Scene scene = plates(100 * g, {0.6, 0, 0});
  scene.shapes[1].bsdf = glass(1.5);
  EXPECT_EQ(needs_double(scene), "");
}

TEST(Precision, IsFloatForWhatLiesOnOrHangsBeforeSomething) {
  for (const double height : {-100 * g, 0.0, 20 * g, 100 * g, 700 * g}) {
    Scene scene;
    scene.shapes = room({-1, -1, -1}, {1, 1, 1}, diffuse(0.5));
    scene.shapes.push_back(
        parallelogram({-0.3, 1 - height, -0.3}, {0.6, 0, 0}, {0, 0, 0.6}, diffuse(0.0), 1.0));
    scene.shapes.push_back(sphere({0.2, -0.5 + height, 0.2}, 0.5, diffuse(0.5)));
    scene.camera = camera({0, 0, -0.9}, {0, 0, 1}, 60.0);
    EXPECT_EQ(needs_double(scene), "") << height / g;
  }
}

TEST(Precision, IsDoubleForSilhouettesInANarrowView) {
  Scene scene;
  scene.shapes = {parallelogram({0, -1, 0}, {0, 2, 0}, {1, 0, 0}, diffuse(0.5), 1.0)};
  const auto is_double = [&](double fov, double x) {
    scene.camera = camera({x, 0, -1}, {x, 0, 0}, fov);
    return !needs_double(scene).empty();
  };
  EXPECT_FALSE(is_double(40.0, 0.0));
  EXPECT_TRUE(is_double(5.0, 0.0));
  EXPECT_FALSE(is_double(5.0, 0.5));  // no edge in view
}

TEST(Precision, OfNothingIsFloat) {
  Scene scene;
  scene.camera = camera({0, 0, 0}, {0, 0, 1}, 60.0);
  EXPECT_EQ(needs_double(scene), "");
}

}  // namespace
}  // namespace plumb::test
