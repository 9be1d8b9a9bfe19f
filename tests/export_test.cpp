// What may be relied on about exported scene files.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "reference_scenes/exporters.h"
#include "scene_files/scene_reader.h"
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

TEST(Export, StoredFilesAreWhatTheScenesGive) {
  for (const std::string name : {"cornell", "seed"}) {
    const fs::path folder = fs::path(PLUMB_SCENES) / name;
    const Scene scene = read_scene(folder / "scene.xml");
    EXPECT_EQ(text_of(folder / (name + ".pov")), povray_scene(scene)) << "'make exports' renews it";
    EXPECT_EQ(text_of(folder / (name + ".py")), cycles_scene(scene)) << "'make exports' renews it";
  }
}

TEST(Export, PutsTheIncludeBesideTheFile) {
  const fs::path folder = fresh_folder();
  const Scene scene = scene_with_hostile_names();
  EXPECT_EQ(export_to_povray(scene, folder / "a.pov"), folder / "plumbline.inc");
  EXPECT_EQ(export_to_cycles(scene, folder / "a.py"), folder / "plumbline_cycles.py");
  for (const char* include : {"plumbline.inc", "plumbline_cycles.py"}) {
    EXPECT_EQ(text_of(folder / include), text_of(fs::path(PLUMB_SCENES) / include));
  }
}

TEST(Export, LeavesAnIncludeThatIsThereAndLinked) {
  const fs::path folder = fresh_folder();
  fs::create_symlink(fs::path(PLUMB_SCENES) / "plumbline.inc", folder / "plumbline.inc");
  export_to_povray(scene_with_hostile_names(), folder / "a.pov");
  EXPECT_TRUE(fs::is_symlink(folder / "plumbline.inc"));
}

TEST(Export, RefusesWhatCannotBeWritten) {
  const Scene scene = scene_with_hostile_names();
  EXPECT_THROW(export_to_povray(scene, "/nonexistent/a.pov"), std::runtime_error);
  EXPECT_THROW(export_to_povray(scene, fresh_folder() / "plumbline.inc"), std::runtime_error);
}

}  // namespace
}  // namespace plumb
