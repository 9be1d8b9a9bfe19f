// SPDX-License-Identifier: Apache-2.0

// Each fault changes the picture as theory says, and names no more than itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "faults/faults.h"
#include "faults/faulty_estimator-inl.h"
#include "scene_files/scene_reader.h"
#include "tests/test_scenes.h"

HWY_BEFORE_NAMESPACE();
namespace plumb::HWY_NAMESPACE {
namespace {

using Lanes = hn::ScalableTag<float>;

float random_of_pixel(int x, int y) {
  return hn::GetLane(webgl_random<Lanes>(float(x), float(y), 0.0f).v);
}

float squared_tangent(float x, float y, float z) {
  const Frame<Lanes> frame = short_frame_around<Lanes>({x, y, z});
  return hn::GetLane(dot(frame.x, frame.x).v);
}

}  // namespace
}  // namespace plumb::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

namespace plumb::test {
namespace simd = plumb::HWY_NAMESPACE;
namespace {

constexpr double pi = std::numbers::pi;
constexpr SampleRange some_samples{0, 32};

Scene small(const std::string& name) {
  Scene scene = read_scene(std::string(PLUMB_SCENES "/") + name + "/scene.xml");
  scene.camera.width = scene.camera.height = 32;
  return scene;
}

std::vector<float> picture(Scene scene, Settings settings, Fault fault,
                           const SampleRange& samples = some_samples) {
  plant(fault, scene, settings);
  return render_film(scene, settings, samples).mean();
}

Measurement measure_with(Fault fault, Scene scene, Settings settings, const SampleRange& samples) {
  plant(fault, scene, settings);
  return measure(render_film(scene, settings, samples));
}

// A small lamp at `lamp`, facing down, over a floor of albedo 0.5 of which the camera sees the
// origin.
Scene small_lamp(const Vec3& lamp, double radiance = 1.0) {
  constexpr double size = 0.02;
  Scene scene;
  scene.shapes = {parallelogram({-4, 0, -4}, {0, 0, 8}, {8, 0, 0}, diffuse(0.5)),
                  parallelogram(lamp, {size, 0, 0}, {0, 0, size}, diffuse(0.0), radiance)};
  scene.camera = camera({-0.4, 0.3, 0.05}, {0, 0, 0}, pinpoint);
  return scene;
}

const Settings sampled_lamps{.method = Method::nee, .seed = 1, .bounces = {1, 1}};

// The renderer adds the same samples with the fault as without: the ratio has rounding alone.
void expect_ratio(Fault fault, const Scene& scene, double ratio, double tolerance = 1e-5) {
  const double healthy = measure_with(Fault::none, scene, sampled_lamps, some_samples).mean;
  const double faulty = measure_with(fault, scene, sampled_lamps, some_samples).mean;
  ASSERT_GT(healthy, 0.0);
  EXPECT_NEAR(faulty / healthy, ratio, tolerance * ratio);
}

TEST(Fault, InversePiMultipliesDirectLightByPi) {
  expect_ratio(Fault::inverse_pi, small_lamp({1, 2, 0}), pi);
}

TEST(Fault, HalfLampAreaHalvesDirectLight) {
  expect_ratio(Fault::half_lamp_area, small_lamp({1, 2, 0}), 0.5);
}

// The lamp is seen under cosines that differ by less than its size over its distance.
TEST(Fault, EmitterCosineDividesDirectLightByTheCosine) {
  const Vec3 middle(1.01, 2, 0.01);
  expect_ratio(Fault::emitter_cosine, small_lamp({1, 2, 0}), middle.length() / middle.y, 1e-3);
  Scene scene = small_lamp({1, 2, 0});
  scene.shapes[1] = sphere({1, 2, 0}, 0.5, diffuse(0.0), 1.0);
  // Of a sphere, the mean over its disc of one over the cosine is 2, if it is far.
  const double healthy = measure_with(Fault::none, scene, sampled_lamps, {0, 4096}).mean;
  const double faulty = measure_with(Fault::emitter_cosine, scene, sampled_lamps, {0, 4096}).mean;
  EXPECT_NEAR(faulty / healthy, 2.0, 0.04);
}

TEST(Fault, InverseSquareMultipliesDirectLightByTheSquaredDistance) {
  const Vec3 middle(1.01, 2, 0.01);
  const double unit = Vec3(8, 2, 8).length() / 2.0;  // half the scene's diagonal
  expect_ratio(Fault::inverse_square, small_lamp({1, 2, 0}), middle.length2() / (unit * unit),
               1e-3);
}

TEST(Fault, EvenLampKnowsNeitherCosineNorDistance) {
  const Vec3 middle(1.01, 2, 0.01);
  const double unit = Vec3(8, 2, 8).length() / 2.0;
  const double square = middle.length2() / (unit * unit);
  expect_ratio(Fault::even_lamp, small_lamp({1, 2, 0}), square * middle.length() / middle.y, 1e-3);
}

// The demo's ball has the lamp's area, shines with L A / pi at any distance, and is not turned.
TEST(Fault, WebglDemoKnowsNoDistance) {
  const Vec3 middle(1.01, 2, 0.01);
  const double cosine = middle.y / middle.length();
  Scene scene = small_lamp({1, 2, 0});
  // Half the diagonal of the scene's bounding box, the demo's unit of length.
  const double unit = Vec3(8, 2, 8).length() / 2.0;
  const double expected = 0.5 * cosine / pi * 0.02 * 0.02 / (unit * unit);
  const Measurement m = measure_with(Fault::webgl_demo, scene, sampled_lamps, some_samples);
  EXPECT_NEAR(m.mean / expected, 1.0, 1e-3);
}

// Under a spherical lamp that is seen up to an angle t from the zenith: of cosine-weighted
// directions sin^2 t meet it, of uniform ones 1 - cos t.
TEST(Fault, UniformDirectionsMeetTooLittleOfTheZenith) {
  Scene scene = small_lamp({0, 0, 0});
  const double sine = 0.6;
  scene.shapes[1] = sphere({0, 5, 0}, 5 * sine, diffuse(0.0), 1.0);
  const Settings chance{.method = Method::bsdf, .seed = 1, .bounces = {1, 1}};
  const Measurement healthy = measure_with(Fault::none, scene, chance, {0, 1024});
  const Measurement faulty = measure_with(Fault::uniform_directions, scene, chance, {0, 1024});
  const double cosine = std::sqrt(1.0 - sine * sine);
  EXPECT_NEAR(healthy.mean, 0.5 * sine * sine, 5.0 * healthy.standard_error);
  EXPECT_NEAR(faulty.mean, 0.5 * (1.0 - cosine), 5.0 * faulty.standard_error);
}

// Sampled light counts in full, light met by chance by its weight, (mu / pi) / (mu / pi + 1 /
// omega) with mu the cosine: of a cap of the sky from the zenith down to mu = c, 2 a int mu^2 / (mu
// + k) with k = pi / omega, on top of all light, a (1 - c^2).
TEST(Fault, OneSidedMisAddsWhatChanceFinds) {
  constexpr double a = 0.5, sine = 0.6, c = 0.8, k = 1 / (2 * (1 - c));
  Scene scene = small_lamp({0, 0, 0});
  scene.shapes[1] = sphere({0, 5, 0}, 5 * sine, diffuse(0.0), 1.0);
  const Settings mis{.seed = 1, .bounces = {1, 1}};
  const Measurement m = measure_with(Fault::one_sided_mis, scene, mis, {0, 1024});
  const auto integral = [&](double mu) { return mu * mu / 2 - k * mu + k * k * std::log(mu + k); };
  const double expected = a * (1 - c * c) + 2 * a * (integral(1) - integral(c));
  EXPECT_NEAR(m.mean, expected, 5.0 * m.standard_error);
  EXPECT_LT(m.standard_error, 0.001 * expected);
}

// In a furnace with albedo a, bounce b adds a^b, if the path has survived b times min(1, 3 a^i).
TEST(Fault, RouletteWithoutItsWeightLosesLight) {
  constexpr double a = 0.2;
  Scene scene;
  scene.shapes = room({-1, -1, -1}, {1, 1.5, 1}, diffuse(a), 1.0);
  scene.camera = camera({-0.7, 0.6, -0.8}, {0.2, -0.2, 0.1}, 60.0);
  const Settings chance{.method = Method::bsdf, .seed = 1, .bounces = {}};
  const Measurement m = measure_with(Fault::roulette_weight, scene, chance, {0, 1024});
  double expected = 0.0;
  double throughput = 1.0;
  double alive = 1.0;
  for (int bounce = 0; bounce < 20; ++bounce) {
    expected += alive * throughput;
    throughput *= a;
    alive *= std::min(1.0, 3.0 * throughput);
  }
  EXPECT_NEAR(m.mean, expected, 5.0 * m.standard_error);
  EXPECT_LT(m.mean, 0.99 / (1.0 - a));
}

TEST(Fault, FiveBouncesAreTheHealthyFiveBounces) {
  const Settings all{.seed = 1, .bounces = {}};
  const Settings five{.seed = 1, .bounces = {0, 5}};
  for (const char* name : {"cornell", "seed"}) {
    EXPECT_EQ(picture(small(name), all, Fault::five_bounces),
              picture(small(name), five, Fault::none));
  }
}

TEST(Fault, GammaReflectanceIsTheSceneWithEncodedAlbedo) {
  const Scene scene = small("cornell");
  Scene encoded = scene;
  for (Shape& shape : encoded.shapes) {
    for (int c = 0; c < 3; ++c) {
      shape.bsdf.reflectance[c] = std::pow(shape.bsdf.reflectance[c], 1 / 2.2);
    }
  }
  const Settings settings{.seed = 1, .bounces = {}};
  EXPECT_EQ(picture(scene, settings, Fault::gamma_reflectance),
            picture(encoded, settings, Fault::none));
}

// The shifted pixel (x, y) covers four pixels of a camera with twice the resolution, from
// (2 x + 1, 2 y + 1) on. A pixel on an edge has a standard error of 0.016 at most.
TEST(Fault, HalfPixelMovesThePictureHalfAPixel) {
  Scene scene;
  scene.shapes = {parallelogram({-4, -4, 4}, {0, 8, 0}, {8, 0, 0}, diffuse(0.0)),
                  parallelogram({-0.3, 0.2, 3.9}, {0, 0.9, 0}, {0.9, 0, 0}, diffuse(0.0), 1.0)};
  scene.camera = camera({0, 0, 0}, {0, 0, 4}, 60.0, 16);
  const Settings settings{.seed = 1, .bounces = {}};
  const SampleRange samples{0, 1024};
  const std::vector<float> shifted = picture(scene, settings, Fault::half_pixel, samples);
  scene.camera.width = scene.camera.height = 32;
  const std::vector<float> fine = picture(scene, settings, Fault::none, samples);
  for (size_t y = 0; y < 15; ++y) {
    for (size_t x = 0; x < 15; ++x) {
      const auto at = [&](size_t u, size_t v) { return fine[(v * 32 + u) * 3]; };
      const float mean = (at(2 * x + 1, 2 * y + 1) + at(2 * x + 2, 2 * y + 1) +
                          at(2 * x + 1, 2 * y + 2) + at(2 * x + 2, 2 * y + 2)) /
                         4;
      EXPECT_NEAR(shifted[(y * 16 + x) * 3], mean, 0.06) << x << ", " << y;
    }
  }
}

// Ten times as much light, clamped at 10, is dimmer where it was above 1, and never brighter.
TEST(Fault, ClampNeverBrightens) {
  for (const double radiance : {1.0, 1e4}) {
    Scene scene = small("cornell");
    for (Shape& shape : scene.shapes) shape.radiance *= radiance;
    const Settings settings{.seed = 1, .bounces = {}};
    const std::vector<float> healthy = picture(scene, settings, Fault::none);
    const std::vector<float> clamped = picture(scene, settings, Fault::clamp_indirect);
    for (size_t i = 0; i < healthy.size(); ++i) ASSERT_LE(clamped[i], healthy[i]);
    // No contribution of the Cornell box's indirect light is above 10: see docs/power.md.
    EXPECT_EQ(clamped == healthy, radiance == 1.0);
  }
}

TEST(Fault, TwoSidedLampLightsWhatIsBehindAsWhatIsBefore) {
  Scene scene = small_lamp({1, 2, 0});
  Scene above = scene;
  for (Vec3& corner : std::get<Mesh>(above.shapes[1].geometry)[0].corners) corner.y = -2.0;
  above.shapes[0] = parallelogram({-4, 0, -4}, {8, 0, 0}, {0, 0, 8}, diffuse(0.5));
  above.camera.origin.y *= -1;
  above.camera.forward.y *= -1;
  above.camera.up = above.camera.right.cross(above.camera.forward);
  const Settings& nee = sampled_lamps;
  EXPECT_EQ(measure_with(Fault::none, above, nee, {0, 256}).mean, 0.0);
  const double below = measure_with(Fault::none, scene, nee, {0, 256}).mean;
  const double behind = measure_with(Fault::two_sided_lamp, above, nee, {0, 256}).mean;
  // The lamp behind is 1e-4 of its size aside.
  EXPECT_NEAR(behind / below, 1.0, 1e-4);
}

// A black lamp that shines with 1 in the middle of a glass ball, met at an angle: of its radiance,
// of which the glass holds n^2 times as much as the air, 1 - R gets out.
Scene lamp_in_a_ball(double angle, double ior) {
  Scene scene;
  scene.shapes = {sphere({0, -1, 0}, 1.0, glass(ior)), sphere({0, -1, 0}, 0.7, diffuse(0.0), 1.0)};
  scene.camera = camera({2 * std::sin(angle), 2 * std::cos(angle), 0}, {0, 0, 0}, pinpoint);
  return scene;
}

// A prism of 45 degrees that turns what enters and leaves it straight by total reflection, towards
// a lamp that shines with 1.
Scene prism() {
  const Vec3 a(0, 0, -9), b(1, 0, -9), c(0, 1, -9), depth(0, 0, 18);
  Scene scene;
  scene.shapes = {{"prism",
                   Mesh{{{a, c, b}},
                        {{a + depth, b + depth, c + depth}},
                        {{a, b, b + depth, a + depth}},
                        {{b, c, c + depth, b + depth}},
                        {{c, a, a + depth, c + depth}}},
                   glass(1.5), Rgb(0.0)},
                  parallelogram({-9, -2, -9}, {0, 0, 18}, {18, 0, 0}, diffuse(0.0), 1.0)};
  scene.camera = camera({-1, 0.4, 0}, {0, 0.4, 0}, pinpoint);
  return scene;
}

const Settings by_chance{.method = Method::bsdf, .seed = 1, .bounces = {}};

TEST(Fault, NSquaredShowsInGlassThatHoldsALampAlone) {
  const Scene inside = lamp_in_a_ball(0.8, 1.8);
  const double healthy = measure_with(Fault::none, inside, by_chance, some_samples).mean;
  const double faulty = measure_with(Fault::n_squared, inside, by_chance, some_samples).mean;
  EXPECT_NEAR(faulty / healthy, 1.8 * 1.8, 1e-5);
  Scene outside = inside;
  outside.shapes = room({-9, -9, -9}, {9, 9, 9}, diffuse(0.0), 1.0);
  outside.shapes.push_back(inside.shapes[0]);
  EXPECT_NEAR(measure_with(Fault::n_squared, outside, by_chance, some_samples).mean, 1.0, 1e-5);
}

TEST(Fault, FresnelIgnoredLetsAllThroughThatCanGoThrough) {
  const Measurement ball =
      measure_with(Fault::fresnel_ignored, lamp_in_a_ball(1.4, 1.8), by_chance, some_samples);
  EXPECT_NEAR(ball.mean * 1.8 * 1.8, 1.0, 1e-5);
  const Measurement turned = measure_with(Fault::fresnel_ignored, prism(), by_chance, some_samples);
  EXPECT_NEAR(turned.mean, 1.0, 1e-5);
}

TEST(Fault, GlassInsideOutIsABubbleInGlass) {
  const Scene scene = lamp_in_a_ball(0.3, 1.8);
  EXPECT_EQ(picture(scene, by_chance, Fault::glass_inside_out),
            picture(lamp_in_a_ball(0.3, 1.0 / 1.8), by_chance, Fault::none));
}

// Schlick: f + (1 - f) (1 - cosine)^5, with f what is reflected straight.
TEST(Fault, SchlickReflectsByItsFormula) {
  for (const double angle : {0.0, 0.8, 1.4}) {
    const Scene scene = lamp_in_a_ball(angle, 1.8);
    const double f = 0.8 * 0.8 / (2.8 * 2.8);
    const double reflected = f + (1.0 - f) * std::pow(1.0 - std::cos(angle), 5);
    const Measurement m = measure_with(Fault::schlick, scene, by_chance, {0, 4096});
    EXPECT_NEAR(m.mean * 1.8 * 1.8, 1.0 - reflected, 4.0 * m.standard_error * 1.8 * 1.8);
    EXPECT_LT(m.standard_error, 0.002 * m.mean);
  }
}

TEST(Fault, TotalReflectionIsBlackAndNothingElse) {
  EXPECT_EQ(measure_with(Fault::total_reflection_black, prism(), by_chance, some_samples).mean, 0);
  const Scene ball = lamp_in_a_ball(0.8, 1.8);
  EXPECT_EQ(picture(ball, by_chance, Fault::total_reflection_black),
            picture(ball, by_chance, Fault::none));
}

// The helper crosses with the x axis, or with y where the normal is within 60 degrees of x.
TEST(Fault, TangentsAreAsShortAsTheSineToAFixedAxis) {
  EXPECT_NEAR(simd::squared_tangent(0, 1, 0), 1.0, 1e-6);
  EXPECT_NEAR(simd::squared_tangent(0, 0, 1), 1.0, 1e-6);
  EXPECT_NEAR(simd::squared_tangent(1, 0, 0), 1.0, 1e-6);
  EXPECT_NEAR(simd::squared_tangent(0.48f, 0.64f, 0.6f), 1.0 - 0.48 * 0.48, 1e-6);
  EXPECT_NEAR(simd::squared_tangent(0.6f, 0.8f, 0), 1.0 - 0.8 * 0.8, 1e-6);
}

// Of 24 bits, 15 or 16 are the whole part, which is thrown away.
TEST(WebglRandom, HasFewValues) {
  std::set<float> values;
  double sum = 0.0;
  for (int i = 0; i < 512 * 512; ++i) {
    const float value = simd::random_of_pixel(i % 512, i / 512);
    values.insert(value);
    sum += double{value};
  }
  EXPECT_NEAR(static_cast<double>(values.size()), 8400.0, 100.0);
  RecordProperty("values", static_cast<int>(values.size()));
  EXPECT_GE(*values.begin(), 0.0f);
  EXPECT_LE(*values.rbegin(), 1.0f);
  // Four standard errors, if they were independent: 4 / sqrt(12 * 2^18).
  EXPECT_NEAR(sum / (512 * 512), 0.5, 2.3e-3);
}

TEST(WebglRandom, FramesRepeat) {
  std::set<float> seeds;
  for (uint32_t frame = 0; frame < 2997; ++frame) seeds.insert(simd::webgl_seed(frame));
  EXPECT_EQ(seeds.size(), 1000u);
  for (uint32_t frame = 0; frame < 100; ++frame) {
    EXPECT_EQ(simd::webgl_seed(frame), simd::webgl_seed(frame + 2997));
  }
}

TEST(Faults, ChangeThePictureButNotTheRenderer) {
  const Settings settings{.seed = 1, .bounces = {}};
  const Scene plain = small("seed");
  Scene with_glass = plain;
  with_glass.shapes.back() = icosphere({142, 240, 200}, 70, 1, glass(1.5));
  for (const FaultDescription& fault : faults()) {
    if (fault.is_set_up) continue;  // diagnose_test.cpp
    const Scene& scene = fault.is_of_glass ? with_glass : plain;
    const std::vector<float> healthy = picture(scene, settings, Fault::none);
    const bool is_visible = picture(scene, settings, fault.fault) != healthy;
    EXPECT_EQ(is_visible, fault.fault != Fault::clamp_indirect) << fault.name;
    EXPECT_EQ(picture(scene, settings, Fault::none), healthy) << fault.name;
    if (!fault.is_of_glass) continue;
    EXPECT_EQ(picture(plain, settings, fault.fault), picture(plain, settings, Fault::none));
  }
}

TEST(Faults, OfTheTracerAreForFloatAlone) {
  const Settings settings{.precision = Precision::float64, .bounces = {}};
  EXPECT_THROW(picture(small("cornell"), settings, Fault::inverse_pi), std::invalid_argument);
  EXPECT_NO_THROW(picture(small("cornell"), settings, Fault::five_bounces, {0, 1}));
}

}  // namespace
}  // namespace plumb::test
