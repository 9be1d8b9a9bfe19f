// SPDX-License-Identifier: Apache-2.0

// The plain path tracer and the fast one say the same of both scenes, region by region.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "faults/faults.h"
#include "scene_files/region_mask.h"
#include "scene_files/scene_reader.h"
#include "tests/test_scenes.h"

namespace plumb::test {
namespace {

constexpr Settings plain{.method = Method::plain,
                         .sampler = Sampler::independent,
                         .precision = Precision::float64,
                         .seed = 1,
                         .bounces = {}};

struct Sum {
  double value = 0.0, variance = 0.0;
};

// By region and channel.
std::map<int, std::array<Sum, 3>> sums(const Film& film, const RegionMask& mask) {
  const std::vector<float> mean = film.mean(), variance = film.variance();
  std::map<int, std::array<Sum, 3>> result;
  for (size_t i = 0; i < mean.size(); ++i) {
    Sum& sum = result[mask.regions[i / 3]][i % 3];
    sum.value += double{mean[i]};
    sum.variance += double{variance[i]};
  }
  return result;
}

class PlainPathTracer : public testing::TestWithParam<const char*> {
 protected:
  PlainPathTracer() : scene(read_scene(std::string(PLUMB_SCENES "/") + GetParam() + "/scene.xml")) {
    scene.camera.width = scene.camera.height = 48;
  }
  Scene scene;
};

// Both are estimates with 4 replicates of some hundred pixels: 5.5 standard errors of one of some
// 120 differences happen by chance once in 10,000 tests.
TEST_P(PlainPathTracer, AgreesInEveryRegion) {
  const RegionMask mask = region_mask(scene, RegionKind::side);
  for (const BounceRange bounces : {BounceRange{}, BounceRange{1, 1}, BounceRange{2, 3}}) {
    Settings settings = plain;
    settings.bounces = bounces;
    const auto slow = sums(render_film(scene, settings, {0, 128}), mask);
    const auto fast = sums(render_film(scene, {.seed = 2, .bounces = bounces}, {0, 4096}), mask);
    for (const auto& [region, channels] : slow) {
      for (size_t c = 0; c < 3; ++c) {
        const Sum& a = channels[c];
        const Sum& b = fast.at(region)[c];
        const double error = std::sqrt(a.variance + b.variance);
        EXPECT_NEAR(a.value, b.value, 5.5 * error + 1e-6 * b.value)
            << (region < 0 ? "edges" : mask.names[size_t(region)]) << " channel " << c
            << " bounces " << bounces.first << " to " << bounces.last;
      }
    }
  }
}

TEST_P(PlainPathTracer, DrawsEveryFilter) {
  for (const Filter filter : {Filter{Filter::Kind::tent, 1.5}, Filter{Filter::Kind::gaussian, 0.5},
                              Filter{Filter::Kind::gaussian, 0.8, true}}) {
    scene.camera.filter = filter;
    const RegionMask columns = [&] {  // eight pixels wide, of the whole height
      RegionMask mask;
      for (int i = 0; i < 48 * 48; ++i) mask.regions.push_back(i % 48 / 8);
      return mask;
    }();
    const auto slow = sums(render_film(scene, plain, {0, 64}), columns);
    const auto fast = sums(render_film(scene, {.seed = 2, .bounces = {}}, {0, 1024}), columns);
    for (const auto& [column, channels] : slow) {
      const double error = std::sqrt(channels[0].variance + fast.at(column)[0].variance);
      EXPECT_NEAR(channels[0].value, fast.at(column)[0].value, 5.0 * error) << column;
    }
  }
}

TEST_P(PlainPathTracer, RefusesWhatItHasNot) {
  Film film(48, 48);
  Settings sobol = plain, single = plain, faulty = plain;
  Scene scene_with_fault = scene;
  sobol.sampler = Sampler::sobol;
  single.precision = Precision::float32;
  plant(Fault::inverse_pi, scene_with_fault, faulty);
  for (const Settings& settings : {sobol, single, faulty}) {
    EXPECT_THROW(render(scene, settings, {.samples = {0, 1}}, film), std::invalid_argument);
  }
}

INSTANTIATE_TEST_SUITE_P(Scene, PlainPathTracer, testing::Values("cornell", "seed"),
                         [](const auto& scene) { return std::string(scene.param); });

}  // namespace
}  // namespace plumb::test
