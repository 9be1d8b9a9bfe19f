// SPDX-License-Identifier: Apache-2.0

// What may be relied on about exported scene files.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "other_renderers/export.h"
#include "test_scenes.h"

namespace plumb {
namespace {

namespace fs = std::filesystem;

constexpr const char* hostile = "a\"\"\"'\n*/ #declare x = 1; import os; os.remove('x') // \\";

std::string text_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

fs::path fresh_folder() {
  fs::path folder = fs::temp_directory_path() /
                    ("plumb_export_" +
                     std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

std::string povray_scene(const Scene& scene) {
  return other_renderer("povray").format->text(scene);
}

std::string cycles_scene(const Scene& scene) {
  return other_renderer("cycles").format->text(scene);
}

Scene scene_with_hostile_names() {
  Scene scene;
  scene.name = hostile;
  scene.camera = test::camera(Vec3(0, 1, 4), Vec3(0, 1, 0), 60);
  scene.shapes = {
      test::sphere(Vec3(0), 1, test::diffuse(0.5)), test::sphere(Vec3(3), 1, test::mirror(0.5)),
      test::parallelogram(Vec3(0, 3, 0), Vec3(1, 0, 0), Vec3(0, 0, 1), test::diffuse(0.0), 5.0)};
  for (Shape& shape : scene.shapes) shape.id = hostile;
  return scene;
}

TEST(Export, KeepsOnlyPlainIdentifiers) {
  EXPECT_EQ(plain_identifier("short_block2"), "short_block2");
  EXPECT_EQ(plain_identifier("a b\"c\n\xc3\xa9"), "a_b_c___");
}

TEST(Export, LeavesNothingOfHostileNamesButTheirLetters) {
  Scene plain = scene_with_hostile_names();
  plain.name = plain_identifier(hostile);
  for (Shape& shape : plain.shapes) shape.id = plain.name;
  EXPECT_EQ(povray_scene(scene_with_hostile_names()), povray_scene(plain));
  EXPECT_EQ(cycles_scene(scene_with_hostile_names()), cycles_scene(plain));
}

TEST(Export, WritesNumbersInFullPrecision) {
  Scene scene = scene_with_hostile_names();
  std::get<Sphere>(scene.shapes[0].geometry).radius = 0.1234567890123456;
  EXPECT_NE(povray_scene(scene).find("0.1234567890123456"), std::string::npos);
  EXPECT_NE(cycles_scene(scene).find("0.1234567890123456"), std::string::npos);
}

Scene lamp_before_wall(double distance) {
  Scene scene;
  scene.camera = test::camera(Vec3(0, 1, 4), Vec3(0, 1, 0), 60);
  scene.shapes = {
      test::parallelogram(Vec3(-distance, 0, -1), Vec3(0, 2, 0), Vec3(0, 0, 4), test::diffuse(0.5)),
      test::parallelogram(Vec3(0, 1, 0), Vec3(1, 0, 0), Vec3(0, 0, 2), test::diffuse(0.0), 5.0)};
  return scene;
}

// The factors on the numbers of lights along x and along z.
std::pair<double, double> factors_of(const Scene& scene) {
  std::string text = povray_scene(scene);
  text = text.substr(text.rfind("_lamp("));
  const size_t begin = text.find_last_of('>') + 2;
  char* end = nullptr;
  const double along_x = std::strtod(&text[begin], &end);
  return {along_x, std::strtod(end + 1, nullptr)};
}

TEST(Export, PovRaysLampsHaveMoreLightsBesideWhatTheyShineOn) {
  EXPECT_EQ(factors_of(lamp_before_wall(1.0)), std::pair(1.0, 1.0));
  // With factor 1 a step is an eighth of the side; with these it is as long as the distance.
  const auto [along_x, along_z] = factors_of(lamp_before_wall(1.0 / 16));
  EXPECT_NEAR(along_x, 2.0, 0.1);
  EXPECT_NEAR(along_z, 4.0, 0.2);
  EXPECT_EQ(factors_of(lamp_before_wall(0.0)), std::pair(4.0, 4.0));
}

TEST(Export, OnlyWhatALampShinesOnCountsAsNear) {
  Scene scene = lamp_before_wall(0.0);
  scene.shapes[0].bsdf.reflectance = Rgb(0.0);
  EXPECT_EQ(factors_of(scene), std::pair(1.0, 1.0)) << "a black wall";
  scene = lamp_before_wall(0.01);
  auto& corners = std::get<Mesh>(scene.shapes[0].geometry)[0].corners;
  std::swap(corners[1], corners[3]);
  EXPECT_EQ(factors_of(scene), std::pair(1.0, 1.0)) << "a wall's black back";
  scene.shapes[0].bsdf.two_sided = true;
  EXPECT_EQ(factors_of(scene), std::pair(4.0, 4.0));
  // The lamp faces down.
  scene.shapes[0] = test::parallelogram(Vec3(-1, 1.001, -1), Vec3(3, 0, 0), Vec3(0, 0, 4),
                                        test::diffuse(0.5, true));
  EXPECT_EQ(factors_of(scene), std::pair(1.0, 1.0)) << "what is behind";
}

TEST(Export, LampsThatAreNoRectanglesAreTriangles) {
  Scene scene = lamp_before_wall(1.0);
  auto& corners = std::get<Mesh>(scene.shapes[1].geometry)[0].corners;
  corners[2].x += 1.0;
  const std::string text = povray_scene(scene);
  EXPECT_EQ(text.find("Rectangle_lamp"), std::string::npos);
  EXPECT_NE(text.find("Triangle_lamp(<0, 1, 0>, <1, 1, 0>, <2, 1, 2>, "), std::string::npos);
  EXPECT_NE(text.find("Triangle_lamp(<0, 1, 0>, <2, 1, 2>, <0, 1, 2>, "), std::string::npos);
}

TEST(Export, PovRaysLargeMeshesAreMeshesAndMirrorsWhole) {
  Scene scene = lamp_before_wall(1.0);
  auto& polygons = std::get<Mesh>(scene.shapes[0].geometry);
  scene.shapes[0].bsdf.kind = Bsdf::Kind::conductor;
  EXPECT_NE(povray_scene(scene).find("split_union off"), std::string::npos);
  const Polygon wall = polygons[0];
  polygons.assign(1000, wall);
  const std::string text = povray_scene(scene);
  EXPECT_NE(text.find("mesh {"), std::string::npos);
  EXPECT_EQ(text.find("split_union off"), std::string::npos) << "meshes have none";
}

// What is in a ball of glass around the origin, seen from outside.
Scene in_glass(double ior, const Shape& thing) {
  Scene scene;
  scene.camera = test::camera(Vec3(0, 1, 4), Vec3(0), 60);
  scene.shapes = {test::sphere(Vec3(0), 1, test::glass(ior)), thing};
  return scene;
}

TEST(Export, GlassAndMetalsHaveTheirIndices) {
  Bsdf green = test::glass(1.5);
  green.transmittance = Rgb(0.5, 1.0, 0.5);
  Scene scene = in_glass(1.25, test::sphere(Vec3(3), 0.5, green));
  EXPECT_NE(cycles_scene(scene).find("glass=1.5, transmittance=(0.5, 1, 0.5)"), std::string::npos);
  EXPECT_NE(povray_scene(scene).find("Glass(<1, 1, 1>, <1, 1, 1>, 1.25)"), std::string::npos);
  EXPECT_NE(povray_scene(scene).find("Glass(<1, 1, 1>, <0.5, 1, 0.5>, 1.5)"), std::string::npos);
  scene.shapes[1].bsdf = test::metal(Rgb(0.25), Rgb(3.5));
  EXPECT_NE(cycles_scene(scene).find("eta=(0.25, 0.25, 0.25), k=(3.5, 3.5, 3.5)"),
            std::string::npos);
  EXPECT_NE(povray_scene(scene).find("Metal(<1, 1, 1>, <0.25, 0.25, 0.25>, <3.5, 3.5, 3.5>, no)"),
            std::string::npos);
}

// Cycles leaves radiance as it is where light goes from one index into another.
TEST(Export, CyclesLampsHaveTheRadianceThatTheCamerasSurroundingsMakeOfIt) {
  Scene scene = in_glass(2.0, test::sphere(Vec3(0), 0.5, test::diffuse(0.0), 8.0));
  EXPECT_NE(cycles_scene(scene).find("radiance=(2, 2, 2)"), std::string::npos);
  scene.camera.origin = Vec3(0, 0, 0.75);
  EXPECT_NE(cycles_scene(scene).find("radiance=(8, 8, 8)"), std::string::npos);
  std::get<Sphere>(scene.shapes[1].geometry).center = Vec3(0, 3, 0);
  EXPECT_NE(cycles_scene(scene).find("radiance=(32, 32, 32)"), std::string::npos);
}

TEST(Export, RefusesGlassThatEnclosesNothing) {
  const Scene scene = in_glass(
      1.0, test::parallelogram(Vec3(-1, -1, 2), Vec3(2, 0, 0), Vec3(0, 2, 0), test::glass(1.5)));
  EXPECT_THROW(cycles_scene(scene), std::invalid_argument);
  EXPECT_THROW(povray_scene(scene), std::invalid_argument);
}

TEST(Export, RefusesLampsThatAreHalfInGlass) {
  const Shape lamp = test::icosphere(Vec3(0, 0, 1), 0.5, 1, test::diffuse(0.0), 1.0);
  EXPECT_THROW(cycles_scene(in_glass(1.5, lamp)), std::invalid_argument);
}

// Its photons carry into glass what its gathering rays don't find there; and glass within a solid
// reflects nothing inside.
TEST(Export, RefusesWhatPovRayDrawsWronglyInGlass) {
  for (const Shape& thing : {test::sphere(Vec3(0), 0.5, test::diffuse(0.0), 1.0),
                             test::sphere(Vec3(0), 0.5, test::diffuse(0.5)),
                             test::sphere(Vec3(0), 0.5, test::glass(1.2))}) {
    EXPECT_THROW(povray_scene(in_glass(1.5, thing)), std::invalid_argument);
    EXPECT_NO_THROW(povray_scene(in_glass(1.0, thing)));
  }
  Scene scene = in_glass(1.5, test::sphere(Vec3(0), 0.5, test::mirror(0.5)));
  EXPECT_NO_THROW(povray_scene(scene));
  scene.camera.origin = Vec3(0, 0, 0.75);
  EXPECT_THROW(povray_scene(scene), std::invalid_argument);
  EXPECT_THROW(povray_scene(in_glass(1.5, test::sphere(Vec3(9), 1, test::glass(1.5), 1.0))),
               std::invalid_argument)
      << "a lamp of glass";
  EXPECT_THROW(povray_scene(in_glass(1.5, test::sphere(Vec3(0), 9, test::diffuse(0.5, true)))),
               std::invalid_argument)
      << "a camera in a ball";
}

TEST(Export, SaysThatPovRayTintsReflectionsOtherwise) {
  Scene scene = in_glass(1.5, test::sphere(Vec3(0), 0.5, test::mirror(0.5)));
  EXPECT_EQ(povray_scene(scene).find("glass transmit"), std::string::npos);
  scene.shapes[0].bsdf.reflectance = Rgb(0.5);
  EXPECT_NE(povray_scene(scene).find("glass transmit"), std::string::npos);
}

TEST(Export, SaysWhichFilterIsDrawnOtherwise) {
  Scene scene = lamp_before_wall(1.0);
  EXPECT_EQ(povray_scene(scene).find("filter"), std::string::npos);
  EXPECT_EQ(cycles_scene(scene).find("filter"), std::string::npos);
  scene.camera.filter = {Filter::Kind::tent, 1.0};
  EXPECT_NE(povray_scene(scene).find("draws a box filter, the scene asks for tent 1\n"),
            std::string::npos);
  EXPECT_NE(cycles_scene(scene).find("draws a box filter, the scene asks for tent 1\n"),
            std::string::npos);
  scene.camera.filter = {Filter::Kind::gaussian, 0.5, true};
  EXPECT_NE(cycles_scene(scene).find("gaussian_width=2)"), std::string::npos);
  EXPECT_EQ(cycles_scene(scene).find("box"), std::string::npos);
  scene.camera.filter.size = 3.0;
  EXPECT_NE(cycles_scene(scene).find("draws a box filter"), std::string::npos);
}

TEST(Export, PutsTheScriptBesideTheFile) {
  const fs::path folder = fresh_folder();
  const Scene scene = scene_with_hostile_names();
  for (const OtherRenderer& renderer : other_renderers()) {
    if (!renderer.format) continue;
    const fs::path file = folder / ("a" + renderer.format->extension);
    EXPECT_EQ(export_scene(renderer, scene, file), folder / renderer.script_name);
    EXPECT_EQ(text_of(file), renderer.format->text(scene));
    EXPECT_EQ(text_of(folder / renderer.script_name), renderer.script);
  }
}

TEST(Export, RefusesWhatCannotBeWritten) {
  const Scene scene = scene_with_hostile_names();
  const std::string word = "povray";
  const OtherRenderer& povray = other_renderer(word);
  EXPECT_THROW(export_scene(povray, scene, "/nonexistent/a.pov"), std::runtime_error);
  EXPECT_THROW(export_scene(povray, scene, fresh_folder() / "plumbline.inc"), std::runtime_error);
}

}  // namespace
}  // namespace plumb
