// SPDX-License-Identifier: Apache-2.0

// Which scenes' lamps are better left to chance.
#include "scene_files/method.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <string>

#include "scene_files/scene_reader.h"
#include "tests/test_scenes.h"

namespace plumb::test {
namespace {

namespace fs = std::filesystem;

// That `bsdf` is the best method there is told by docs/stability.md.
TEST(Chance, SufficesWhereNothingButLampsEndsPaths) {
  const std::set<std::string> all{"coplanar", "corner_camera", "long_paths",   "mirror_bowl",
                                  "needle",   "touching_box",  "white_opening"};
  std::set<std::string> found;
  for (const char* folder : {"cornell", "seed", "stress", "stress/easy"}) {
    for (const auto& entry : fs::directory_iterator(fs::path(PLUMB_SCENES) / folder)) {
      if (entry.path().extension() != ".xml") continue;
      const Scene scene = read_scene(entry.path().string());
      if (chance_suffices(scene)) found.insert(scene.name);
    }
  }
  EXPECT_EQ(found, all);
}

// A room of white walls one of which ends all paths as a lamp, seen from inside.
Scene white_room() {
  Scene scene;
  scene.shapes = room({-1, -1, -1}, {1, 1, 1}, diffuse(1.0));
  scene.shapes[4].bsdf = diffuse(0.0);
  scene.shapes[4].radiance = Rgb(1.0);
  scene.camera = camera({0, 0, 0}, {0, 0, 1}, 60.0);
  return scene;
}

TEST(Chance, DoesNotSufficeWhereALampIsSmallOrPartOfThePictureIsBlack) {
  EXPECT_TRUE(chance_suffices(white_room()));
  Scene with_small_lamp = white_room();
  with_small_lamp.shapes.push_back(
      parallelogram({-0.1, 0.9, -0.1}, {0.2, 0, 0}, {0, 0, 0.2}, diffuse(0.0), 1e4));
  EXPECT_FALSE(chance_suffices(with_small_lamp));
  Scene from_far = white_room();
  from_far.camera.origin = {0, 0, -20};
  EXPECT_FALSE(chance_suffices(from_far));
}

TEST(Chance, HasNothingToFindWithoutLamps) {
  Scene dark = white_room();
  for (Shape& shape : dark.shapes) shape.radiance = Rgb(0.0);
  EXPECT_FALSE(chance_suffices(dark));
}

}  // namespace
}  // namespace plumb::test
