// SPDX-License-Identifier: Apache-2.0

// Pictures by other programs. Those that are installed draw the Cornell box for real.
#include "other_renderers/runner.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <complex>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "renderer/render.h"
#include "scene_files/scene_reader.h"
#include "tests/test_scenes.h"

namespace plumb {
namespace {

namespace fs = std::filesystem;

constexpr const char* cornell = PLUMB_SCENES "/cornell/scene.xml";
const std::atomic<bool> never{false};

fs::path fresh_folder() {
  fs::path folder = fs::temp_directory_path() /
                    ("plumb_reference_" +
                     std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

Scene small_cornell() {
  Scene scene = read_scene(cornell);
  scene.camera.width = scene.camera.height = 64;
  return scene;
}

Reference draw(const std::string& renderer, const Scene& scene, const ReferenceSettings& settings,
               const std::atomic<bool>& stop = never) {
  return render_reference(other_renderer(renderer), scene, cornell, settings,
                          fresh_folder() / "log", {[](const std::string&) {}, stop});
}

// Nothing if the program isn't installed.
std::optional<Reference> draw_if_installed(const std::string& renderer, const Scene& scene,
                                           const ReferenceSettings& settings) {
  try {
    return draw(renderer, scene, settings);
  } catch (const std::runtime_error& error) {
    if (std::string(error.what()).find("not installed") == std::string::npos) throw;
    return {};
  }
}

struct Estimate {
  double mean = 0.0;
  double variance = 0.0;
};

Estimate mean_of(const Image& image) {
  Estimate estimate;
  const double count = double(image.width) * image.height * 3;
  const size_t channels = image.channels.size();
  for (size_t i = 0; i < image.values.size(); ++i) {
    if (i % channels < 3)
      estimate.mean += double{image.values[i]} / count;
    else
      estimate.variance += double{image.values[i]} / (count * count);
  }
  return estimate;
}

Estimate mean_of_ours(const Scene& scene, const BounceRange& bounces) {
  Film film(64, 64);
  render(scene, {.bounces = bounces}, {.samples = {0, 2048}}, film);
  Estimate estimate;
  const double count = 64 * 64 * 3;
  for (const float value : film.mean()) estimate.mean += double{value} / count;
  for (const float value : film.variance()) estimate.variance += double{value} / (count * count);
  return estimate;
}

// A program named `name`, found before any other.
class FakeProgram {
 public:
  FakeProgram(const std::string& name, const std::string& script) : old_path_(getenv("PATH")) {
    const fs::path folder = fresh_folder() / "bin";
    fs::create_directories(folder);
    std::ofstream(folder / name) << "#!/bin/sh\n" << script << "\n";
    chmod((folder / name).c_str(), 0755);
    setenv("PATH", (folder.string() + ":" + old_path_).c_str(), 1);
  }
  ~FakeProgram() { setenv("PATH", old_path_.c_str(), 1); }

 private:
  std::string old_path_;
};

// Tests run beside each other.
fs::path fake_log() {
  return fs::temp_directory_path() / fmt::format("plumb_fake_{}.log", getpid());
}

std::string complaint_of(const std::string& renderer, const ReferenceSettings& settings = {}) {
  try {
    render_reference(other_renderer(renderer), small_cornell(), cornell, settings, fake_log(),
                     {[](const std::string&) {}, never});
    return "";
  } catch (const std::exception& error) {
    return error.what();
  }
}

TEST(Reference, CyclesDrawsTheSamePicture) {
  const Scene scene = small_cornell();
  const auto cycles =
      draw_if_installed("cycles", scene, {.samples_per_pixel = 32, .seeds = 4, .bounces = {}});
  if (!cycles) GTEST_SKIP() << "Blender is not installed";
  const Estimate theirs = mean_of(cycles->image);
  const Estimate ours = mean_of_ours(scene, {});
  const double error = std::sqrt(theirs.variance + ours.variance);
  // The two are known to agree to 0.05 % of the mean.
  EXPECT_NEAR(theirs.mean, ours.mean, 4.5 * error + 5e-4 * ours.mean);
  EXPECT_LT(error, 2e-3 * ours.mean) << "else nothing is tested";
  EXPECT_EQ(cycles->samples_per_pixel, 128);
  EXPECT_GT(cycles->process_seconds, cycles->wall_seconds);
}

TEST(Reference, PovRayDrawsTheSameDirectLight) {
  const Scene scene = small_cornell();
  const BounceRange direct{1, 1};
  const auto povray =
      draw_if_installed("povray", scene, {.quality = Quality::draft, .bounces = direct});
  if (!povray) GTEST_SKIP() << "POV-Ray is not installed";
  const double ours = mean_of_ours(scene, direct).mean;
  // Nine rays in a pixel and penumbrae in 36 steps: 0.15 % was measured.
  EXPECT_NEAR(mean_of(povray->image).mean, ours, 3e-3 * ours);
}

// A floor and a wall by a triangular lamp, which no other shape's code draws.
Scene triangular_lamp() {
  Scene scene;
  scene.camera = test::camera(Vec3(0, 1.5, 5), Vec3(0, 1, 0), 50, 64);
  scene.shapes = {
      test::parallelogram(Vec3(-2, 0, 2), Vec3(4, 0, 0), Vec3(0, 0, -4), test::diffuse(0.6)),
      test::parallelogram(Vec3(-2, 0, -2), Vec3(4, 0, 0), Vec3(0, 3, 0), test::diffuse(0.6)),
      {"lamp", Mesh{Polygon{{Vec3(-1, 2.4, -1), Vec3(1, 2.2, -0.5), Vec3(-0.7, 2.4, 0.8)}}},
       test::diffuse(0.0), Rgb(5.0)}};
  return scene;
}

TEST(Reference, TriangularLampsAreDrawnWithPovRay) {
  const Scene scene = triangular_lamp();
  const BounceRange direct{1, 1};
  const auto povray =
      draw_if_installed("povray", scene, {.quality = Quality::draft, .bounces = direct});
  if (!povray) GTEST_SKIP() << "POV-Ray is not installed";
  const double ours = mean_of_ours(scene, direct).mean;
  // Nine rays in a pixel see a horizon that all rows share.
  EXPECT_NEAR(mean_of(povray->image).mean, ours, 5e-3 * ours);
}

TEST(Reference, TriangularLampsAreDrawnWithCycles) {
  const Scene scene = triangular_lamp();
  const auto cycles = draw_if_installed("cycles", scene, {.samples_per_pixel = 32, .seeds = 2});
  if (!cycles) GTEST_SKIP() << "Blender is not installed";
  const Estimate theirs = mean_of(cycles->image);
  const Estimate ours = mean_of_ours(scene, {});
  // Lamps that are meshes are up to 1.4 % too dark in Blender 3.4, where light grazes.
  EXPECT_NEAR(theirs.mean, ours.mean,
              4.5 * std::sqrt(theirs.variance + ours.variance) + 0.01 * ours.mean);
}

// What Fresnel's equations say that is reflected at that angle, by the laws of sines and tangents.
double reflectance(double angle, std::complex<double> n) {
  const auto beyond = std::asin(std::sin(angle) / n);
  return (std::norm(std::sin(angle - beyond) / std::sin(angle + beyond)) +
          std::norm(std::tan(angle - beyond) / std::tan(angle + beyond))) /
         2.0;
}

constexpr double angle = 1.2;

// A small piece of what is in the plane y = 0, seen from above at that angle; on one side
// everything shines with 1. It is not where the two triangles meet that programs make of a face.
Scene looking_down(const std::vector<Shape>& shapes, bool lamp_is_above) {
  const Vec3 target(0.2, 0.0, 0.3), x(800, 0, 0), z(0, 0, 800);
  Scene scene;
  scene.camera =
      test::camera(target + Vec3(std::sin(angle), std::cos(angle), 0.0) * 3.0, target, 0.05, 64);
  scene.shapes = shapes;
  const Bsdf black = test::diffuse(0.0);
  scene.shapes.push_back(lamp_is_above ? test::parallelogram({-400, 50, -400}, x, z, black, 1.0)
                                       : test::parallelogram({-400, -50, -400}, z, x, black, 1.0));
  return scene;
}

Shape pane(const Bsdf& glass) {
  const Vec3 x(120, 0, 0), z(0, 0, 120), corner(-60, 0, -60), down(0, -0.2, 0);
  return {"pane",
          Mesh{{{corner, corner + z, corner + z + x, corner + x}},
               {{corner + down, corner + down + x, corner + down + x + z, corner + down + z}}},
          glass, Rgb(0.0)};
}

// By all reflections to and fro in the pane.
const double through_pane = (1.0 - reflectance(angle, 1.5)) / (1.0 + reflectance(angle, 1.5));

Scene gold() {
  return looking_down(
      {test::parallelogram({-60, 0, -60}, {0, 0, 120}, {120, 0, 0},
                           test::metal({0.143, 0.375, 1.442}, {3.983, 2.386, 1.603}))},
      true);
}

const double of_gold = (reflectance(angle, {0.143, 3.983}) + reflectance(angle, {0.375, 2.386}) +
                        reflectance(angle, {1.442, 1.603})) /
                       3.0;

void expect_from_cycles(const Scene& scene, double expected) {
  const auto cycles = draw_if_installed("cycles", scene, {.samples_per_pixel = 64, .seeds = 2});
  if (!cycles) GTEST_SKIP() << "Blender is not installed";
  const Estimate theirs = mean_of(cycles->image);
  EXPECT_NEAR(theirs.mean, expected, 4.5 * std::sqrt(theirs.variance) + 1e-4 * expected);
  EXPECT_LT(std::sqrt(theirs.variance), 2e-3 * expected) << "else nothing is tested";
}

TEST(Reference, CyclesDrawsGlassByFresnelsEquations) {
  const Shape clear = pane(test::glass(1.5));
  expect_from_cycles(looking_down({clear}, false), through_pane);
  expect_from_cycles(looking_down({clear}, true), 1.0 - through_pane);
}

TEST(Reference, CyclesTintsGlass) {
  Bsdf tinted = test::glass(1.5);
  tinted.reflectance = Rgb(0.9);
  tinted.transmittance = Rgb(0.8);
  const double f = reflectance(angle, 1.5);
  expect_from_cycles(looking_down({pane(tinted)}, false),
                     0.64 * (1 - f) * (1 - f) / (1 - 0.81 * f * f));
}

// Of its radiance, of which the glass holds n^2 times as much as the air, 1 - R gets out.
TEST(Reference, CyclesDrawsALampInABallOfGlass) {
  Scene scene;
  scene.shapes = {test::sphere({0, -1, 0}, 1.0, test::glass(1.8)),
                  test::sphere({0, -1, 0}, 0.7, test::diffuse(0.0), 1.0)};
  scene.camera =
      test::camera(Vec3(std::sin(angle), std::cos(angle), 0.0) * 2.0, {0, 0, 0}, 0.05, 64);
  expect_from_cycles(scene, (1.0 - reflectance(angle, 1.8)) / (1.8 * 1.8));
}

TEST(Reference, CyclesDrawsMetalsByFresnelsEquations) { expect_from_cycles(gold(), of_gold); }

void expect_from_povray(const Scene& scene, double expected) {
  const auto povray = draw_if_installed("povray", scene, {.quality = Quality::draft});
  if (!povray) GTEST_SKIP() << "POV-Ray is not installed";
  EXPECT_NEAR(mean_of(povray->image).mean, expected, 5e-4 * expected) << "half precision";
}

TEST(Reference, PovRayDrawsGlassByFresnelsEquations) {
  const Shape clear = pane(test::glass(1.5));
  expect_from_povray(looking_down({clear}, false), through_pane);
  expect_from_povray(looking_down({clear}, true), 1.0 - through_pane);
}

TEST(Reference, PovRayDrawsMetalsByFresnelsEquations) { expect_from_povray(gold(), of_gold); }

// A point lamp aslant above a small floor: albedo / pi * I cos / d^2.
Scene below_a_point() {
  Scene scene;
  scene.shapes = {test::parallelogram({-9, 0, -9}, {0, 0, 18}, {18, 0, 0}, test::diffuse(0.75))};
  scene.points = {{{3, 4, 0}, Rgb(80.0)}};
  scene.camera = test::camera({-1, 2, 0.5}, {0, 0, 0}, 0.05, 64);
  return scene;
}

const double of_a_point = 0.75 / std::numbers::pi * 80.0 * 0.8 / 25.0;

TEST(Reference, CyclesDrawsPointLamps) {
  const auto cycles = draw_if_installed("cycles", below_a_point(), {.samples_per_pixel = 4});
  if (!cycles) GTEST_SKIP() << "Blender is not installed";
  EXPECT_NEAR(mean_of(cycles->image).mean, of_a_point, 1e-4 * of_a_point);
}

TEST(Reference, PovRayDrawsPointLamps) { expect_from_povray(below_a_point(), of_a_point); }

// A ball sees half of the sky, wherever: its radiance is its albedo times the sky's.
TEST(Reference, CyclesDrawsASky) {
  Scene scene;
  scene.shapes = {test::sphere({0, 0, 0}, 1.0, test::diffuse(0.75))};
  scene.sky = Rgb(2.0);
  scene.camera = test::camera({3, 1, 2}, {0, 0, 0}, 3.0, 64);
  expect_from_cycles(scene, 1.5);
}

TEST(Reference, PovRayRefusesSkiesAndRoughMetals) {
  Scene sky = small_cornell();
  sky.sky = Rgb(1.0);
  EXPECT_THROW(draw("povray", sky, {}), std::invalid_argument);
  Scene rough = small_cornell();
  rough.shapes[0].bsdf = test::rough_metal(0.1, Rgb(0.2), Rgb(3.9));
  EXPECT_THROW(draw("povray", rough, {}), std::invalid_argument);
}

TEST(Reference, PovRayRefusesWhatItHasNot) {
  EXPECT_NE(complaint_of("povray", {.seeds = 2}).find("no samples or seeds"), std::string::npos);
  for (const Bsdf& bsdf : {test::mirror(0.9), test::glass(1.5)}) {
    Scene specular = small_cornell();
    specular.shapes[0].bsdf = bsdf;
    EXPECT_THROW(draw("povray", specular, {.bounces = {1, 1}}), std::invalid_argument);
  }
}

TEST(Reference, SettingsAreRefusedWhereThereAreNone) {
  EXPECT_EQ(complaint_of("mitsuba", {.overrides = {"sample_clamp_indirect=10"}}),
            "Mitsuba has no settings of its own that can be set");
}

TEST(Reference, ADifferenceOfBouncesLeavesOutWhatBothHave) {
  // Counts its runs, of which it draws none: the first one ends the picture.
  const FakeProgram povray("povray", "echo $@; exit 1");
  const std::string complaint = complaint_of("povray", {.bounces = {2, 2}});
  EXPECT_NE(complaint.find("Max_bounces=2"), std::string::npos) << complaint;
}

TEST(Reference, AMissingProgramIsAnsweredWithHowToInstallIt) {
  const std::string old_path = getenv("PATH");
  setenv("PATH", "/nonexistent", 1);
  EXPECT_NE(complaint_of("povray").find("apt-get install povray"), std::string::npos);
  EXPECT_NE(complaint_of("cycles").find("apt-get install blender"), std::string::npos);
  setenv("PATH", old_path.c_str(), 1);
}

TEST(Reference, AFailureNamesWhatTheProgramSaidLastAndItsLog) {
  const FakeProgram blender("blender", "echo one; echo 'out of luck'; exit 7");
  const std::string complaint = complaint_of("cycles");
  EXPECT_NE(complaint.find("out of luck"), std::string::npos) << complaint;
  EXPECT_NE(complaint.find("exit status 7"), std::string::npos) << complaint;
  EXPECT_NE(complaint.find(fake_log().string()), std::string::npos) << complaint;
  EXPECT_TRUE(fs::exists(fake_log()));
}

TEST(Reference, AFailureShowsTheLineThatNamesTheError) {
  const FakeProgram povray(
      "povray",
      "echo '==== [Parsing error?] ===='; echo 'Parse Error: no camera';"
      "echo 'Fatal error in parser: Cannot parse input.';"
      "echo 'Render failed'; echo; echo '  Fatal Stream to console.........On';"
      " echo ------- errors -------; exit 1");
  const std::string complaint = complaint_of("povray");
  EXPECT_NE(complaint.find("POV-Ray: Parse Error: no camera (exit status 1;"), std::string::npos)
      << complaint;
}

TEST(Reference, ADeathBySignalShowsItsNameAndTheLastWords) {
  const FakeProgram blender("blender", "echo 'Sample 3 of 64'; echo =====; kill -SEGV $$");
  const std::string complaint = complaint_of("cycles");
  EXPECT_NE(complaint.find("Cycles: Sample 3 of 64 (SIGSEGV: Segmentation fault;"),
            std::string::npos)
      << complaint;
  const FakeProgram silent("blender", "kill -KILL $$");
  const std::string second = complaint_of("cycles");
  EXPECT_NE(second.find("Cycles: said nothing (SIGKILL: Killed;"), std::string::npos) << second;
}

// A matte ball in a room of mirrors, which POV-Ray died of.
TEST(Reference, PovRayLivesInARoomOfMirrors) {
  Scene scene;
  scene.camera = test::camera(Vec3(0, 0, -0.9), Vec3(0), 60, 16);
  scene.shapes = test::room(Vec3(-1), Vec3(1), test::mirror(0.9));
  scene.shapes.push_back(test::sphere(Vec3(-0.4, -0.3, 0.2), 0.3, test::diffuse(0.7)));
  scene.shapes.push_back(test::sphere(Vec3(0.3, 0.2, 0.4), 0.1, test::diffuse(0.0), 1.0));
  const auto povray = draw_if_installed("povray", scene, {.quality = Quality::draft});
  if (!povray) GTEST_SKIP() << "POV-Ray is not installed";
  EXPECT_GT(mean_of(povray->image).mean, 0.0);
}

TEST(Reference, WhatIsDrawnOtherwiseIsSaid) {
  Scene scene = small_cornell();
  for (const OtherRenderer& renderer : other_renderers()) {
    EXPECT_EQ(renderer.drawn_otherwise(scene), "");
  }
  scene.camera.filter = {Filter::Kind::tent, 1.0};
  EXPECT_EQ(other_renderer("povray").drawn_otherwise(scene),
            "POV-Ray draws a box filter, the scene asks for tent 1");
  EXPECT_EQ(other_renderer("mitsuba").drawn_otherwise(scene), "");
}

TEST(Reference, AProgramThatDrawsNothingIsAnError) {
  const FakeProgram silent("blender", "exit 0");
  EXPECT_NE(complaint_of("cycles").find("report"), std::string::npos);
  const FakeProgram boastful("blender", "echo 'plumbline: {\"seconds\": 1}'");
  EXPECT_NE(complaint_of("cycles").find("picture.exr"), std::string::npos);
}

TEST(Reference, HeadingsMayInterruptAReport) {
  const FakeProgram povray("povray",
                           R"(printf 'plumbline: {"a":\n==== [Parsing...] ====\n 1}\n')"
                           R"(; echo 'Ray Tracer Version 3.7.0 Render Time: (1.5 seconds)')");
  EXPECT_NE(complaint_of("povray").find("picture.exr"), std::string::npos);
}

TEST(Reference, AStopBeforeTheFirstSeedGivesNoPicture) {
  const FakeProgram slow("blender", "sleep 60");
  const std::atomic<bool> now{true};
  EXPECT_EQ(draw("cycles", small_cornell(), {}, now).seeds, 0);
}

}  // namespace
}  // namespace plumb
