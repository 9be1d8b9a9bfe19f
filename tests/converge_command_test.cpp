// SPDX-License-Identifier: Apache-2.0

// What may be relied on about `plumb converge` and `plumb chart`: they are run as a user would run
// them, on real renders.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "images/image.h"
#include "tests/plumb_command.h"

namespace plumb {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

Json read_json(const fs::path& file) {
  std::ifstream stream(file);
  return Json::parse(stream);
}

// With a converged picture of the Cornell box.
class ConvergeCommand : public PlumbCommand {
 protected:
  void SetUp() override {
    PlumbCommand::SetUp();
    ASSERT_EQ(plumb("render " + scene + " --size 32x32 --spp 16384 --seed 9 -o ref.exr").exit_code,
              0);
  }

  Result converge(const std::string& arguments) const {
    return plumb("converge " + scene + " --size 32x32 --reference ref.exr " + arguments);
  }

  const std::string scene = "'" PLUMB_SCENES "/cornell/scene.xml'";
};

TEST_F(ConvergeCommand, FindsTheLawOfIndependentSamplesAndOfSobolOnes) {
  const Result result =
      converge("--samplers independent,sobol --spp 1:256 --runs 8 --json a.json -o a.svg");
  EXPECT_EQ(result.exit_code, 0) << result.output;
  const Json report = read_json(folder / "a.json");
  const Json& independent = report["series"][0]["fits"][3];
  EXPECT_EQ(independent["channel"], "all");
  const auto low = independent["exponent"][1].get<double>();
  const auto high = independent["exponent"][2].get<double>();
  // 95 % would fail with one seed in 20; the interval is four times wider.
  EXPECT_LT(low - 2.0 * (high - low), 1.0);
  EXPECT_GT(high + 2.0 * (high - low), 1.0);
  EXPECT_LT(high - low, 0.2);
  EXPECT_FALSE(independent["stops"]);
  EXPECT_GT(report["series"][1]["fits"][3]["exponent"][1], 1.05);
  std::ifstream svg(folder / "a.svg");
  std::string first;
  std::getline(svg, first);
  EXPECT_TRUE(contains(first, "xml"));
}

TEST_F(ConvergeCommand, SeesWhatCutPathsLack) {
  const Result result = converge("--bounces 0:2 --spp 1:512 --runs 3 --json a.json");
  EXPECT_EQ(result.exit_code, 0) << result.output;
  const Json fit = read_json(folder / "a.json")["series"][0]["fits"][3];
  EXPECT_TRUE(fit["stops"]);
  // What is missing, by two converged pictures.
  plumb("render " + scene + " --size 32x32 --bounces 0:2 --spp 16384 --seed 8 -o cut.exr");
  const Image cut = read_image(folder / "cut.exr");
  const Image whole = read_image(folder / "ref.exr");
  double sum = 0.0;
  for (size_t i = 0; i < cut.values.size(); i += cut.channels.size()) {
    for (size_t c = 0; c < 3; ++c) {
      const double r = whole.values[i + c];
      sum += (cut.values[i + c] - r) * (cut.values[i + c] - r) / (r * r + 0.01);
    }
  }
  const double expected = std::sqrt(sum / (32 * 32 * 3));
  EXPECT_NEAR(fit["bias"][0], expected, 0.05 * expected);
}

TEST_F(ConvergeCommand, KeepsRendersAndTakesThemTheNextTime) {
  ASSERT_EQ(converge("--spp 1:4 --runs 2 --keep kept").exit_code, 0);
  const fs::path file = folder / "kept" / "cornell-mis-sobol-4spp-seed6.exr";
  ASSERT_TRUE(fs::exists(file));
  const auto written = fs::last_write_time(file);
  ASSERT_EQ(converge("--spp 1:4 --runs 2 --keep kept").exit_code, 0);
  EXPECT_EQ(fs::last_write_time(file), written);
  ASSERT_EQ(converge("--spp 1:4 --runs 2 --keep kept --bounces 0:3").exit_code, 0);
  EXPECT_NE(fs::last_write_time(file), written);
}

TEST_F(ConvergeCommand, ChartsWhatItFindsAndSaysWhatItCantUse) {
  ASSERT_EQ(converge("--methods nee,mis --spp 1:16 --runs 2 --keep kept").exit_code, 0);
  ASSERT_EQ(plumb("render " + scene + " --size 32x32 --spp 4 -o one.exr").exit_code, 0);
  ASSERT_EQ(plumb("render " + scene + " --size 16x16 --spp 4 -o small.exr").exit_code, 0);
  ASSERT_EQ(plumb("render " + scene + " --size 32x32 --spp 64 -o anyone.png").exit_code, 0);
  const std::string pictures = "kept/*.exr one.exr=lonely,4,0.5 small.exr ";
  const Result chart =
      plumb("chart " + pictures + "anyone.png=untimed,64 --reference ref.exr -o a.png");
  EXPECT_EQ(chart.exit_code, 2);
  EXPECT_TRUE(contains(chart.output, "plumbline nee sobol")) << chart.output;
  EXPECT_TRUE(contains(chart.output, "small.exr: the test shows 16 x 16 pixels"));
  EXPECT_TRUE(contains(chart.output, "lonely: a fit needs four pictures"));
  EXPECT_TRUE(fs::exists(folder / "a.png"));
  const Result untimed =
      plumb("chart kept/*.exr ref.exr=untimed,64 --reference ref.exr --json a.json");
  EXPECT_EQ(untimed.exit_code, 0) << untimed.output;
}

// Who renders a picture names its renderer; gnuplot takes a line for a command.
TEST_F(ConvergeCommand, NoPictureRunsCommands) {
  ASSERT_EQ(plumb("render " + scene + " --size 32x32 --spp 4 -o other.exr").exit_code, 0);
  Image image = read_image(folder / "other.exr");
  image.provenance.renderer = "it's\n!touch owned\n";
  write_image(image, folder / "other.exr");
  const Result chart = plumb("chart other.exr --reference ref.exr -o a.svg");
  EXPECT_TRUE(contains(chart.output, R"(it's\x0a!touch)")) << chart.output;
  EXPECT_TRUE(fs::exists(folder / "a.svg")) << chart.output;
  EXPECT_FALSE(fs::exists(folder / "owned"));
}

// README's own `plumb chart *.exr --reference box.exr` names the reference twice.
TEST_F(ConvergeCommand, LeavesOutTheReferenceAndWhatSharesItsSamples) {
  ASSERT_EQ(plumb("render " + scene + " --size 32x32 --spp 4 --seed 9 -o half.exr").exit_code, 0);
  ASSERT_EQ(plumb("render " + scene + " --size 32x32 --spp 4 -o other.exr").exit_code, 0);
  const Result chart = plumb("chart *.exr --reference ref.exr --json a.json");
  EXPECT_EQ(chart.exit_code, 0) << chart.output;
  EXPECT_TRUE(contains(chart.output, "ref.exr: left out, as it has the same pixels"));
  EXPECT_TRUE(contains(chart.output, "half.exr: left out, as it shares samples"));
  const Json report = read_json(folder / "a.json");
  ASSERT_EQ(report["series"].size(), 1U);
  EXPECT_EQ(report["series"][0]["points"][0]["samples"], 4);
}

TEST_F(ConvergeCommand, OtherScenesAreTakenOnlyWhenAsked) {
  const std::string other = "'" PLUMB_SCENES "/seed/scene.xml'";
  ASSERT_EQ(plumb("render " + other + " --size 32x32 --spp 4 -o other.exr").exit_code, 0);
  for (const std::string command : {"chart other.exr --reference", "compare other.exr"}) {
    const Result refused = plumb(command + " ref.exr");
    EXPECT_EQ(refused.exit_code, 2) << refused.output;
    EXPECT_TRUE(contains(refused.output, "--other-scene allows it")) << refused.output;
    EXPECT_NE(plumb(command + " ref.exr --other-scene").exit_code, 2);
  }
}

TEST_F(ConvergeCommand, RefusesWhatMakesNoSense) {
  ASSERT_EQ(plumb("render " + scene + " --size 32x32 --spp 4 -o other.exr").exit_code, 0);
  for (const auto& [arguments, message] : std::vector<std::pair<std::string, std::string>>{
           {"converge none.exr --reference ref.exr", "none.exr: cannot open"},
           {"converge none.xml --reference ref.exr", "none.xml"},
           {"converge ref.exr --reference none.exr", "none.exr: cannot open"},
           {"chart ref.exr=a,0,1 --reference ref.exr", "'0' is not a number from 1"},
           {"converge " + scene + " --methods magic --reference ref.exr", "'magic' is not one of"},
           {"converge " + scene + " --spp 0:4 --reference ref.exr", "'0' is not a whole number"},
           {"converge " + scene + " --size 8x8 --reference ref.exr", "8 x 8 pixels"},
           {"chart ref.exr --reference ref.exr", "ref.exr: left out, as it has the same pixels"},
           {"chart other.exr --reference ref.exr -o a.jpg", ".svg or .png"}}) {
    const Result result = plumb(arguments);
    EXPECT_EQ(result.exit_code, 2) << arguments;
    EXPECT_TRUE(contains(result.output, message)) << result.output;
  }
}

}  // namespace
}  // namespace plumb
