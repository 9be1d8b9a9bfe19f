// SPDX-License-Identifier: Apache-2.0

// What regions of a picture are called, and which pixels they have.
#include "scene_files/region_mask.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "scene_files/scene_reader.h"
#include "test_scenes.h"

namespace plumb {
namespace {

using test::diffuse;
using test::parallelogram;
using test::sphere;

// A floor seen from straight above, 2 x 2 in a picture of 4 x 4.
Scene floor_from_above(int size) {
  Scene scene;
  scene.camera = test::camera(Vec3(0, 10, 0), Vec3(0, 0, 0), 2 * std::atan(0.2) * 180 / M_PI, size);
  scene.shapes = {parallelogram(Vec3(-1, 0, 1), Vec3(2, 0, 0), Vec3(0, 0, -2), diffuse(0.5))};
  scene.shapes[0].id = "floor";
  return scene;
}

std::string region_at(const Scene& scene, const RegionMask& mask, int x, int y) {
  const int region = mask.regions[size_t(y) * size_t(scene.camera.width) + size_t(x)];
  return region < 0 ? "" : mask.names[size_t(region)];
}

std::set<std::string> names(const RegionMask& mask) {
  return {mask.names.begin(), mask.names.end()};
}

TEST(RegionMask, HasThePixelsThatSeeOneShapeOnly) {
  // 10 pixels for 4 units: the floor's edges run through the middle of pixels 2 and 7.
  const Scene scene = floor_from_above(10);
  const RegionMask mask = region_mask(scene, RegionKind::object);
  for (int y = 0; y < 10; ++y) {
    for (int x = 0; x < 10; ++x) {
      const bool is_inside = std::min(x, y) >= 3 && std::max(x, y) <= 6;
      EXPECT_EQ(region_at(scene, mask, x, y), is_inside ? "floor" : "") << x << ", " << y;
    }
  }
}

TEST(RegionMask, TellsTheNearerShape) {
  Scene scene = floor_from_above(10);
  scene.shapes.push_back(sphere(Vec3(0, 1, 0), 0.9, diffuse(0.5)));
  scene.shapes.back().id = "ball";
  EXPECT_EQ(region_at(scene, region_mask(scene, RegionKind::object), 5, 5), "ball");
}

TEST(RegionMask, NamesTheSidesOfSolidsAsTheCameraLooksAtThem) {
  const Scene scene = read_scene(PLUMB_SCENES "/cornell/scene.xml");
  EXPECT_EQ(names(region_mask(scene, RegionKind::side)),
            (std::set<std::string>{"back_wall", "ceiling", "floor", "lamp", "left_wall",
                                   "right_wall", "short_block front", "short_block right",
                                   "short_block top", "tall_block front", "tall_block left"}));
  EXPECT_EQ(names(region_mask(scene, RegionKind::object)),
            (std::set<std::string>{"back_wall", "ceiling", "floor", "lamp", "left_wall",
                                   "right_wall", "short_block", "tall_block"}));
}

TEST(RegionMask, OfAWindowHasTheRegionsAndNumbersOfTheWholeOne) {
  Scene scene = read_scene(PLUMB_SCENES "/cornell/scene.xml");
  scene.camera.width = scene.camera.height = 32;
  const Window window{17, 12, 9, 14};  // sees neither the left wall nor the lamp
  for (const RegionKind kind : {RegionKind::object, RegionKind::side, RegionKind::shadow}) {
    const RegionMask whole = region_mask(scene, kind), part = region_mask(scene, kind, window);
    EXPECT_LT(part.names.size(), whole.names.size() + (kind == RegionKind::shadow ? 1 : 0));
    for (int y = 0; y < window.height; ++y) {
      for (int x = 0; x < window.width; ++x) {
        const int there = whole.regions[size_t((window.y + y) * 32 + window.x + x)];
        const int here = part.regions[size_t(y * window.width + x)];
        ASSERT_EQ(here < 0, there < 0);
        if (here < 0) continue;
        EXPECT_EQ(part.names[size_t(here)], whole.names[size_t(there)]);
        EXPECT_EQ(part.numbers[size_t(here)], whole.numbers[size_t(there)]);
      }
    }
  }
}

TEST(RegionMask, TellsLightPenumbraAndUmbra) {
  // A lamp from x = -0.5 to 0.5 at a height of 2; at half of it, a blind that covers all x > 0.
  Scene scene = floor_from_above(64);
  scene.shapes.push_back(
      parallelogram(Vec3(-0.5, 2, -0.5), Vec3(1, 0, 0), Vec3(0, 0, 1), diffuse(0), 1.0));
  scene.shapes.push_back(
      parallelogram(Vec3(0, 1, -9), Vec3(9, 0, 0), Vec3(0, 0, 18), diffuse(0, true)));
  // From below the blind and beside the lamp.
  scene.camera = test::camera(Vec3(0, 0.5, 0), Vec3(0, 0, 0), 2 * std::atan(2.0) * 180 / M_PI, 64);
  const RegionMask mask = region_mask(scene, RegionKind::shadow);
  for (int x = 1; x < 63; ++x) {
    // The image's width is 2 units of the floor.
    const double right = scene.camera.right.x;
    const double low = std::min(right * ((x + 0.0) / 32.0 - 1), right * ((x + 1.0) / 32.0 - 1));
    const double high = low + 1.0 / 32.0;
    const std::string region = region_at(scene, mask, x, 32);
    if (high < -0.5) {
      EXPECT_EQ(region, "lit") << x;
    }
    if (low > -0.5 && high < 0.5) {
      EXPECT_EQ(region, "penumbra") << x;
    }
    if (low > 0.5) {
      EXPECT_EQ(region, "umbra") << x;
    }
  }
}

}  // namespace
}  // namespace plumb
