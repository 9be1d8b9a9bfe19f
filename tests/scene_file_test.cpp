// SPDX-License-Identifier: Apache-2.0

// Scenes as people write them: what is read as it is, and what is said of it.
#include <fmt/ranges.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "scene_files/scene_reader.h"
#include "scene_files/spectrum.h"

namespace plumb {
namespace {

namespace fs = std::filesystem;

const std::string sensor =
    R"(<sensor type="perspective"><float name="fov" value="40"/><film type="hdrfilm">)"
    R"(<rfilter type="box"/></film></sensor>)";

class SceneFileTest : public testing::Test {
 protected:
  SceneFileTest() {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / fmt::format("plumb_{}_{}", test->name(), getpid());
    fs::create_directories(folder_ / "parts");
  }
  ~SceneFileTest() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }

  Scene read(const std::string& elements, const std::string& version = "3.0.0") const {
    return read_scene(
        write("test.xml", fmt::format("<scene version=\"{}\">\n{}\n</scene>", version, elements)));
  }
  Scene read_with_sensor(const std::string& elements) const { return read(sensor + elements); }

  // What stands in the sensor and its film.
  Camera read_camera(const std::string& in_sensor, const std::string& in_film) const {
    return read(R"(<sensor type="perspective">)" + in_sensor + R"(<film type="hdrfilm">)" +
                in_film + "</film></sensor>")
        .camera;
  }

  std::string error_of(const std::string& elements) const {
    try {
      read(elements);
    } catch (const SceneError& error) {
      return error.what();
    }
    return "not refused";
  }

  static void expect_note(const Scene& scene, const std::string& words) {
    const std::string notes = fmt::format("{}", fmt::join(scene.notes, "\n"));
    EXPECT_NE(notes.find(words), notes.npos) << notes << "\ndon't say: " << words;
  }

  fs::path folder_;
};

void expect_rgb(const Rgb& actual, const Rgb& expected) {
  EXPECT_LT((actual - expected).length(), 1e-5 * expected.length())
      << fmt::format("({}, {}, {})", actual.x, actual.y, actual.z);
}

TEST_F(SceneFileTest, TakesWhatHasNoEffectAndSaysSoInOneLine) {
  const Scene scene = read(R"(<?xml-model href="a"?>
    <default name="spp" value="128"/>
    <default name="res" value="96"/>
    <integrator type="path" name="integrator">
      <integer name="max_depth" value="6"/>
      <integer name="rr_depth" value="5"/>
    </integrator>
    <sensor type="perspective" id="sensor" name="camera">
      <float name="focus_distance" value="1000"/>
      <integer name="fov" value="40"/>
      <float name="principal_point_offset_x" value="0.000"/>
      <sampler type="any"><integer name="sample_count" value="$spp"/><float name="x" value="1"/></sampler>
      <film type="hdrfilm" name="film">
        <integer name="width" value="$res"/>
        <rfilter type="tent" name="filter"/>
        <string name="pixel_format" value="rgba"/>
        <string name="component_format" value="float16"/>
        <boolean name="banner" value="false"/>
      </film>
    </sensor>
    <emitter type="area" id="light"><rgb name="radiance" value="18, 14, 6"/></emitter>
    <bsdf type="conductor" id="mirror" name="m"/>
    <shape type="cube" id="lamp" name="shape"><ref id="mirror" name="bsdf"/><ref id="light"/>
      <boolean name="flip_normals" value="false"/></shape>)");
  EXPECT_EQ(scene.request.samples_per_pixel, 128);
  EXPECT_EQ(scene.request.bounces.last, 5);
  EXPECT_EQ(scene.camera.width, 96);
  EXPECT_EQ(scene.camera.filter.kind, Filter::Kind::tent);
  EXPECT_EQ(scene.shapes.at(0).radiance, Rgb(18, 14, 6));
  EXPECT_EQ(scene.shapes.at(0).bsdf.kind, Bsdf::Kind::conductor);
  EXPECT_EQ(scene.shapes.at(0).bsdf.reflectance, Rgb(1.0));
  expect_note(scene, "without effect here: rr_depth, focus_distance, ");
  expect_note(scene, "value=\"6\">: --bounces 0:5 unless told otherwise");
  expect_note(scene, "value=\"128\">: the default of --spp");
}

TEST_F(SceneFileTest, HasNothingToSayOfAPlainScene) {
  EXPECT_EQ(read_with_sensor(R"(<shape type="cube"/>)").notes, std::vector<std::string>{});
}

TEST_F(SceneFileTest, TellsAllThatIsWrongAtOnceWithItsPlaces) {
  const std::string message = error_of(R"(<sensor type="perspective"><float name="fov" value="a"/>
    </sensor>
    <bsdf type="velvet" id="b"/>
    <shape type="cube"><ref id="none"/></shape>
    <shape type="cone"/>
    <shape type="sphere"><float name="radius" value="-1"/><float name="colour" value="1"/></shape>
    <shape type="sphere"><float name="radius" value="-1"/><ref id="b"/></shape>
    <shape type="sphere"><float name="radius" value="-1"/></shape>)");
  const std::string file = (folder_ / "test.xml").string();
  for (const char* words :
       {R"(:2: <float name="fov" value="a">)", R"(:4: <bsdf type="velvet")",
        R"(:5: <ref id="none">: nothing has this id)", R"(:6: <shape type="cone">)",
        R"(:7: <float name="colour")", R"(:9: <float name="radius")"}) {
    EXPECT_NE(message.find(file + words), message.npos) << words << " is not told in\n" << message;
  }
  EXPECT_EQ(std::ranges::count(message, '\n'), 5) << message;
}

TEST_F(SceneFileTest, FollowsIncludesWithParametersBothWays) {
  write("parts/room.xml", R"(<scene version="2.1.0"><include filename="$which.xml"/>
    <default name="albedo" value="0.25"/><bsdf type="diffuse" id="grey">
    <rgb name="reflectance" value="$albedo"/></bsdf></scene>)");
  write("parts/ball.xml", R"(<shape version="3.0.0" type="sphere"><ref id="grey"/></shape>)");
  const Scene scene = read(R"(<default name="which" value="ball"/>)" + sensor +
                           R"(<include filename="parts/room.xml"/>
      <shape type="cube"><bsdf type="diffuse"><rgb name="reflectance" value="$albedo"/></bsdf></shape>)");
  ASSERT_EQ(scene.shapes.size(), 2u);
  EXPECT_EQ(scene.shapes[0].bsdf.reflectance, Rgb(0.25));
  EXPECT_EQ(scene.shapes[1].bsdf.reflectance, Rgb(0.25));
  write("parts/ball.xml", R"(<shape version="3.0.0" type="ball"/>)");
  const std::string message = error_of(R"(<default name="which" value="ball"/>)" + sensor +
                                       R"(<include filename="parts/room.xml"/>)");
  EXPECT_NE(message.find("ball.xml:1: <shape"), message.npos) << message;
}

TEST_F(SceneFileTest, EndsWhereFilesIncludeThemselves) {
  write("loop.xml", R"(<scene version="3.0.0"><include filename="loop.xml"/></scene>)");
  EXPECT_NE(error_of(R"(<include filename="loop.xml"/>)").find("more than 100 files"),
            std::string::npos);
}

TEST_F(SceneFileTest, EndsWhereReferencesOrParametersDoubleAndDouble) {
  std::string bsdfs = R"(<bsdf type="twosided" id="b0"/>)";
  std::string defaults = R"(<default name="a0" value="xx"/>)";
  for (int i = 1; i < 40; ++i) {
    bsdfs += fmt::format(
        R"(<bsdf type="twosided" id="b{0}"><ref id="b{1}"/><ref id="b{1}"/></bsdf>)", i, i - 1);
    defaults += fmt::format(R"(<default name="a{0}x" value="$a{1}x$a{1}x"/>)", i, i - 1);
  }
  EXPECT_NE(error_of(bsdfs).find("lead to a million elements"), std::string::npos);
  defaults.replace(defaults.find("a0"), 2, "a0x");
  EXPECT_NE(error_of(defaults).find("a value of over 10 MB"), std::string::npos);
}

TEST_F(SceneFileTest, LooksForFilesInTheFoldersOfPath) {
  write("parts/a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const Scene scene = read_with_sensor(R"(<path value="parts"/><shape type="obj">
      <string name="filename" value="a.obj"/></shape>)");
  EXPECT_EQ(std::get<Mesh>(scene.shapes.at(0).geometry).size(), 1u);
}

TEST_F(SceneFileTest, ReadsUtf16AndIgnoresInvisibleCharacters) {
  const std::string text = "<scene version=\"3.0.0\">\xe2\x80\x8b" + sensor +
                           "\xef\xbb\xbf<shape type=\"cube\"/></scene>";
  EXPECT_EQ(read_scene(write("a.xml", text)).shapes.size(), 1u);
  const std::string plain =
      "<scene version=\"3.0.0\">\n" + sensor + "\n<shape type=\"cone\"/></scene>";
  for (const bool is_little : {true, false}) {
    std::string wide = is_little ? "\xff\xfe" : "\xfe\xff";
    for (const char c : plain) {
      wide += is_little ? std::string{c, '\0'} : std::string{'\0', c};
    }
    const fs::path file = write("wide.xml", wide);
    EXPECT_THROW(
        {
          try {
            read_scene(file);
          } catch (const SceneError& error) {
            EXPECT_NE(std::string(error.what()).find("wide.xml:3: <shape type=\"cone\">"),
                      std::string::npos)
                << error.what();
            throw;
          }
        },
        SceneError);
  }
}

TEST_F(SceneFileTest, UpgradesTheNamesOfOldVersions) {
  const Scene scene = read(R"(<sensor type="perspective"><float name="nearClip" value="0.01"/>
      <float name="fov" value="30"/><string name="fovAxis" value="y"/>
      <transform name="toWorld"><lookAt origin="0,0,4" target="0,0,0" up="0,1,0"/></transform>
      <sampler type="ldsampler"><integer name="sampleCount" value="7"/></sampler>
      <film type="ldrfilm"><boolean name="banner" value="false"/></film></sensor>
    <shape type="sphere"><bsdf type="diffuse">
      <spectrum name="diffuseReflectance" value="0.1, 0.2, 0.3"/></bsdf></shape>)",
                           "0.5.0");
  EXPECT_EQ(scene.camera.fov_axis, Camera::FovAxis::y);
  EXPECT_EQ(scene.camera.origin, Vec3(0, 0, 4));
  EXPECT_EQ(scene.request.samples_per_pixel, 7);
  EXPECT_EQ(scene.shapes.at(0).bsdf.reflectance, Rgb(0.1, 0.2, 0.3));
  expect_note(scene, "three numbers are taken as red, green, blue");
}

TEST_F(SceneFileTest, KnowsMitsubasFieldOfViewFromAFocalLengthAndWithoutAny) {
  const double diagonal = std::hypot(36.0, 24.0);
  const double degrees = 180.0 / M_PI;
  const std::string length = R"(<string name="focal_length" value="35mm"/>)";
  EXPECT_NEAR(read_camera(length, "").fov_degrees, 2 * std::atan(diagonal / 70) * degrees, 1e-12);
  EXPECT_NEAR(read_camera("", "").fov_degrees, 2 * std::atan(diagonal / 100) * degrees, 1e-12);
  EXPECT_EQ(read_camera("", "").fov_axis, Camera::FovAxis::diagonal);
}

TEST_F(SceneFileTest, ReadsFiltersAndTakesAGaussianWhereThereIsNone) {
  const auto filter = [&](const std::string& in_film) { return read_camera("", in_film).filter; };
  EXPECT_EQ(filter("").kind, Filter::Kind::gaussian);
  EXPECT_EQ(filter("").size, 0.5);
  EXPECT_EQ(filter(R"(<rfilter type="gaussian"><float name="stddev" value="2"/></rfilter>)").size,
            2.0);
  EXPECT_EQ(filter(R"(<rfilter type="tent"><float name="radius" value="3"/></rfilter>)").size, 3.0);
  EXPECT_FALSE(filter("").crosses_border);
  EXPECT_TRUE(filter(R"(<boolean name="sample_border" value="true"/>)").crosses_border);
}

TEST_F(SceneFileTest, RefusesClipPlanesThatCutAndNoOthers) {
  // A wall at depth 10, between 9 and 10 wide: what lies beside the view does not count.
  const auto scene = [](const std::string& planes) {
    return R"(<sensor type="perspective"><float name="fov" value="40"/>)" + planes +
           R"(<transform name="to_world"><lookat origin="0,0,10" target="0,0,0" up="0,1,0"/>
      </transform><film type="hdrfilm"><rfilter type="box"/></film></sensor>
      <shape type="rectangle"/><shape type="sphere"><point name="center" x="0" y="50" z="9"/></shape>
      <shape type="rectangle"><transform name="to_world"><scale value="50"/><rotate x="1" angle="90"/>
        <translate y="-40"/></transform></shape>)";
  };
  EXPECT_EQ(read(scene(R"(<float name="near_clip" value="9.9"/>)")).shapes.size(), 3u);
  EXPECT_EQ(error_of(scene(R"(<float name="near_clip" value="10.1"/>)")).find("not refused"),
            std::string::npos);
  EXPECT_NE(error_of(scene(R"(<float name="far_clip" value="10.1"/>)")).find("not refused"),
            std::string::npos);
  EXPECT_NE(error_of(scene(R"(<float name="far_clip" value="9.9"/>)")).find("at a depth of 10"),
            std::string::npos);
}

TEST_F(SceneFileTest, ALampWithoutABsdfIsBlackAndOtherShapesAreGrey) {
  const std::string lamp = R"(<emitter type="area"><rgb name="radiance" value="2"/></emitter>)";
  const Scene scene = read_with_sensor(R"(<shape type="sphere">)" + lamp + R"(</shape>
    <shape type="sphere"/><shape type="sphere"><emitter type="area"/></shape>)");
  EXPECT_EQ(scene.shapes[0].bsdf.reflectance, Rgb(0.0));
  EXPECT_EQ(scene.shapes[1].bsdf.reflectance, Rgb(0.5));
  EXPECT_EQ(scene.shapes[2].radiance, Rgb(1.0));
}

TEST_F(SceneFileTest, FlipsNormals) {
  const Scene scene = read_with_sensor(
      R"(<shape type="rectangle"><boolean name="flip_normals" value="true"/></shape>)");
  EXPECT_EQ(std::get<Mesh>(scene.shapes[0].geometry)[0].normal(), Vec3(0, 0, -1));
}

// Spectra. The expected colours are those of mitsuba.spectrum_list_to_srgb() of Mitsuba 3.9.1.

TEST(Spectrum, IsTheColourThatMitsubaMakesOfIt) {
  expect_rgb(emission_of({{400, 0}, {500, 8}, {600, 15.6}, {700, 18.4}}),
             {20.7108, 10.8546, 2.77115});
  expect_rgb(reflectance_of({{400, 0.04}, {500, 0.3}, {600, 0.7}, {700, 0.1}}),
             {0.65971, 0.482193, 0.138179});
  expect_rgb(reflectance_of({{400, 0}, {490, 0}, {500, 0.9}, {600, 0}}), {0, 0.545739, 0});
  expect_rgb(reflectance_of({{300, 0.2}, {400, 0.5}, {900, 0.6}}), {0.547916, 0.528015, 0.507483});
}

// The chromaticity of the Planckian locus at 5000 K, x = 0.3451 and y = 0.3516 (CIE 15).
TEST(Spectrum, OfABlackBodyHasItsColour) {
  const Rgb rgb = emission_of(black_body(5000.0));
  const double x = Vec3(0.412453, 0.357580, 0.180423).dot(rgb);
  const double y = Vec3(0.212671, 0.715160, 0.072169).dot(rgb);
  const double z = Vec3(0.019334, 0.119193, 0.950227).dot(rgb);
  EXPECT_NEAR(x / (x + y + z), 0.3451, 2e-4);
  EXPECT_NEAR(y / (x + y + z), 0.3516, 2e-4);
}

TEST_F(SceneFileTest, ReadsSpectraInAllTheirForms) {
  write("ramp.spd", "# nm, value\n400 0.04\n500 0.3 # a comment\n600 0.7\n\n700 0.1\n");
  const auto reflectance = [&](const std::string& color) {
    return read_with_sensor(R"(<shape type="cube"><bsdf type="diffuse">)" + color +
                            "</bsdf></shape>")
        .shapes.at(0)
        .bsdf.reflectance;
  };
  const auto radiance = [&](const std::string& color) {
    return read_with_sensor(R"(<shape type="cube"><emitter type="area">)" + color +
                            "</emitter></shape>")
        .shapes.at(0)
        .radiance;
  };
  const Rgb ramp = reflectance_of({{400, 0.04}, {500, 0.3}, {600, 0.7}, {700, 0.1}});
  EXPECT_EQ(reflectance(R"(<spectrum name="reflectance" value="400:.04, 500:.3 600:.7, 700:.1"/>)"),
            ramp);
  EXPECT_EQ(reflectance(R"(<spectrum name="reflectance" filename="ramp.spd"/>)"), ramp);
  EXPECT_EQ(reflectance(R"(<spectrum name="reflectance" value="0.3"/>)"), Rgb(0.3));
  EXPECT_EQ(reflectance(R"(<float name="reflectance" value="0.3"/>)"), Rgb(0.3));
  EXPECT_EQ(radiance(R"(<float name="radiance" value="2"/>)"), Rgb(2.0));
  expect_rgb(radiance(R"(<spectrum name="radiance" value="2"/>)"), {2.40959, 1.89658, 1.81783});
  EXPECT_EQ(radiance(R"(<spectrum name="radiance" type="d65"><rgb name="color" value="1 2 3"/>
      <float name="scale" value="2"/></spectrum>)"),
            Rgb(2, 4, 6));
  EXPECT_GT(radiance(R"(<spectrum name="radiance" type="blackbody">
      <float name="temperature" value="5000"/></spectrum>)")
                .x,
            1e4);
  for (const char* wrong : {"400:0.1", "400:0.1, 300:0.2", "400:0.1, 500", "400;1", "red", ""}) {
    const std::string color = fmt::format(R"(<spectrum name="reflectance" value="{}"/>)", wrong);
    EXPECT_NE(
        error_of(sensor + R"(<shape type="cube"><bsdf type="diffuse">)" + color + "</bsdf></shape>")
            .find("the wavelengths rising"),
        std::string::npos)
        << wrong;
  }
}

// Meshes.

class MeshFileTest : public SceneFileTest {
 protected:
  Scene read_file(const std::string& type, const std::string& text,
                  const std::string& inside = "") const {
    write("mesh." + type, text);
    return read_with_sensor(
        fmt::format(R"(<shape type="{0}"><string name="filename" value="mesh.{0}"/>{1}</shape>)",
                    type, inside));
  }
  static const Mesh& mesh(const Scene& scene) { return std::get<Mesh>(scene.shapes[0].geometry); }
};

const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
const std::string up = "vn 0 0 1\n";
const std::string aslant = "vn 0.6 0 0.8\n";

TEST_F(MeshFileTest, NeedsNoFaceNormalsWhereFacesAreFlat) {
  EXPECT_TRUE(read_file("obj", square + "f 1 2 3 4\n").notes.empty());
  EXPECT_TRUE(read_file("obj", square + up + "f 1//1 2//1 3//1 4//1\n").notes.empty());
  // Two faces of a wedge with corners in common.
  const std::string wedge = square + "v 2 0 1\nv 2 1 1\n";
  expect_note(read_file("obj", wedge + "f 1 2 3 4\nf 2 5 6 3\n"), "drawn flat; without <boolean");
  EXPECT_TRUE(read_file("obj", wedge + "f 1 2 3 4\nf 2 5 6 3\n",
                        R"(<boolean name="face_normals" value="true"/>)")
                  .notes.empty());
  expect_note(read_file("obj", square + up + "f 1//1 2//1 3//1\nf 1 3 4\n"),
              "has normals at some corners alone");
  EXPECT_THROW(read_file("obj", square + aslant + "f 1//1 2//1 3//1 4//1\n"), SceneError);
  EXPECT_EQ(mesh(read_file("obj", square + aslant + "f 1//1 2//1 3//1 4//1\n",
                           R"(<boolean name="face_normals" value="true"/>)"))
                .size(),
            1u);
}

TEST_F(MeshFileTest, CutsFacesOfManyCornersAndLeavesOutThoseWithoutArea) {
  const Scene scene = read_file("obj", square + "v -1 0.5 0\nf 1 2 3 4 5\nf 1 1 2\n");
  EXPECT_EQ(mesh(scene).size(), 3u);
  expect_note(scene, "1 faces have no area and are left out");
}

TEST_F(MeshFileTest, SaysWhereTrianglesOfOneFaceOverlap) {
  const std::string dented = "v 0 0 0\nv 2 0 0\nv 0.5 0.5 0\nv 0 2 0\n";
  EXPECT_TRUE(read_file("obj", dented + "f 1 2 3 4\n").notes.empty());  // from the dent: no overlap
  expect_note(read_file("obj", dented + "f 2 3 4 1\n"), "1 faces are concave or cross themselves");
  expect_note(read_file("obj", square + "f 1 3 2 4\n"), "1 faces are concave or cross themselves");
  EXPECT_TRUE(read_file("obj", square + "v -1 0.5 0\nf 1 2 3 4 5\n").notes.empty());
}

TEST_F(MeshFileTest, RefusesMoreFacesThanCanBePrepared) {
  std::string text = square;
  for (int i = 0; i < 100001; ++i) text += "f 1 2 3\n";
  try {
    read_file("obj", text);
    FAIL();
  } catch (const SceneError& error) {
    EXPECT_NE(std::string(error.what()).find("has 100001 faces; supported: up to 100000"),
              std::string::npos);
  }
}

TEST_F(MeshFileTest, ReadsPly) {
  const std::string text =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";
  const Scene scene = read_file("ply", text);
  ASSERT_EQ(mesh(scene).size(), 1u);
  EXPECT_EQ(mesh(scene)[0].corners[2], Vec3(1, 1, 0));
  EXPECT_TRUE(mesh(scene)[0].is_rectangle());
  // Numbers that no vertex has, and files that end early.
  for (const auto& [from, to] :
       {std::pair("0 1 2 3\n", "0 1 2 900000\n"), std::pair("0 1 2 3\n", "0 1 2 -1\n"),
        std::pair("4 0 1 2 3\n", ""), std::pair("face 1", "face 2")}) {
    std::string broken = text;
    broken.replace(broken.find(from), std::string(from).size(), to);
    EXPECT_THROW(read_file("ply", broken), SceneError) << to;
  }
  EXPECT_THROW(read_file("ply", text.substr(0, text.find("end_header"))), SceneError);
  EXPECT_THROW(read_file("ply", "version https://git-lfs.github.com/spec/v1\n"), SceneError);
}

// With other elements and properties before and between what counts.
TEST_F(MeshFileTest, ReadsBinaryPlyInBothOrdersOfBytes) {
  for (const bool is_big : {false, true}) {
    std::string text = fmt::format(
        "ply\r\nformat binary_{}_endian 1.0\ncomment element face 7\nelement mark 1\n"
        "property list uchar short what\nelement vertex 3\nproperty double x\nproperty uint8 red\n"
        "property float y\nproperty float z\nelement face 1\n"
        "property list int32 ushort vertex_index\nend_header\n",
        is_big ? "big" : "little");
    const auto add = [&](auto number) {
      std::string bytes(reinterpret_cast<const char*>(&number), sizeof number);
      if (is_big) std::ranges::reverse(bytes);
      text += bytes;
    };
    add(uint8_t{2}), add(int16_t{-1}), add(int16_t{5});
    for (int i = 0; i < 3; ++i) add(i == 1 ? 0.1 : 0.0), add(uint8_t{9}), add(float(i)), add(0.5F);
    add(int32_t{3}), add(uint16_t{2}), add(uint16_t{1}), add(uint16_t{0});
    const Mesh faces = mesh(read_file("ply", text));
    ASSERT_EQ(faces.size(), 1u);
    EXPECT_EQ(faces[0].corners[1], Vec3(0.1, 1, 0.5));
    EXPECT_THROW(read_file("ply", text.substr(0, text.size() - 1)), SceneError);
  }
}

TEST_F(MeshFileTest, ReadsNormalsOfPly) {
  const auto with_normals = [&](const std::string& normal) {
    return read_file("ply",
                     fmt::format("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                                 "property float y\nproperty float z\nproperty float nx\n"
                                 "property float ny\nproperty float nz\nelement face 1\n"
                                 "property list uchar int vertex_indices\nend_header\n"
                                 "0 0 0 {0}\n1 0 0 {0}\n1 1 0 {0}\n3 0 1 2\n",
                                 normal));
  };
  EXPECT_TRUE(with_normals("0 0 1").notes.empty());
  EXPECT_THROW(with_normals("0.6 0 0.8"), SceneError);  // for smooth shading
}

TEST_F(MeshFileTest, RefusesFilesThatDoNotEndOrCannotBeNamed) {
  for (const std::string& name : {std::string("/dev/zero"), std::string(5000, 'a')}) {
    for (const std::string shape :
         {R"(<shape type="obj"><string name="filename" value="{}"/></shape>)",
          R"(<shape type="cube"><bsdf type="diffuse">
             <spectrum name="reflectance" filename="{}"/></bsdf></shape>)",
          R"(<include filename="{}"/>)"}) {
      EXPECT_THROW(read_with_sensor(fmt::format(fmt::runtime(shape), name)), SceneError) << shape;
    }
  }
}

// Headers that announce what never comes must not be believed.
TEST_F(MeshFileTest, RefusesWhatPlyHeadersClaim) {
  for (const char* claim :
       {"element vertex 18446744073709551615\n",
        "element edge 18446744073709551615\nelement face 1\n",
        "element face 1\nproperty list double int vertex_indices\n", "element vertex -1\nelement",
        "property int x\n", "element vertex 1\nproperty list x\n"}) {
    EXPECT_THROW(
        read_file("ply", fmt::format("ply\nformat ascii 1.0\n{}end_header\n1e308 0", claim)),
        SceneError)
        << claim;
  }
}

}  // namespace
}  // namespace plumb
