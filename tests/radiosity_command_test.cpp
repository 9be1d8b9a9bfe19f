// SPDX-License-Identifier: Apache-2.0

// What may be relied on about `plumb radiosity`.
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "images/image.h"
#include "tests/plumb_command.h"

namespace plumb {
namespace {

using RadiosityCommand = PlumbCommand;

const std::string cornell = PLUMB_SCENES "/cornell/scene.xml";

TEST_F(RadiosityCommand, HelpHasExamplesAndFitsIntoATerminal) {
  const Result result = plumb("radiosity --help");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_TRUE(contains(result.output, "\nExamples:"));
  std::istringstream lines(result.output);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80U) << line;
}

TEST_F(RadiosityCommand, PictureTellsHowItWasMadeAndHowWrongItIs) {
  const Result result = plumb("radiosity " + cornell + " --size 16x12 --bounces 1:3 -o a.exr");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  const Image image = read_image(folder / "a.exr");
  EXPECT_EQ(image.width, 16);
  EXPECT_EQ(image.height, 12);
  const Provenance& made = image.provenance;
  EXPECT_EQ(made.method, "radiosity");
  EXPECT_EQ(made.bounces, "1:3");
  EXPECT_EQ(made.precision, "double");
  EXPECT_TRUE(contains(made.quality.value(), " elements"));
  for (const auto& number :
       {made.relative_error, made.image_floor, made.region_floor, made.wall_seconds}) {
    EXPECT_GT(number.value(), 0.0);
  }
}

TEST_F(RadiosityCommand, ComparisonTakesItsErrorAsTheFloorOfAReference) {
  ASSERT_EQ(plumb("radiosity " + cornell + " --size 16x16 -o exact.exr").exit_code, 0);
  ASSERT_EQ(plumb("render " + cornell + " --size 16x16 --spp 4096 -o render.exr").exit_code, 0);
  const Result same = plumb("compare render.exr exact.exr");
  EXPECT_EQ(same.exit_code, 0) << same.output;
  EXPECT_TRUE(contains(same.output, "elsewhere, by its own account")) << same.output;
  ASSERT_EQ(
      plumb("render " + cornell + " --size 16x16 --spp 4096 --bounces 0:3 -o cut.exr").exit_code,
      0);
  EXPECT_EQ(plumb("compare cut.exr exact.exr").exit_code, 1);
}

TEST_F(RadiosityCommand, DrawsPatchesWithTheirError) {
  const Result result =
      plumb("radiosity " + cornell + " --size 16x12 --elements constant --bounces 1:3 -o a.exr");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  const Provenance made = read_image(folder / "a.exr").provenance;
  EXPECT_EQ(made.method, "constant radiosity");
  EXPECT_EQ(made.bounces, "1:3");
  EXPECT_GT(made.relative_error.value(), 0.0);
}

TEST_F(RadiosityCommand, WritesALesson) {
  const Result result =
      plumb("radiosity " PLUMB_SCENES "/goral/scene.xml --size 32x24 --teach new/lesson");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  for (const char* name :
       {"matrix.png", "row.png", "hemicube.png", "hemicubes.svg", "bounces.png", "shooting.png",
        "shooting.svg", "sweeps.svg", "leaks.png", "mesh.png", "refinement.png", "meshes.svg"}) {
    EXPECT_GT(std::filesystem::file_size(folder / "new/lesson" / name), 100U) << name;
  }
  std::ifstream file(folder / "new/lesson/lesson.json");
  const std::string numbers{std::istreambuf_iterator<char>(file), {}};
  for (const char* part :
       {"form_factors", "hemicubes", "bounces", "shooting", "sweeps", "leaks", "meshes"}) {
    EXPECT_TRUE(contains(numbers, std::string("\"") + part + '"')) << part;
  }
  EXPECT_FALSE(contains(numbers, "null"));
}

TEST_F(RadiosityCommand, SaysWhatALessonTakes) {
  const auto refusal = [&](const std::string& options) {
    const Result result = plumb("radiosity " + options);
    EXPECT_NE(result.exit_code, 0);
    return result.output;
  };
  EXPECT_TRUE(contains(refusal(cornell), "--output or --teach is required"));
  EXPECT_TRUE(contains(refusal(cornell + " --teach a -o a.png"), "excludes"));
  EXPECT_TRUE(contains(refusal(cornell + " --teach a --bounces 0:1"), "excludes"));
  EXPECT_TRUE(contains(refusal(cornell + " --elements constant --error 1% -o a.png"), "excludes"));
  EXPECT_TRUE(contains(refusal(cornell + " --elements square -o a.png"), "linear, constant"));
  EXPECT_TRUE(contains(refusal(PLUMB_SCENES "/seed/scene.xml --teach a"), "is a sphere"));
  std::ofstream(folder / "file") << "text";
  EXPECT_TRUE(contains(refusal(cornell + " --teach file"), "file/lesson.json"));
}

TEST_F(RadiosityCommand, RefusesWhatIsNoMattePolygonBeforeAnyFileIsWritten) {
  const Result result = plumb("radiosity " PLUMB_SCENES "/seed/scene.xml -o a.exr");
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_TRUE(contains(result.output, "is a sphere")) << result.output;
  EXPECT_FALSE(std::filesystem::exists(folder / "a.exr"));
}

}  // namespace
}  // namespace plumb
