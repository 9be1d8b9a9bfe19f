// SPDX-License-Identifier: Apache-2.0

#include "scene_files/scene_reader.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <clocale>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

namespace fs = std::filesystem;

const std::string film = R"(<film type="hdrfilm"><rfilter type="box"/></film>)";
const std::string sensor =
    R"(<sensor type="perspective"><float name="fov" value="40"/>)" + film + "</sensor>";
const std::string face_normals = R"(<boolean name="face_normals" value="true"/>)";

class SceneReader : public testing::Test {
 protected:
  SceneReader() {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / fmt::format("plumb_{}_{}", test->name(), getpid());
    fs::create_directories(folder_);
  }
  ~SceneReader() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }

  // A scene with a sensor on line 2 and the elements from line 3 on.
  Scene read(const std::string& elements) const {
    return read_scene(write(
        "test.xml", fmt::format("<scene version=\"3.0.0\">\n{}\n{}\n</scene>", sensor, elements)));
  }
  Shape read_shape(const std::string& type, const std::string& inside) const {
    return read(fmt::format(R"(<shape type="{}">{}</shape>)", type, inside)).shapes.at(0);
  }
  Mesh read_mesh(const std::string& type, const std::string& steps = "") const {
    const std::string transform =
        fmt::format(R"(<transform name="to_world">{}</transform>)", steps);
    return std::get<Mesh>(read_shape(type, transform).geometry);
  }
  Sphere read_sphere(const std::string& inside) const {
    return std::get<Sphere>(read_shape("sphere", inside).geometry);
  }
  Mesh read_obj(const std::string& text, const std::string& steps = "") const {
    write("test.obj", text);
    return std::get<Mesh>(read_shape("obj", R"(<string name="filename" value="test.obj"/>)" +
                                                face_normals + R"(<transform name="to_world">)" +
                                                steps + "</transform>")
                              .geometry);
  }
  Camera read_camera(const std::string& inside) const {
    return read_scene(write("test.xml", R"(<scene version="3.0.0"><sensor type="perspective">)" +
                                            inside + "</sensor></scene>"))
        .camera;
  }
  Camera read_placed_camera(const std::string& steps) const {
    return read_camera(R"(<float name="fov" value="40"/>)" + film +
                       R"(<transform name="to_world">)" + steps + "</transform>");
  }

  static std::string error_of(const fs::path& file) {
    try {
      read_scene(file);
    } catch (const SceneError& error) {
      return error.what();
    }
    return "not refused";
  }

  // A line of the message starts with the file and the line, and holds these words.
  static void expect_message(const std::string& message, const fs::path& file, int line,
                             const std::string& words) {
    std::istringstream lines(message);
    bool is_told = false;
    for (std::string text; std::getline(lines, text);) {
      is_told |= text.starts_with(fmt::format("{}:{}: ", file.string(), line)) &&
                 text.find(words) != text.npos;
    }
    EXPECT_TRUE(is_told) << message << "\nis not about line " << line << ", " << words;
  }

  fs::path folder_;
};

void expect_near(const Vec3& actual, const Vec3& expected) {
  EXPECT_LT((actual - expected).length(), 1e-12)
      << fmt::format("({}, {}, {}) is not ({}, {}, {})", actual.x, actual.y, actual.z, expected.x,
                     expected.y, expected.z);
}

void expect_corners(const Polygon& polygon, const std::vector<Vec3>& expected) {
  ASSERT_EQ(polygon.corners.size(), expected.size());
  for (size_t i = 0; i < expected.size(); ++i) expect_near(polygon.corners[i], expected[i]);
}

std::string diffuse(const std::string& value) {
  return fmt::format(R"(<bsdf type="diffuse"><rgb name="reflectance" value="{}"/></bsdf>)", value);
}

// The scene.

TEST_F(SceneReader, NamesASceneAfterItsFileOrItsFolder) {
  const std::string text = "<scene version=\"3.0.0\">" + sensor + "</scene>";
  EXPECT_EQ(read_scene(write("box.xml", text)).name, "box");
  EXPECT_EQ(read_scene(write("scene.xml", text)).name, folder_.filename().string());
}

TEST_F(SceneReader, HashesTheFileAndTheObjFilesInOrder) {
  write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const std::string shape =
      R"(<shape type="obj"><string name="filename" value="a.obj"/>)" + face_normals + "</shape>";
  const fs::path file =
      write("test.xml", R"(<scene version="3.0.0">)" + sensor + shape + "</scene>\n");
  // sha1sum of test.xml and a.obj, one after the other
  EXPECT_EQ(read_scene(file).hash, "c240d4f487a1f36b5b5bb56f982aa051ef42865a");
  write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n");
  EXPECT_NE(read_scene(file).hash, "c240d4f487a1f36b5b5bb56f982aa051ef42865a");
}

TEST_F(SceneReader, ReadsASceneWithoutShapes) {
  EXPECT_TRUE(read("").shapes.empty());
  EXPECT_TRUE(read("<!-- nothing -->").shapes.empty());
}

TEST_F(SceneReader, KeepsShapesInOrderWithTheirIdsOrCallsThemByTheirPlace) {
  const Scene scene = read(R"(<shape type="cube" id="b"/><shape type="sphere" id="a"/>)"
                           R"(<shape type="sphere"/>)");
  ASSERT_EQ(scene.shapes.size(), 3u);
  EXPECT_EQ(scene.shapes[0].id, "b");
  EXPECT_EQ(scene.shapes[1].id, "a");
  EXPECT_EQ(scene.shapes[2].id, "#2");
}

TEST_F(SceneReader, ReplacesDefaults) {
  EXPECT_EQ(read_sphere(R"(<float name="radius" value="2"/>)").radius, 2.0);
  const auto radius = [&](const std::string& defaults, const std::string& value) {
    const Scene scene = read(defaults + R"(<shape type="sphere"><float name="radius" value=")" +
                             value + R"("/></shape>)");
    return std::get<Sphere>(scene.shapes.at(0).geometry).radius;
  };
  EXPECT_EQ(radius(R"(<default name="r" value="3"/>)", "$r"), 3.0);
  EXPECT_EQ(radius(R"(<default name="r" value="3"/>)", "1$r.5"), 13.5);
  EXPECT_EQ(radius(R"(<default name="r" value="3"/><default name="rr" value="4"/>)", "$rr"), 4.0);
  EXPECT_EQ(radius(R"(<default name="r" value="3"/><default name="s" value="$r"/>)", "$s"), 3.0);
}

// The camera.

TEST_F(SceneReader, LooksAlongZWithXToTheLeftUnlessTransformed) {
  const Camera camera = read("").camera;
  expect_near(camera.origin, {0, 0, 0});
  expect_near(camera.forward, {0, 0, 1});
  expect_near(camera.right, {-1, 0, 0});
  expect_near(camera.up, {0, 1, 0});
  EXPECT_EQ(camera.fov_degrees, 40.0);
  EXPECT_EQ(camera.fov_axis, Camera::FovAxis::x);
  EXPECT_EQ(camera.width, 768);
  EXPECT_EQ(camera.height, 576);
}

TEST_F(SceneReader, PlacesTheCamera) {
  const Camera camera =
      read_placed_camera(R"(<lookat origin="1,2,3" target="1,2,-5" up="1,1,0"/>)");
  expect_near(camera.origin, {1, 2, 3});
  expect_near(camera.forward, {0, 0, -1});
  expect_near(camera.right, Vec3(1, -1, 0).normalized());
  expect_near(camera.up, Vec3(1, 1, 0).normalized());
}

TEST_F(SceneReader, MirrorsTheImageAsMitsubaDoes) {
  const Camera camera = read_placed_camera(R"(<scale x="-1"/>)");
  expect_near(camera.right, {1, 0, 0});
  expect_near(camera.up, {0, 1, 0});
  expect_near(camera.forward, {0, 0, 1});
}

TEST_F(SceneReader, ReadsTheFovAxis) {
  using Axis = Camera::FovAxis;
  const std::pair<std::string, Axis> axes[] = {{"x", Axis::x},
                                               {"y", Axis::y},
                                               {"diagonal", Axis::diagonal},
                                               {"smaller", Axis::smaller},
                                               {"larger", Axis::larger}};
  for (const auto& [name, axis] : axes) {
    const Camera camera = read_camera(R"(<float name="fov" value="1e1"/>)" + film +
                                      R"(<string name="fov_axis" value=")" + name + "\"/>");
    EXPECT_EQ(camera.fov_axis, axis);
    EXPECT_EQ(camera.fov_degrees, 10.0);
  }
}

TEST_F(SceneReader, ReadsTheFilm) {
  const Camera camera = read_camera(R"(<float name="fov" value="40"/><film type="hdrfilm" id="f">
      <integer name="width" value="640"/><integer name="height" value="8192"/>
      <string name="pixel_format" value="rgb"/><string name="component_format" value="float32"/>
      <rfilter type="box"/></film>)");
  EXPECT_EQ(camera.width, 640);
  EXPECT_EQ(camera.height, 8192);
}

// Shapes.

TEST_F(SceneReader, ReadsARectangle) {
  const Mesh mesh = read_mesh("rectangle");
  ASSERT_EQ(mesh.size(), 1u);
  expect_corners(mesh[0], {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}});
  expect_near(mesh[0].normal(), {0, 0, 1});
}

TEST_F(SceneReader, KeepsARectanglesNormalOnItsSideWhenMirrored) {
  expect_near(read_mesh("rectangle", R"(<scale x="-1"/>)")[0].normal(), {0, 0, 1});
  expect_near(read_mesh("rectangle", R"(<scale z="-1"/>)")[0].normal(), {0, 0, -1});
  expect_near(read_mesh("rectangle", R"(<scale value="-1"/>)")[0].normal(), {0, 0, -1});
}

TEST_F(SceneReader, ReadsACubeWithNormalsOutwards) {
  for (const std::string steps : {"", R"(<scale x="-1"/>)", R"(<scale value="-1"/>)"}) {
    const Mesh mesh = read_mesh("cube", steps);
    ASSERT_EQ(mesh.size(), 6u);
    Vec3 sum(0.0);
    for (const Polygon& face : mesh) {
      ASSERT_EQ(face.corners.size(), 4u);
      expect_near((face.corners[0] + face.corners[1] + face.corners[2] + face.corners[3]) / 4.0,
                  face.normal());
      EXPECT_DOUBLE_EQ((face.corners[0] - face.corners[1]).length(), 2.0);
      EXPECT_DOUBLE_EQ((face.corners[1] - face.corners[2]).length(), 2.0);
      sum += face.normal() * face.normal();
    }
    expect_near(sum, {2, 2, 2});
  }
}

TEST_F(SceneReader, ReadsASphere) {
  expect_near(read_sphere("").center, {0, 0, 0});
  EXPECT_EQ(read_sphere("").radius, 1.0);
  const Sphere sphere =
      read_sphere(R"(<point name="center" x="1" y="2" z="3"/><float name="radius" value="2"/>
                     <transform name="to_world"><scale value="2"/><translate x="1"/></transform>)");
  expect_near(sphere.center, {3, 4, 6});
  EXPECT_NEAR(sphere.radius, 4.0, 1e-12);
  expect_near(read_sphere(R"(<point name="center" value="1, 2, 3"/>)").center, {1, 2, 3});
}

TEST_F(SceneReader, ReadsObjFacesAsTheyAre) {
  const Mesh mesh = read_obj(
      "# two faces\r\nmtllib none.mtl\no one\ng two\ns off\nusemtl three\n"
      "v 0 0 0\nv 1 0 0 # a corner\n  v\t1 1 0\nv 0 1 -0.0\nv 5e-1 .5 +2.\nvn 0 0 1\nvt 0 0\n\n"
      "f 1 2 3 4\nf 1/1/1 2//1 5/1\n");
  ASSERT_EQ(mesh.size(), 2u);
  expect_corners(mesh[0], {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  expect_corners(mesh[1], {{0, 0, 0}, {1, 0, 0}, {0.5, 0.5, 2}});
}

TEST_F(SceneReader, TransformsObjFacesAndKeepsTheOrderOfTheirCorners) {
  const Mesh mesh = read_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", R"(<scale x="-1"/>)");
  expect_corners(mesh.at(0), {{0, 0, 0}, {-1, 0, 0}, {0, 1, 0}});
  expect_near(mesh[0].normal(), {0, 0, -1});
}

TEST_F(SceneReader, ReadsObjNumbersInDoublePrecision) {
  EXPECT_EQ(read_obj("v 0 0 0\nv 552.8 0 0\nv 0 1 0\nf 1 2 3")[0].corners[1].x, 552.8);
}

TEST_F(SceneReader, CutsQuadsThatAreNotFlatOrNotConvex) {
  for (const std::string third : {"1 1 0.001", "0.2 0.2 0"}) {
    const Mesh mesh = read_obj("v 0 0 0\nv 1 0 0\nv " + third + "\nv 0 1 0\nf 1 2 3 4\n");
    ASSERT_EQ(mesh.size(), 2u) << third;
    const Vec3 c = mesh[0].corners[2];
    expect_corners(mesh[0], {{0, 0, 0}, {1, 0, 0}, c});
    expect_corners(mesh[1], {{0, 0, 0}, c, {0, 1, 0}});
  }
  EXPECT_EQ(read_obj("v 0 0 0\nv 1 0 0\nv 1 1 1e-7\nv 0 1 0\nf 1 2 3 4\n").size(), 1u);
}

// BSDFs and lamps.

TEST_F(SceneReader, GivesShapesADiffuseBsdfUnlessToldOtherwise) {
  for (const std::string inside : {"", R"(<bsdf type="diffuse"/>)"}) {
    const Shape shape = read_shape("cube", inside);
    EXPECT_EQ(shape.bsdf.kind, Bsdf::Kind::diffuse);
    EXPECT_EQ(shape.bsdf.reflectance, Rgb(0.5));
    EXPECT_FALSE(shape.bsdf.two_sided);
    EXPECT_FALSE(shape.is_lamp());
  }
}

TEST_F(SceneReader, ReadsColours) {
  const auto reflectance = [&](const std::string& value) {
    return read_shape("cube", diffuse(value)).bsdf.reflectance;
  };
  const Rgb expected(0.1, 0.25, 1.0);
  for (const std::string value :
       {"0.1 0.25 1", "0.1, 0.25, 1", "0.1,0.25,1", " .1\n+0.25 ,1e0 ", "0.1\t25e-2  1."}) {
    EXPECT_EQ(reflectance(value), expected) << value;
  }
  EXPECT_EQ(reflectance("0.3"), Rgb(0.3));
}

TEST_F(SceneReader, ReadsAConductor) {
  const std::string none = R"(<string name="material" value="none"/>)";
  Bsdf bsdf = read_shape("cube", R"(<bsdf type="conductor">)" + none + "</bsdf>").bsdf;
  EXPECT_EQ(bsdf.kind, Bsdf::Kind::conductor);
  EXPECT_EQ(bsdf.reflectance, Rgb(1.0));
  EXPECT_FALSE(bsdf.two_sided);
  bsdf = read_shape("cube",
                    R"(<bsdf type="conductor"><rgb name="specular_reflectance" value="0.9"/>)" +
                        none + "</bsdf>")
             .bsdf;
  EXPECT_EQ(bsdf.reflectance, Rgb(0.9));
}

TEST_F(SceneReader, ReadsRoughMetals) {
  const auto read_rough = [&](const std::string& inside) {
    return read_shape("sphere", R"(<bsdf type="roughconductor">)"
                                R"(<string name="distribution" value="ggx"/>)" +
                                    inside + "</bsdf>")
        .bsdf;
  };
  EXPECT_EQ(read_rough("").alpha, 0.1);
  EXPECT_FALSE(read_rough("").is_metal());
  EXPECT_FALSE(read_rough("").is_specular());
  const Bsdf gold = read_rough(
      R"(<string name="material" value="Au"/><float name="alpha_u" value="0.3"/>)"
      R"(<float name="alpha_v" value="0.3"/><boolean name="sample_visible" value="true"/>)");
  EXPECT_EQ(gold.alpha, 0.3);
  EXPECT_EQ(gold.k, Rgb(3.983, 2.38556, 1.60336));
}

TEST_F(SceneReader, ReadsSkiesAndPoints) {
  EXPECT_FALSE(read("").has_lamps());
  const Scene sky =
      read(R"(<emitter type="constant"><rgb name="radiance" value="1, 2, 3"/></emitter>)");
  EXPECT_EQ(sky.sky, Rgb(1, 2, 3));
  EXPECT_EQ(read(R"(<emitter type="constant"/>)").sky, Rgb(1.0));
  const Scene points = read(R"(<emitter type="point"><point name="position" x="1" y="2" z="3"/>)"
                            R"(<rgb name="intensity" value="4, 5, 6"/></emitter>)"
                            R"(<emitter type="point"><transform name="to_world"><scale value="2"/>)"
                            R"(<translate x="7"/></transform></emitter>)");
  ASSERT_EQ(points.points.size(), 2u);
  EXPECT_EQ(points.points[0].position, Vec3(1, 2, 3));
  EXPECT_EQ(points.points[0].intensity, Rgb(4, 5, 6));
  EXPECT_EQ(points.points[1].position, Vec3(7, 0, 0));
  EXPECT_EQ(points.points[1].intensity, Rgb(1.0));
}

TEST_F(SceneReader, ReadsMetals) {
  const auto read_metal = [&](const std::string& inside) {
    return read_shape("sphere", R"(<bsdf type="conductor">)" + inside + "</bsdf>").bsdf;
  };
  const auto of_material = [&](const std::string& name) {
    return read_metal(R"(<string name="material" value=")" + name + "\"/>");
  };
  const Bsdf mirror = read_metal("");
  EXPECT_EQ(mirror.kind, Bsdf::Kind::conductor);
  EXPECT_FALSE(mirror.is_metal());
  EXPECT_EQ(mirror.reflectance, Rgb(1.0));
  // Values of Mitsuba 3.9.1, traverse(load_dict(...)).
  const Bsdf gold = of_material("Au");
  EXPECT_EQ(gold.eta, Rgb(0.143036, 0.375307, 1.44205));
  EXPECT_EQ(gold.k, Rgb(3.983, 2.38556, 1.60336));
  EXPECT_EQ(gold.reflectance, Rgb(1.0));
  EXPECT_EQ(of_material("Cu").eta, Rgb(0.201005, 0.92375, 1.10222));
  EXPECT_EQ(of_material("Cu_palik").eta, Rgb(0.213229, 0.919715, 1.10241));
  EXPECT_EQ(of_material("Hg_palik").k, of_material("Hg").k);
  // Neither refracts nor absorbs in red: a perfect mirror has another k there, with the same
  // picture.
  EXPECT_EQ(of_material("AlSb").eta, Rgb(0, 4.13937, 4.66925));
  EXPECT_EQ(of_material("AlSb").k, Rgb(1, 0.0940091, 1.30057));
  EXPECT_EQ(read_metal(R"(<rgb name="eta" value="0"/><rgb name="k" value="0"/>)").k, Rgb(1.0));
  // What is missing of the two is as in Mitsuba.
  const std::string none = R"(<string name="material" value="none"/>)";
  EXPECT_EQ(read_metal(none + R"(<rgb name="eta" value="1, 2, 3"/>)").eta, Rgb(1, 2, 3));
  EXPECT_EQ(read_metal(R"(<float name="eta" value="2"/>)").k, Rgb(1.0));
  EXPECT_EQ(read_metal(R"(<integer name="k" value="2"/>)").k, Rgb(2.0));
  EXPECT_EQ(read_metal(R"(<spectrum name="k" value="2"/>)").eta, Rgb(0.0));
  const Rgb spectrum = read_metal(R"(<spectrum name="eta" value="400:2, 500:2.5, 700:3"/>)").eta;
  EXPECT_LT((spectrum - Rgb(2.83552, 2.61643, 2.21175)).length(), 1e-5);
}

TEST_F(SceneReader, ReadsGlass) {
  const auto read_glass = [&](const std::string& inside) {
    return read_shape("sphere", R"(<bsdf type="dielectric">)" + inside + "</bsdf>").bsdf;
  };
  const Bsdf plain = read_glass("");
  EXPECT_EQ(plain.kind, Bsdf::Kind::dielectric);
  EXPECT_EQ(plain.ior, 1.5046 / 1.000277);  // bk7 in air
  EXPECT_EQ(plain.reflectance, Rgb(1.0));
  EXPECT_EQ(plain.transmittance, Rgb(1.0));
  EXPECT_TRUE(plain.two_sided);
  const std::string one = R"(<float name="ext_ior" value="1"/>)";
  EXPECT_EQ(read_glass(one + R"(<float name="int_ior" value="1.3"/>)").ior, 1.3);
  EXPECT_EQ(read_glass(one + R"(<string name="int_ior" value="WATER"/>)").ior, 1.333);
  EXPECT_EQ(read_glass(one + R"(<string name="int_ior" value="Water Ice"/>)").ior, 1.31);
  EXPECT_EQ(read_glass(R"(<string name="int_ior" value="vacuum"/>)"
                       R"(<string name="ext_ior" value="diamond"/>)")
                .ior,
            1.0 / 2.419);
  const Bsdf tinted = read_glass(R"(<rgb name="specular_reflectance" value="0.5, 0.6, 0.7"/>)"
                                 R"(<float name="specular_transmittance" value="0.25"/>)");
  EXPECT_EQ(tinted.reflectance, Rgb(0.5, 0.6, 0.7));
  EXPECT_EQ(tinted.transmittance, Rgb(0.25));
}

TEST_F(SceneReader, TurnsGlassInsideOut) {
  const std::string water = R"(<boolean name="flip_normals" value="true"/>)"
                            R"(<bsdf type="dielectric"><float name="int_ior" value="1.25"/>)"
                            R"(<float name="ext_ior" value="1"/></bsdf>)";
  EXPECT_EQ(read_shape("sphere", water).bsdf.ior, 0.8);
  const Shape cube = read_shape("cube", water);
  EXPECT_EQ(cube.bsdf.ior, 1.25);
  const Polygon& face = std::get<Mesh>(cube.geometry)[0];
  expect_near(face.corners[0] + face.corners[2], face.normal() * -2.0);
}

// Glass that touches something. The scenes' half diagonals are those of the floor and the glass.

class AirGap : public SceneReader {
 protected:
  static std::string box(const std::string& type, const std::string& steps,
                         const std::string& bsdf) {
    return fmt::format(R"(<shape type="{}"{}><transform name="to_world">{}</transform>)"
                       R"(<bsdf type="{}"/></shape>)",
                       type, steps.empty() ? R"( id="one")" : "", steps, bsdf);
  }
  static double lowest(const Shape& shape, int axis) {
    double low = 1e9;
    for (const Polygon& face : std::get<Mesh>(shape.geometry)) {
      for (const Vec3& corner : face.corners) low = std::min(low, corner[axis]);
    }
    return low;
  }
  static double highest(const Shape& shape, int axis) {
    double high = -1e9;
    for (const Polygon& face : std::get<Mesh>(shape.geometry)) {
      for (const Vec3& corner : face.corners) high = std::max(high, corner[axis]);
    }
    return high;
  }
};

const std::string floor_below =
    R"(<scale value="3"/><rotate x="1" angle="-90"/><translate y="-1"/>)";

TEST_F(AirGap, LiftsGlassFromTheFloorAndMovesNothingElse) {
  const Scene scene =
      read(box("rectangle", floor_below, "diffuse") + box("cube", "", "dielectric"));
  const Shape& glass = scene.shapes[1];
  const double gap = 3e-5 * Vec3(3, 1, 3).length();
  EXPECT_NEAR(lowest(glass, 1), -1.0 + gap, 1e-12);
  EXPECT_EQ(highest(glass, 1), 1.0);
  for (const int axis : {0, 2}) {
    EXPECT_EQ(lowest(glass, axis), -1.0);
    EXPECT_EQ(highest(glass, axis), 1.0);
  }
  EXPECT_EQ(lowest(scene.shapes[0], 1), highest(scene.shapes[0], 1));
  ASSERT_EQ(scene.notes.size(), 1u);
  EXPECT_TRUE(
      scene.notes[0].ends_with("the glass one touches another surface: it is drawn thinner "
                               "by 0.0065 %, with air in between"))
      << scene.notes[0];
}

TEST_F(AirGap, KeepsAThinPaneAsWideAsItIs) {
  const std::string thin = R"(<scale y="0.001"/><translate y="-0.999"/>)";
  const Scene scene =
      read(box("rectangle", floor_below, "diffuse") + box("cube", thin, "dielectric"));
  EXPECT_EQ(highest(scene.shapes[1], 0), 1.0);
  EXPECT_GT(lowest(scene.shapes[1], 1), -1.0 + 1e-4);
  EXPECT_EQ(scene.notes.size(), 1u);
}

TEST_F(AirGap, PartsTwoBlocksOfGlassByMakingOneThinner) {
  const Scene scene = read(box("cube", "", "dielectric") +
                           box("cube", R"(<translate x="2" y="0.5"/>)", "dielectric"));
  EXPECT_LT(highest(scene.shapes[0], 0), 1.0 - 5e-5);
  EXPECT_EQ(lowest(scene.shapes[0], 0), -1.0);
  EXPECT_EQ(lowest(scene.shapes[1], 0), 1.0);
  EXPECT_EQ(scene.notes.size(), 1u);
}

TEST_F(AirGap, IsMadeOnAllSidesThatTouch) {
  const Scene scene =
      read(box("cube", "", "dielectric") + box("cube", R"(<scale value="1"/>)", "diffuse"));
  for (const int axis : {0, 1, 2}) {
    EXPECT_GT(lowest(scene.shapes[0], axis), -1.0 + 4e-5);
    EXPECT_LT(highest(scene.shapes[0], axis), 1.0 - 4e-5);
  }
  EXPECT_EQ(scene.notes.size(), 1u);
}

TEST_F(AirGap, KeepsFacesThatAreAslantFlat) {
  const std::string turn = R"(<rotate value="0.6 0.8 0" angle="40"/>)";
  const Scene scene =
      read(box("rectangle", floor_below + turn, "diffuse") + box("cube", turn, "dielectric"));
  for (const Polygon& face : std::get<Mesh>(scene.shapes[1].geometry)) {
    EXPECT_TRUE(face.is_parallelogram());
  }
  EXPECT_EQ(scene.notes.size(), 1u);
}

TEST_F(AirGap, CannotBeMadeOfAPaneWithoutThickness) {
  const Scene scene = read(box("rectangle", R"(<scale value="2"/>)", "diffuse") +
                           box("rectangle", "", "dielectric"));
  EXPECT_EQ(highest(scene.shapes[1], 2), 0.0);
  ASSERT_EQ(scene.notes.size(), 1u);
  EXPECT_TRUE(
      scene.notes[0].ends_with("the glass one touches another surface, and which of them "
                               "light meets first is undefined: move one"))
      << scene.notes[0];
}

TEST_F(AirGap, IsNotMadeWhereNothingTouches) {
  const std::string above = R"(<translate y="0.001"/>)", sunk = R"(<translate y="-0.1"/>)";
  for (const std::string& glass :
       {box("cube", above, "dielectric"), box("cube", sunk, "dielectric"),
        box("sphere", "", "dielectric"), box("cube", "", "conductor"),
        // Edge to edge
        box("cube", R"(<translate x="-4"/>)", "dielectric"),
        box("rectangle", R"(<scale y="0.1"/><translate y="-0.9"/>)", "dielectric")}) {
    EXPECT_EQ(read(box("rectangle", floor_below, "diffuse") + glass).notes,
              std::vector<std::string>{})
        << glass;
  }
}

TEST_F(SceneReader, ReadsTwoSidedBsdfs) {
  const Bsdf matte =
      read_shape("cube", R"(<bsdf type="twosided">)" + diffuse("0.2") + "</bsdf>").bsdf;
  EXPECT_EQ(matte.kind, Bsdf::Kind::diffuse);
  EXPECT_EQ(matte.reflectance, Rgb(0.2));
  EXPECT_TRUE(matte.two_sided);
  const Bsdf mirror =
      read(R"(<bsdf type="conductor" id="steel"><string name="material" value="none"/></bsdf>)"
           R"(<shape type="cube"><bsdf type="twosided"><ref id="steel"/></bsdf></shape>)")
          .shapes.at(0)
          .bsdf;
  EXPECT_EQ(mirror.kind, Bsdf::Kind::conductor);
  EXPECT_TRUE(mirror.two_sided);
}

TEST_F(SceneReader, FollowsReferencesBothWays) {
  const std::string red =
      R"(<bsdf type="diffuse" id="red"><rgb name="reflectance" value="1 0 0"/></bsdf>)";
  const std::string user = R"(<shape type="cube"><ref id="red"/></shape>)";
  EXPECT_EQ(read(red + user).shapes.at(0).bsdf.reflectance, Rgb(1, 0, 0));
  EXPECT_EQ(read(user + red).shapes.at(0).bsdf.reflectance, Rgb(1, 0, 0));
  const Scene nested = read("<shape type=\"cube\">" + red + "</shape>" + user);
  EXPECT_EQ(nested.shapes.at(1).bsdf.reflectance, Rgb(1, 0, 0));
}

TEST_F(SceneReader, ReadsALamp) {
  const Shape shape = read_shape(
      "rectangle", R"(<emitter type="area"><rgb name="radiance" value="17, 12, 4"/></emitter>)");
  EXPECT_EQ(shape.radiance, Rgb(17, 12, 4));
  EXPECT_TRUE(shape.is_lamp());
}

// Transforms. Each takes the rectangle's first corner, (-1, -1, 0), and its normal, (0, 0, 1).

TEST_F(SceneReader, Translates) {
  expect_near(read_mesh("rectangle", R"(<translate x="5" z="2"/>)")[0].corners[0], {4, -1, 2});
  expect_near(read_mesh("rectangle", R"(<translate value="5 6 7"/>)")[0].corners[0], {4, 5, 7});
  expect_near(read_mesh("rectangle", R"(<translate value="5"/>)")[0].corners[0], {4, 4, 5});
}

TEST_F(SceneReader, Scales) {
  expect_near(read_mesh("rectangle", R"(<scale x="5" z="2"/>)")[0].corners[0], {-5, -1, 0});
  expect_near(read_mesh("rectangle", R"(<scale value="5, 6, 7"/>)")[0].corners[0], {-5, -6, 0});
  expect_near(read_mesh("rectangle", R"(<scale value="5"/>)")[0].corners[0], {-5, -5, 0});
}

TEST_F(SceneReader, RotatesByTheRightHandRule) {
  const double s = std::sin(std::numbers::pi / 9.0);
  const double c = std::cos(std::numbers::pi / 9.0);
  const auto normal = [&](const std::string& step) {
    return read_mesh("rectangle", step)[0].normal();
  };
  expect_near(normal(R"(<rotate y="1" angle="20"/>)"), {s, 0, c});
  expect_near(normal(R"(<rotate y="-1" angle="20"/>)"), {-s, 0, c});
  expect_near(normal(R"(<rotate x="1" angle="20"/>)"), {0, -s, c});
  expect_near(normal(R"(<rotate value="1 0 0" angle="-20"/>)"), {0, s, c});
  expect_near(normal(R"(<rotate value="0.57735 0.57735 0.57735" angle="120"/>)"), {1, 0, 0});
  expect_near(read_mesh("rectangle", R"(<rotate z="1" angle="20"/>)")[0].corners[0],
              {s - c, -s - c, 0});
}

TEST_F(SceneReader, ReadsMatricesRowByRow) {
  const Mesh mesh =
      read_mesh("rectangle", R"(<matrix value="1 2 3 4  0 1 0 5  0 0 1 6  0 0 0 1"/>)");
  expect_near(mesh[0].corners[0], {1, 4, 6});
  expect_near(
      read_mesh("rectangle", R"(<matrix value="0 0 1 0  1 0 0 0  0 1 0 0  0 0 0 1"/>)")[0].normal(),
      {1, 0, 0});
}

TEST_F(SceneReader, LooksAtATarget) {
  const Mesh mesh =
      read_mesh("rectangle", R"(<lookat origin="1 2 3" target="9, 2, 3" up="0 5 0"/>)");
  expect_near(mesh[0].normal(), {1, 0, 0});
  expect_near(mesh[0].corners[0], {1, 1, 4});
}

TEST_F(SceneReader, AppliesTransformsInOrder) {
  expect_near(read_mesh("rectangle", R"(<translate x="1"/><scale value="2"/>)")[0].corners[1],
              {4, -2, 0});
  expect_near(read_mesh("rectangle", R"(<scale value="2"/><translate x="1"/>)")[0].corners[1],
              {3, -2, 0});
  expect_near(read_mesh("rectangle", "")[0].corners[1], {1, -1, 0});
}

TEST_F(SceneReader, AcceptsAnXmlDeclarationAByteOrderMarkAndComments) {
  const fs::path file = write("test.xml",
                              "\xEF\xBB\xBF<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<!-- a -->\n"
                              "<scene version=\"3.0.0\"><!-- b -->" +
                                  sensor + "</scene>\n<!-- c -->\n");
  EXPECT_EQ(read_scene(file).camera.width, 768);
}

TEST_F(SceneReader, SurvivesDeepNesting) {
  std::string deep;
  for (int i = 0; i < 500000; ++i) deep += "<bsdf>";
  for (int i = 0; i < 500000; ++i) deep += "</bsdf>";
  EXPECT_NE(error_of(write("test.xml", deep)).find("scene is missing"), std::string::npos);
}

TEST_F(SceneReader, ReadsNumbersInEveryLocale) {
  for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8", "de_DE.utf8"}) {
    if (std::setlocale(LC_ALL, name) != nullptr) break;
  }
  EXPECT_EQ(read_sphere(R"(<float name="radius" value="1.5"/>)").radius, 1.5);
  std::setlocale(LC_ALL, "C");
}

// All that a scene holds but its hash and name, as text.
std::string told(const Scene& scene) {
  const Camera& c = scene.camera;
  std::ostringstream text;
  text << std::hexfloat << c.origin << c.forward << c.right << c.up << c.fov_degrees << c.width
       << ' ' << c.height << int(c.fov_axis) << int(c.filter.kind) << c.filter.size << '\n';
  for (const Shape& shape : scene.shapes) {
    const Bsdf& bsdf = shape.bsdf;
    text << shape.id << int(bsdf.kind) << bsdf.reflectance << bsdf.two_sided << bsdf.eta << bsdf.k
         << bsdf.ior << bsdf.transmittance << shape.radiance;
    if (const auto* ball = std::get_if<Sphere>(&shape.geometry)) {
      text << ball->center << ball->radius;
    } else {
      for (const Polygon& face : std::get<Mesh>(shape.geometry)) {
        for (const Vec3& corner : face.corners) text << corner;
      }
    }
    text << '\n';
  }
  text << scene.request.bounces.first << ' ' << scene.request.bounces.last << ' '
       << scene.request.samples_per_pixel << '\n';
  for (const std::string& note : scene.notes) text << note << '\n';
  return text.str();
}

std::map<std::string, std::string> files_of(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const fs::path& file = entry.path();
    if (file.extension() != ".xml" && file.extension() != ".obj") continue;
    std::ostringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    files[file.filename().string()] = text.str();
  }
  return files;
}

TEST(FilesInMemory, HoldTheSameScenesAsOnADisk) {
  for (const char* name : {"cornell", "seed", "spheres", "metals"}) {
    const fs::path folder = fs::path(PLUMB_SCENES) / name;
    FilesInMemory files(files_of(folder));
    const Scene scene = read_scene("scene.xml", files);
    EXPECT_EQ(told(scene), told(read_scene(folder / "scene.xml")));
    EXPECT_EQ(scene.hash, "");
  }
}

TEST(FilesInMemory, AreFoundInWhateverFolderTheSceneLooks) {
  auto all = files_of(fs::path(PLUMB_SCENES) / "cornell");
  const std::string there = "\"floor.obj", elsewhere = "\"../meshes/floor.obj";
  std::string& text = all["scene.xml"];
  text.replace(text.find(there), there.size(), elsewhere);
  FilesInMemory files(all);
  const fs::path on_disk = fs::path(PLUMB_SCENES) / "cornell/scene.xml";
  EXPECT_EQ(told(read_scene("scene.xml", files)), told(read_scene(on_disk)));
}

TEST(FilesInMemory, AreRefusedWhereTheyAreMissing) {
  auto all = files_of(fs::path(PLUMB_SCENES) / "cornell");
  all.erase("tall_block.obj");
  FilesInMemory files(all);
  const auto error_of = [&](const char* name) -> std::string {
    try {
      read_scene(name, files);
    } catch (const SceneError& error) {
      return error.what();
    }
    return "not refused";
  };
  const std::string& text = all["scene.xml"];
  const auto line =
      1 + std::count(text.begin(), text.begin() + long(text.find("tall_block.obj")), '\n');
  EXPECT_TRUE(error_of("scene.xml").starts_with(fmt::format("scene.xml:{}: ", line)))
      << error_of("scene.xml");
  EXPECT_NE(error_of("scene.xml").find("tall_block.obj"), std::string::npos);
  EXPECT_EQ(error_of("none.xml"), "none.xml: no such file");
}

// Everything else is refused.

struct Refused {
  std::string xml;
  std::string words;
};

class SceneReaderRefuses : public SceneReader {
 protected:
  // The offender is on line 2, between what goes before it and after it.
  void expect_all(const std::string& before, const std::string& after,
                  const std::vector<Refused>& cases) const {
    for (const auto& [xml, words] : cases) {
      std::string text = "<scene version=\"3.0.0\">" + before + "\n" + xml + "\n" + after;
      const fs::path file = write("test.xml", text + "</scene>");
      expect_message(error_of(file), file, 2, words);
    }
  }
};

TEST_F(SceneReaderRefuses, OtherSensorsAndFilms) {
  const std::string fov = R"(<float name="fov" value="40"/>)";
  const std::string camera = R"(<sensor type="perspective">)" + fov;
  const std::string to_world = R"(<transform name="to_world">)";
  expect_all(
      "", "",
      {
          {sensor + sensor, "sensor is given twice"},
          {R"(<sensor type="thinlens"/>)",
           R"(<sensor type="thinlens">: unknown type; supported: perspective)"},
          {camera + film + R"(<string name="fov_axis" value="z"/></sensor>)",
           "supported: x, y, diagonal"},
          {camera + film + R"(<float name="blur" value="1"/></sensor>)",
           "blur is not supported here; supported: float fov, "},
          {camera + fov + film + "</sensor>", "fov is given twice"},
          {camera + film + R"(<string name="focal_length" value="50mm"/></sensor>)",
           "either fov or focal_length"},
          {R"(<sensor type="perspective"><string name="focal_length" value="5cm"/></sensor>)",
           "a length such as 50mm"},
          {camera + film + R"(<float name="principal_point_offset_x" value="0.1"/></sensor>)",
           "supported: 0"},
          {camera + film + to_world + R"(<scale value="1.001"/></transform></sensor>)",
           "scaled or sheared"},
          {camera + film + to_world +
               R"(<matrix value="1 0 0 0  0 1 0.5 0  0 0 1 0  0 0 0 1"/></transform></sensor>)",
           "scaled or sheared"},
          {camera + R"(<film type="hdrfilm"><rfilter type="mitchell"/></film></sensor>)",
           "supported: box, gaussian, tent; filters with negative weights can't be sampled"},
          {camera + R"(<film type="hdrfilm"><rfilter type="tent"><float name="radius" value="0"/>)"
                    R"(</rfilter></film></sensor>)",
           "must be positive"},
          {camera + R"(<film type="specfilm"/></sensor>)", "supported: hdrfilm, ldrfilm"},
      });
  for (const std::string value : {"0", "-3", "180", "nan", "inf", "4O", "1.5abc", ""}) {
    const std::string bad_fov = fmt::format(R"(<float name="fov" value="{}")", value);
    expect_all(R"(<sensor type="perspective">)" + film, "</sensor>", {{bad_fov + "/>", bad_fov}});
  }
  const std::string before = camera + R"(<film type="hdrfilm"><rfilter type="box"/>)";
  expect_all(before, "</film></sensor>",
             {
                 {R"(<rfilter type="box"/>)", "rfilter is given twice"},
                 {R"(<integer name="crop_width" value="3"/>)", "supported: 768"},
                 {R"(<integer name="crop_offset_x" value="3"/>)", "supported: 0"},
                 {R"(<boolean name="sample_border" value="yes"/>)", "supported: true, false"},
             });
  for (const std::string value : {"0", "-1", "8193", "12.5", "99999999999", "wide"}) {
    const std::string width = fmt::format(R"(<integer name="width" value="{}")", value);
    expect_all(before, "</film></sensor>", {{width + "/>", width}});
  }
}

TEST_F(SceneReaderRefuses, OtherShapes) {
  const std::string obj = R"(<shape type="obj"><string name="filename" value=)";
  expect_all(
      sensor, "",
      {
          {R"(<shape type="cone"/>)",
           R"(<shape type="cone">: unknown type; supported: cube, obj, ply, rectangle, sphere)"},
          {"<shape/>", "<shape>: the attribute type is missing; supported: cube, "},
          {R"(<shape type="sphere"><boolean name="flip_normals" value="true"/></shape>)",
           "a sphere that faces inwards"},
          {obj + R"("none.obj"/>)" + face_normals + "</shape>", "none.obj cannot be read"},
          {obj + R"("."/>)" + face_normals + "</shape>", "cannot be read"},
          {R"(<shape type="obj">)" + face_normals + "</shape>", "filename is missing"},
      });
  expect_all(sensor + R"(<shape type="sphere">)", "</shape>",
             {
                 {R"(<float name="radius" value="0"/>)", "positive"},
                 {R"(<float name="radius" value="-1"/>)", "positive"},
                 {R"(<float name="radius" value="1,5"/>)", "finite number"},
                 {R"(<string name="radius" value="1"/>)", "radius is not supported here"},
                 {R"(<point name="center" x="1" y="2"/>)", "z must be 1 finite"},
                 {R"(<point name="center" value="1 2"/>)", "3 finite number(s)"},
                 {R"(<point name="center" value="1 2 3" x="1"/>)", "either value or"},
             });
  for (const std::string step : {R"(<scale x="2"/>)", R"(<scale value="-1"/>)",
                                 R"(<matrix value="1 0.6 0 0  0 0.8 0 0  0 0 1 0  0 0 0 1"/>)"}) {
    expect_all(
        sensor, "",
        {{R"(<shape type="sphere"><transform name="to_world">)" + step + "</transform></shape>",
          "mirrored, sheared or scaled"}});
  }
}

TEST_F(SceneReaderRefuses, BadObjFiles) {
  const std::string v = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\n";
  const fs::path file =
      write("test.xml", "<scene version=\"3.0.0\">" + sensor +
                            R"(<shape type="obj"><string name="filename" value="test.obj"/>)" +
                            face_normals + "</shape></scene>");
  const auto refused = [&](const std::string& text, int line, const std::string& words) {
    const fs::path obj = write("test.obj", text);
    expect_message(error_of(file), obj, line, words);
  };
  refused(v + "f 1 2 9\n", 6, "f 1 2 9: 9 is not one of 5 vertices above");
  refused("f 1 2 3\n" + v, 1, "f 1 2 3");
  refused(v + "f 1 2\n", 6, "at least three corners");
  refused(v + "vn 0 0 1\nf 1//1 2//1 3//2\n", 7, "3//2 is not one of 1 normals");
  for (const std::string corner : {"0", "-1", "3x", "\\", "/1", "1.5", "99999999999999999999"}) {
    refused(v + "f 1 2 " + corner, 6, corner + " is not one of 5");
  }
  refused(v + "curv 1", 6, "curv 1: supported: v, vn, f, g, l, ");
  for (const std::string vertex : {"0 0 nan", "0 inf 0", "0 1,5 0", "0 1.5abc 0", "0 0 1x", "0 0",
                                   "", "0 0 0 2", "0 0 1e999"}) {
    refused("v " + vertex, 1, "three finite numbers");
  }
  for (const std::string& text : {std::string("v 0 0 0\n"), v + "f 1 2 5\nf 1 1 2\n"}) {
    write("test.obj", text);
    EXPECT_NE(error_of(file).find("test.obj: there are no faces"), std::string::npos);
  }
}

TEST_F(SceneReaderRefuses, OtherBsdfsLampsAndReferences) {
  const std::string lamp = R"(<emitter type="area"><rgb name="radiance" value="1"/></emitter>)";
  expect_all(
      sensor, "",
      {
          {R"(<bsdf type="plastic"/>)",
           R"(<bsdf type="plastic">: unknown type; supported: conductor, dielectric, diffuse, )"},
          {R"(<bsdf type="twosided"/>)", "bsdf is missing"},
          {R"(<bsdf type="twosided" id="a"><ref id="a"/></bsdf>)", "refers to what it stands in"},
          {R"(<bsdf type="twosided" id="a"><ref id="b"/></bsdf><bsdf type="twosided" id="b">)"
           R"(<ref id="a"/></bsdf>)",
           "refers to what it stands in"},
          {R"(<bsdf type="twosided"><bsdf type="twosided">)" + diffuse("0") + "</bsdf></bsdf>",
           "must not hold its like"},
          {R"(<bsdf type="twosided">)" + diffuse("0") + diffuse("1") + "</bsdf>", "given twice"},
          {R"(<bsdf type="diffuse"><float name="alpha" value="1"/></bsdf>)",
           "supported: color reflectance"},
          {R"(<bsdf type="diffuse" id="a"/><shape type="cube" id="a"/>)", "the id is taken"},
          {R"(<shape type="cube" id="a"/><shape type="cube"><ref id="a"/></shape>)",
           "shape is not supported here"},
      });
  expect_all(sensor + R"(<bsdf type="diffuse" id="a"/><shape type="cube">)", "</shape>",
             {
                 {R"(<ref id="red"/>)", "nothing has this id"},
                 {R"(<ref id="a"/>)" + diffuse("1"), "given twice"},
                 {diffuse("0") + diffuse("1"), "bsdf is given twice"},
                 {R"(<texture type="bitmap" name="t"/>)", "texture is not supported here"},
                 {R"(<emitter type="point"/>)", "supported: area"},
                 {lamp + lamp, "emitter is given twice"},
             });
  for (const std::string value : {"#ff8000", "1.1", "0 0 -0.1", "0 0", "0 0 0 0", "", "nan", "inf",
                                  "0;0;0", "1.5abc", "0x1", "+-1", "++1", "1e999", "1 1 1 -"}) {
    expect_all(sensor, "", {{diffuse(value), R"(<rgb name="reflectance" value=")" + value}});
  }
  for (const std::string value : {"-1", "1 1 -1", "inf", "nan"}) {
    expect_all(sensor + R"(<shape type="cube"><emitter type="area">)", "</emitter></shape>",
               {{R"(<rgb name="radiance" value=")" + value + "\"/>", value}});
  }
}

TEST_F(SceneReaderRefuses, OtherMetals) {
  const std::string gold = R"(<string name="material" value="Au"/>)";
  expect_all(sensor + R"(<bsdf type="conductor">)", "</bsdf>",
             {
                 {R"(<string name="material" value="gold"/>)", "supported: none, a-C, Ag, "},
                 {R"(<string name="material" value="au"/>)", "supported: none, a-C, Ag, "},
                 {R"(<string name="material" value="Au_palik"/>)", "supported: none, a-C, Ag, "},
                 {gold + R"(<rgb name="k" value="1"/>)", "either material or eta and k"},
                 {gold + R"(<rgb name="eta" value="1"/>)", "either material or eta and k"},
                 {gold + gold, "material is given twice"},
                 {R"(<rgb name="eta" value="1, -1, 1"/>)", "must be from 0 to 1000"},
                 {R"(<rgb name="k" value="1001"/>)", "must be from 0 to 1000"},
                 {R"(<rgb name="specular_reflectance" value="2"/>)", "must be from 0 to 1"},
                 {R"(<float name="alpha" value="0.1"/>)", "alpha is not supported here"},
                 {R"(<float name="int_ior" value="1.5"/>)", "int_ior is not supported here"},
             });
}

TEST_F(SceneReaderRefuses, OtherRoughMetals) {
  const std::string ggx = R"(<string name="distribution" value="ggx"/>)";
  expect_all(
      sensor + R"(<bsdf type="roughconductor">)", "</bsdf>",
      {
          {R"(<string name="distribution" value="beckmann"/>)", "supported: ggx"},
          {ggx + R"(<float name="alpha" value="0"/>)", "must be positive"},
          {ggx + R"(<float name="alpha" value="0.0001"/>)", "must be from 0.001 to 1"},
          {ggx + R"(<float name="alpha" value="2"/>)", "must be from 0.001 to 1"},
          {ggx + R"(<float name="alpha_u" value="0.1"/>)", "alpha_u and alpha_v that are the same"},
          {ggx + R"(<float name="alpha_u" value="0.1"/><float name="alpha_v" value="0.2"/>)",
           "alpha_u and alpha_v that are the same"},
          {ggx + R"(<float name="alpha" value="0.1"/><float name="alpha_u" value="0.1"/>)" +
               R"(<float name="alpha_v" value="0.1"/>)",
           "either alpha or alpha_u and alpha_v"},
      });
}

TEST_F(SceneReaderRefuses, BeckmannAndOtherSkiesAndPoints) {
  expect_all(sensor, "",
             {
                 {R"(<bsdf type="roughconductor"/>)", "is Beckmann's in Mitsuba; supported: "},
                 {R"(<emitter type="constant"/><emitter type="constant"/>)", "a sky already"},
                 {R"(<emitter type="constant"><rgb name="radiance" value="-1"/></emitter>)",
                  "must be from 0"},
                 {R"(<emitter type="envmap"/>)", "supported: area, constant, point"},
                 {R"(<emitter type="point"><point name="position" x="1" y="2" z="3"/>)"
                  R"(<transform name="to_world"/></emitter>)",
                  "either position or to_world"},
             });
  expect_all(sensor + R"(<shape type="cube">)", "</shape>",
             {{R"(<emitter type="constant"/>)", "supported: area"}});
}

TEST_F(SceneReaderRefuses, OtherGlass) {
  const std::string index = R"(<float name="int_ior" value="1.5"/>)";
  const std::string known = "must be a <float> or, as a <string>, one of vacuum, helium, ";
  expect_all(
      sensor + R"(<bsdf type="dielectric">)", "</bsdf>",
      {
          {R"(<string name="int_ior" value="glass"/>)", known},
          {R"(<string name="ext_ior" value="1.5"/>)", known},
          {R"(<integer name="int_ior" value="2"/>)", known},
          {R"(<float name="int_ior" value="0"/>)", "must be from 0.001 to 1000"},
          {R"(<float name="ext_ior" value="1001"/>)", "must be from 0.001 to 1000"},
          {R"(<float name="ext_ior" value="inf"/>)", "finite number"},
          {R"(<rgb name="int_ior" value="1.5"/>)", "int_ior is not supported here"},
          {index + R"(<string name="int_ior" value="water"/>)", "is given twice"},
          {R"(<rgb name="specular_reflectance" value="1.1"/>)", "must be from 0 to 1"},
          {R"(<rgb name="specular_transmittance" value="1, 1, -1"/>)", "must be from 0 to 1"},
          {R"(<string name="material" value="water"/>)", "material is not supported here"},
          {R"(<float name="alpha" value="0.1"/>)", "alpha is not supported here"},
      });
  expect_all(sensor, "",
             {{R"(<bsdf type="twosided"><bsdf type="dielectric"/></bsdf>)",
               "glass has two sides already"}});
}

TEST_F(SceneReaderRefuses, BadTransforms) {
  expect_all(sensor + R"(<shape type="cube"><transform name="to_world">)", "</transform></shape>",
             {
                 {R"(<shear x="1"/>)", "supported: name, translate, rotate, scale, matrix, lookat"},
                 {R"(<translate w="1"/>)",
                  "the attribute w is not supported here; supported: x, y, z, value"},
                 {R"(<translate x="1" value="1 2 3"/>)", "either value or"},
                 {R"(<translate value="1 2"/>)", "3 finite number(s)"},
                 {R"(<translate x="1m"/>)", "finite number"},
                 {R"(<rotate y="1"/>)", "the attribute angle is missing"},
                 {R"(<rotate angle="20"/>)", "length 1"},
                 {R"(<rotate x="3" y="4" angle="20"/>)", "length 1: write value=\"0.6, 0.8, 0\""},
                 {R"(<matrix value="1 0 0  0 1 0  0 0"/>)", "16 finite number(s)"},
                 {R"(<matrix value="1 0 0 0  0 1 0 0  0 0 1 0  0 0 1 1"/>)", "last row"},
                 {R"(<lookat origin="1,1,1" target="1,1,1" up="0,1,0"/>)", "on one line"},
                 {R"(<lookat origin="0,0,0" target="0,2,0" up="0,1,0"/>)", "on one line"},
                 {R"(<lookat origin="0,0,0" target="0,0,1" up="0,0,0"/>)", "on one line"},
                 {R"(<lookat origin="0,0,0" target="0,0,1"/>)", "the attribute up is missing"},
                 {R"(<lookat origin="0" target="0,0,1" up="0,1,0"/>)", "3 finite number(s)"},
                 {R"(<scale value="2">2</scale>)", "'2': text is not supported here"},
             });
  for (const std::string step :
       {R"(<scale value="0"/>)", R"(<scale z="0"/>)", R"(<scale value="1e200"/>)",
        R"(<matrix value="1 1 0 0  1 1 0 0  0 0 1 0  0 0 0 1"/>)"}) {
    expect_all(sensor + R"(<shape type="cube">)", "</shape>",
               {{R"(<transform name="to_world">)" + step + "</transform>", "singular"}});
  }
}

TEST_F(SceneReaderRefuses, UnknownElementsAttributesTextAndDefaults) {
  expect_all(
      sensor, "",
      {
          {R"(<integrator type="bdpt"/>)", "or write <integrator type=\"path\">"},
          {R"(<integrator type="path"><integer name="max_depth" value="0"/></integrator>)",
           "must be -1 or at least 1"},
          {R"(<integrator type="path"><boolean name="hide_emitters" value="true"/></integrator>)",
           "supported: false"},
          {R"(<include filename="none.xml"/>)", "none.xml: no such file"},
          {R"(<shape type="cube" colour="red"/>)", "the attribute colour is not supported here"},
          {R"(<shape type="cube" type="sphere"/>)", "the attribute type is given twice"},
          {"red", "text is not supported"},
          {"<![CDATA[red]]>", "text is not supported"},
          {R"(<shape type="sphere"><float value="1"/></shape>)", "float is not supported"},
          {R"(<shape type="sphere"><float name="radius" value="1"><cube/></float></shape>)",
           "cube is not supported here; supported: name, value"},
          {R"(<shape type="cube"><transform name="toWorld"/></shape>)", "toWorld is not supported"},
          {R"(<shape type="sphere"><float name="radius" value="$r"/></shape><default name="r" value="1"/>)",
           "no <default> before this"},
          {R"(<default name="" value="1"/>)", "a default needs a name"},
          {R"(<default name="r"/>)", "the attribute value is missing"},
      });
}

TEST_F(SceneReaderRefuses, OtherRootsAndBrokenFiles) {
  const std::pair<std::string, std::string> cases[] = {
      {"<scene version=\"4.0.0\"/>", "supported: versions 0.x to 3.x"},
      {"<scene/>", "the attribute version is missing; write <scene version=\"3.0.0\">"},
      {"<shape/>", "scene is missing"},
      {"<!-- nothing -->", "scene is missing"},
      {"<scene/><scene/>", "scene is given twice"},
      {"<scene version=\"3.0.0\"/>", "sensor is missing"},
      {"<scene", ""},
      {"<scene><shape></scene>", "mismatch"}};
  for (const auto& [text, words] : cases) {
    const fs::path file = write("test.xml", text);
    expect_message(error_of(file), file, 1, words);
  }
  EXPECT_EQ(error_of("none.xml"), "none.xml: no such file");
  for (const fs::path& file : {folder_, write("empty.xml", "")}) {
    EXPECT_EQ(error_of(file), file.string() + ": cannot be read or is empty");
  }
}

}  // namespace
}  // namespace plumb
