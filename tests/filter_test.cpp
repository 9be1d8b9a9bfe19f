// SPDX-License-Identifier: Apache-2.0

// How much light beside a pixel's middle counts, in closed form.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/test_scenes.h"

namespace plumb::test {
namespace {

// A camera of 16 x 16 pixels, each one unit wide at distance 1, and a bright wall there that covers
// x from `left` to `right` pixels and y from `top` to `bottom`.
Scene bright_window(const Filter& filter, double left, double right, double top, double bottom) {
  Scene scene;
  scene.camera = camera({0, 0, 0}, {0, 0, -1}, 2.0 * std::atan(8.0) * 180.0 / M_PI);
  scene.camera.filter = filter;
  const Vec3 right_to_world = scene.camera.right, down = -scene.camera.up;
  const Vec3 corner = scene.camera.forward + right_to_world * (left - 8) + down * (top - 8);
  scene.shapes = {parallelogram(corner, down * (bottom - top), right_to_world * (right - left),
                                diffuse(0.0), 1.0)};
  return scene;
}

constexpr double far = 24;  // beyond all filters

// The share of a filter's weight beyond a distance from its middle.
double share_beyond(const Filter& filter, double distance) {
  if (filter.kind == Filter::Kind::box) return std::clamp(0.5 - distance, 0.0, 1.0);
  if (filter.kind == Filter::Kind::tent) {
    const double x = distance / filter.size;
    const double beyond = std::pow(std::max(1.0 - std::abs(x), 0.0), 2) / 2.0;
    return x > 0.0 ? beyond : 1.0 - beyond;
  }
  if (filter.kind == Filter::Kind::blackman_harris) {
    const double x = std::clamp(distance / filter.size, -1.0, 1.0);
    const auto below = [](double t) {
      return 0.35875 * t +
             (0.48829 * std::sin(M_PI * t) + 0.14128 / 2.0 * std::sin(2.0 * M_PI * t) +
              0.01168 / 3.0 * std::sin(3.0 * M_PI * t)) /
                 M_PI;
    };
    return (below(1.0) - below(x)) / (2.0 * below(1.0));
  }
  // Of exp(-x^2 / 2) - exp(-8) from -4 to 4.
  const double x = std::clamp(distance / filter.size, -4.0, 4.0);
  const auto below = [](double t) {
    return std::sqrt(M_PI / 2.0) * std::erf(t / std::sqrt(2.0)) - std::exp(-8.0) * t;
  };
  return (below(4.0) - below(x)) / (2.0 * below(4.0));
}

struct Named {
  std::string name;
  Filter filter;
};

class FilterTest : public testing::TestWithParam<Named> {
 protected:
  // Of the red channel, in rows from the top.
  static std::vector<float> draw(const Scene& scene, Precision precision, Sampler sampler) {
    const Film film =
        render_film(scene, {.sampler = sampler, .precision = precision, .bounces = {}}, {0, 16384});
    std::vector<float> red;
    for (size_t i = 0; i < film.mean().size(); i += 3) red.push_back(film.mean()[i]);
    return red;
  }
};

// Half of the picture is bright, from the middle of pixel 7 on: a pixel is bright by the share of
// its filter there. A share s of independent samples scatters by sqrt(s (1 - s) / n), at most
// 0.004; the Sobol' ones by far less.
TEST_P(FilterTest, CountsByTheSharesOfItsWeight) {
  Filter filter = GetParam().filter;
  filter.crosses_border = true;
  const Scene scene = bright_window(filter, 7.5, far, -far, far);
  for (const Precision precision : {Precision::float32, Precision::float64}) {
    for (const Sampler sampler : {Sampler::independent, Sampler::sobol}) {
      const std::vector<float> red = draw(scene, precision, sampler);
      const double tolerance = sampler == Sampler::sobol ? 1e-3 : 5 * 0.004;
      for (size_t x = 0; x < 16; ++x) {
        EXPECT_NEAR(red[8 * 16 + x], share_beyond(filter, 7.0 - double(x)), tolerance) << x;
      }
    }
  }
}

// The same seen from above: where nothing lies beyond the picture's border, the filter is cut there
// unless it is to cross it.
TEST_P(FilterTest, IsCutAtThePicturesBorderOrCrossesIt) {
  Filter filter = GetParam().filter;
  const double inside = share_beyond(filter, -0.5);
  for (const bool crosses : {false, true}) {
    filter.crosses_border = crosses;
    const std::vector<float> red =
        draw(bright_window(filter, 0, 16, 0, 16), Precision::float64, Sampler::sobol);
    EXPECT_NEAR(red[0], crosses ? inside * inside : 1.0, 1e-3);
    EXPECT_NEAR(red[15 * 16 + 7], crosses ? inside : 1.0, 1e-3);
  }
}

INSTANTIATE_TEST_SUITE_P(All, FilterTest,
                         testing::Values(Named{"box", {}}, Named{"tent", {Filter::Kind::tent, 1.0}},
                                         Named{"wide_tent", {Filter::Kind::tent, 2.5}},
                                         Named{"gaussian", {Filter::Kind::gaussian, 0.5}},
                                         Named{"narrow_gaussian", {Filter::Kind::gaussian, 0.2}},
                                         Named{"blackman_harris",
                                               {Filter::Kind::blackman_harris, 0.75}}),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace plumb::test
