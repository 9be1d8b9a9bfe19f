// SPDX-License-Identifier: Apache-2.0

// What may be relied on about `plumb radiosity`.
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
  EXPECT_TRUE(contains(made.settings.value(), "elements="));
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

TEST_F(RadiosityCommand, RefusesWhatIsNoMattePolygonBeforeAnyFileIsWritten) {
  const Result result = plumb("radiosity " PLUMB_SCENES "/seed/scene.xml -o a.exr");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.output, "is a sphere")) << result.output;
  EXPECT_FALSE(std::filesystem::exists(folder / "a.exr"));
}

}  // namespace
}  // namespace plumb
