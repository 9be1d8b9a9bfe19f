// SPDX-License-Identifier: Apache-2.0

// The same scene, seed, method and samples give the same bits.
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <string>
#include <vector>

#include "renderer/trace.h"
#include "scene_files/scene_reader.h"
#include "tests/test_scenes.h"

namespace plumb::test {
namespace {

// A reference scene, or the Cornell box with a Gaussian filter and, in it, a lamp and a mirror that
// are meshes below a tree.
Scene small(const std::string& name) {
  const bool has_trees = name == "trees";
  Scene scene =
      read_scene(std::string(PLUMB_SCENES "/") + (has_trees ? "cornell" : name) + "/scene.xml");
  if (has_trees) {
    scene.shapes.push_back(icosphere({180, 400, 200}, 60, 2, diffuse(0.5), 3.0));
    scene.shapes.push_back(icosphere({400, 420, 250}, 80, 2, mirror(0.9)));
    scene.camera.filter = {Filter::Kind::gaussian, 0.5};
  }
  scene.camera.width = 50;  // not a multiple of any vector's lanes
  scene.camera.height = 37;
  return scene;
}

std::vector<Settings> all_settings() {
  std::vector<Settings> all;
  for (const Method method : {Method::bsdf, Method::nee, Method::mis}) {
    for (const Sampler sampler : {Sampler::independent, Sampler::sobol}) {
      for (const Precision precision : {Precision::float32, Precision::float64}) {
        all.push_back({.method = method,
                       .sampler = sampler,
                       .precision = precision,
                       .seed = 5,
                       .bounces = {}});
      }
    }
  }
  all.push_back({.method = Method::plain,
                 .sampler = Sampler::independent,
                 .precision = Precision::float64,
                 .seed = 5,
                 .bounces = {}});
  return all;
}

TEST(Determinism, WhichOtherPixelsAreDrawnDoesNotMatter) {
  const Window window{13, 4, 21, 30};
  for (const char* name : {"cornell", "seed", "trees"}) {
    for (const Settings& settings : all_settings()) {
      const Scene scene = small(name);
      const std::vector<float> whole = render_film(scene, settings, {0, 10}).mean();
      Film film(window);
      render(scene, settings, {.samples = {0, 10}}, film);
      const std::vector<float> crop = film.mean();
      for (int64_t i = 0; i < film.pixel_count(); ++i) {
        const auto pixel = window.number_in_picture(i, scene.camera.width);
        for (size_t c = 0; c < 3; ++c) {
          ASSERT_EQ(crop[size_t(i) * 3 + c], whole[size_t(pixel) * 3 + c]) << name << " " << i;
        }
      }
    }
  }
}

TEST(Determinism, TheNumberOfThreadsDoesNotMatter) {
  for (const char* name : {"cornell", "seed", "trees"}) {
    for (Settings settings : all_settings()) {
      settings.threads = 1;
      const Film one = render_film(small(name), settings, {0, 10});
      for (const int threads : {2, 3}) {
        settings.threads = threads;
        const Film several = render_film(small(name), settings, {0, 10});
        EXPECT_EQ(one.mean(), several.mean());
        EXPECT_EQ(one.variance(), several.variance());
      }
    }
  }
}

// Restores the choice of instruction set at the end of a test.
class Targets : public testing::Test {
 protected:
  ~Targets() override { hwy::SetSupportedTargetsForTest(0); }

  static void use(int64_t target) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().DeInit();
  }
};

TEST_F(Targets, WithFusedMultiplyAddGiveTheSameBits) {
  std::vector<int64_t> fused;
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    if ((target & (HWY_SSE4 | HWY_SSSE3 | HWY_SCALAR)) == 0) fused.push_back(target);
  }
  ASSERT_FALSE(fused.empty());
  if (fused.size() == 1) GTEST_SKIP() << "only " << hwy::TargetName(fused[0]) << " here";
  for (const char* name : {"cornell", "seed", "trees"}) {
    for (const Settings& settings : all_settings()) {
      use(fused[0]);
      const Film first = render_film(small(name), settings, {0, 10});
      EXPECT_STREQ(trace_target(), hwy::TargetName(fused[0]));
      for (const int64_t target : fused) {
        use(target);
        EXPECT_EQ(first.mean(), render_film(small(name), settings, {0, 10}).mean())
            << hwy::TargetName(fused[0]) << " and " << hwy::TargetName(target);
      }
    }
  }
}

TEST_F(Targets, WithoutFusedMultiplyAddDifferByRoundingOnly) {
  const Settings settings{.precision = Precision::float64, .bounces = {}};
  const Film usual = render_film(small("cornell"), settings, {0, 64});
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    use(target);
    const Film other = render_film(small("cornell"), settings, {0, 64});
    const std::vector<float> a = usual.mean();
    const std::vector<float> b = other.mean();
    for (size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-6) << hwy::TargetName(target);
  }
}

TEST(Determinism, PassesDoNotMatter) {
  for (const Settings& settings : all_settings()) {
    const Scene scene = small("cornell");
    Film parts(scene.camera.width, scene.camera.height);
    for (const SampleRange samples : {SampleRange{0, 7}, {7, 8}, {8, 64}, {64, 128}}) {
      render(scene, settings, {.samples = samples}, parts);
    }
    EXPECT_EQ(parts.mean(), render_film(scene, settings, {0, 128}).mean());
    EXPECT_EQ(parts.variance(), render_film(scene, settings, {0, 128}).variance());
  }
}

TEST(Determinism, LookingThroughBacksDoesNotMatterWhereNoneIsInTheWay) {
  for (const char* name : {"cornell", "seed"}) {
    for (const Settings& settings : all_settings()) {
      Scene scene = small(name);
      scene.camera.origin = {100, 300, 50};  // inside of the room
      const Film usual = render_film(scene, settings, {0, 10});
      scene.camera.sees_through_backs = true;
      const Film other = render_film(scene, settings, {0, 10});
      EXPECT_EQ(usual.mean(), other.mean());
      EXPECT_EQ(usual.variance(), other.variance());
    }
  }
}

TEST(Determinism, AnotherSeedGivesAnotherPicture) {
  for (Settings settings : all_settings()) {
    const Film one = render_film(small("cornell"), settings, {0, 8});
    settings.seed = 6;
    EXPECT_NE(one.mean(), render_film(small("cornell"), settings, {0, 8}).mean());
  }
}

}  // namespace
}  // namespace plumb::test
