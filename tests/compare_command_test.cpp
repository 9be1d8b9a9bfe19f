// SPDX-License-Identifier: Apache-2.0

// What may be relied on about `plumb compare` and files: it is run as a user would run it.
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "images/image.h"
#include "tests/plumb_command.h"

namespace plumb {
namespace {

namespace fs = std::filesystem;

constexpr int same = 0, different = 1, trouble = 2, inconclusive = 3;

std::string text_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void write_text(const fs::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

// With the picture clean.exr.
class CompareCommand : public PlumbCommand {
 protected:
  void SetUp() override {
    PlumbCommand::SetUp();
    for (int i = 0; i < 32 * 24 * 3; ++i) clean.values.push_back(0.1F + float(i % 97) / 100.0F);
    write_image(clean, folder / "clean.exr");
  }

  Result compare(const std::string& arguments) const { return plumb("compare " + arguments); }

  // Neither side, nor both, may hold the file.
  void expect_trouble(const std::string& file, const std::string& reason) const {
    for (const std::string& pair : {file + " clean.exr", "clean.exr " + file, file + " " + file}) {
      const Result result = compare(pair);
      EXPECT_EQ(result.exit_code, trouble) << pair << ": " << result.output;
      EXPECT_NE(result.output.find(reason), std::string::npos) << result.output;
      EXPECT_TRUE(result.output.starts_with("plumb: ")) << result.output;
    }
  }

  Image clean{32, 24, {"R", "G", "B"}, {}, {}};
};

TEST_F(CompareCommand, EqualPicturesAreTheSame) {
  const Result result = compare("clean.exr clean.exr --tolerance 0");
  EXPECT_EQ(result.exit_code, same) << result.output;
  EXPECT_NE(result.output.find("plain check"), std::string::npos) << result.output;
}

TEST_F(CompareCommand, PicturesOfVeryFewSamplesGetAWarning) {
  for (const auto& [samples, is_warned] : {std::pair{"0:8", true}, {"0:16", false}}) {
    clean.provenance = {.samples = samples};
    write_image(clean, folder / "few.exr");
    const Result result = compare("few.exr clean.exr");
    EXPECT_EQ(contains(result.output, "test: too few samples"), is_warned) << result.output;
  }
}

// Unfit files

TEST_F(CompareCommand, BadValuesAreTrouble) {
  using Limits = std::numeric_limits<float>;
  for (const float bad : {Limits::quiet_NaN(), Limits::infinity(), -Limits::infinity(), -1e-6F}) {
    Image image = clean;
    image.values[(7 * 32 + 5) * 3 + 1] = bad;
    write_image(image, folder / "bad.exr");
    expect_trouble("bad.exr", "at 5,7 in G");
    image.values.assign(image.values.size(), bad);
    write_image(image, folder / "bad.exr");
    expect_trouble("bad.exr", "2304");
  }
}

TEST_F(CompareCommand, NegativeValuesCanBeAllowed) {
  Image image = clean;
  image.values[0] = -1.0F;
  write_image(image, folder / "negative.exr");
  EXPECT_EQ(compare("negative.exr negative.exr --negative").exit_code, same);
  EXPECT_TRUE(contains(compare("negative.exr negative.exr").output, "--negative allows"));
}

TEST_F(CompareCommand, UnreadableFilesAreTrouble) {
  const std::string whole = text_of(folder / "clean.exr");
  write_text(folder / "cut.exr", whole.substr(0, whole.size() / 2));
  write_text(folder / "empty.exr", "");
  write_text(folder / "text.exr", "No picture");
  write_text(folder / "text.png", "No picture");
  write_text(folder / "clean.odd", whole);
  fs::create_directory(folder / "folder.exr");
  expect_trouble("cut.exr", "damaged");
  expect_trouble("empty.exr", "empty");
  expect_trouble("text.exr", "not an EXR image");
  expect_trouble("text.png", "not a PNG image");
  expect_trouble("clean.odd", "unknown image format");
  for (const char* pair : {"folder.exr clean.exr", "clean.exr folder.exr"}) {
    EXPECT_TRUE(contains(compare(pair).output, "folder.exr: cannot read: Is a directory"));
  }
  expect_trouble("missing.exr", "No such file");
}

// The width in the header becomes 2^20: 200 MB, in a file of 7 kB.
TEST_F(CompareCommand, HeaderThatAsksForFarTooMuchMemoryIsTrouble) {
  std::string bytes = text_of(folder / "clean.exr");
  for (const std::string name : {"dataWindow", "displayWindow"}) {
    const size_t window = bytes.find(name + '\0' + "box2i" + '\0') + name.size() + 7 + 4;
    bytes.replace(window + 8, 4, std::string("\xff\xff\x0f\0", 4));
  }
  write_text(folder / "giant.exr", bytes);
  expect_trouble("giant.exr", "1048576 x 24 pixels");
}

TEST_F(CompareCommand, ChannelsMayHaveAnyName) {
  Image image = clean;
  image.channels = {"a=b", "c,d", "="};
  write_image(image, folder / "odd.exr");
  EXPECT_EQ(compare("odd.exr odd.exr --negative").exit_code, same);
}

// Whatever a file says steers no terminal and breaks no report.
TEST_F(CompareCommand, NamesInFilesAreShownEscaped) {
  Image image = clean;
  image.channels = {"R", "G\x1b[2J", "B\xff\n"};
  write_image(image, folder / "odd.exr");
  const std::string shown = R"(G\x1b[2J)";
  const auto is_plain = [](const std::string& text) {
    return text.find('\x1b') == text.npos && text.find('\xff') == text.npos;
  };
  for (const std::string other : {"odd.exr", "clean.exr"}) {
    const Result result = compare("odd.exr " + other + " --json odd.json");
    EXPECT_TRUE(contains(result.output, shown) && is_plain(result.output)) << result.output;
    const std::string json = nlohmann::json::parse(text_of(folder / "odd.json")).dump();
    EXPECT_TRUE(contains(json, R"(G\\x1b[2J)")) << json;
  }
  EXPECT_TRUE(contains(compare("odd.exr odd.exr").output, R"(B\xff\x0a)"));
  write_text(folder / "gate.toml",
             "[[compare]]\ntest = 'odd.exr'\nreference = 'clean.exr'\nname = \"a\\u001B\"\n");
  const Result gate = compare("--gate gate.toml --junit result.xml");
  for (const std::string& text : {gate.output, text_of(folder / "result.xml")}) {
    EXPECT_TRUE(contains(text, shown) && contains(text, R"(a\x1b)") && is_plain(text)) << text;
  }
}

TEST_F(CompareCommand, OtherSizeOrChannelsAreTrouble) {
  Image image = clean;
  image.width = 24;
  image.height = 32;
  write_image(image, folder / "upright.exr");
  EXPECT_EQ(compare("upright.exr clean.exr").exit_code, trouble);
  image = clean;
  image.channels = {"R", "G", "A"};
  write_image(image, folder / "rga.exr");
  EXPECT_EQ(compare("rga.exr clean.exr").exit_code, trouble);
  EXPECT_EQ(compare("rga.exr clean.exr --channels R,G").exit_code, same);
  EXPECT_EQ(compare("rga.exr clean.exr --channels R,B").exit_code, trouble);
}

TEST_F(CompareCommand, OtherDisplayWindowsAreTroubleThatNamesBoth) {
  const Image small{20, 12, clean.channels, std::vector<float>(20 * 12 * 3, 0.5F), {}};
  write_image(small, folder / "small.exr");
  const Result result = compare("small.exr clean.exr");
  EXPECT_EQ(result.exit_code, trouble);
  EXPECT_TRUE(contains(result.output, "shows 20 x 12 pixels at 0,0, the reference 32 x 24 pixels"));
}

TEST_F(CompareCommand, OverscanIsLeftOutIfTheOtherPictureHasLess) {
  const auto store = [&](const std::string& name, int border, float around) {
    OIIO::ImageSpec spec(32 + 2 * border, 24 + 2 * border, 3, OIIO::TypeDesc::FLOAT);
    spec.x = spec.y = -border;
    spec.full_width = 32;
    spec.full_height = 24;
    std::vector<float> values(spec.image_pixels() * 3, around);
    for (int y = 0; y < 24; ++y) {
      std::copy_n(&clean.values[size_t(y) * 32 * 3], 32 * 3,
                  &values[size_t((y + border) * spec.width + border) * 3]);
    }
    const auto output = OIIO::ImageOutput::create("x.exr");
    ASSERT_TRUE(output->open((folder / name).string(), spec));
    ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, values.data()) && output->close());
  };
  store("little.exr", 2, 1.0F);
  store("much.exr", 5, 2.0F);
  store("other.exr", 5, 3.0F);
  for (const char* pair : {"much.exr clean.exr", "clean.exr much.exr", "much.exr little.exr"}) {
    const Result result = compare(std::string(pair) + " --tolerance 0");
    EXPECT_EQ(result.exit_code, same) << pair << result.output;
    EXPECT_TRUE(contains(result.output, "outside its display window was left out"))
        << result.output;
  }
  EXPECT_EQ(compare("much.exr other.exr --tolerance 0").exit_code, different);
}

// Channels

// The clean picture with other channels, which have the same value everywhere.
Image with(Image image, const std::vector<std::pair<std::string, float>>& channels) {
  Image result{image.width, image.height, image.channels, {}, {}};
  for (const auto& [name, value] : channels) result.channels.push_back(name);
  for (size_t i = 0; i < image.values.size(); i += 3) {
    for (size_t c = 0; c < 3; ++c) result.values.push_back(image.values[i + c]);
    for (const auto& [name, value] : channels) result.values.push_back(value);
  }
  return result;
}

TEST_F(CompareCommand, AllChannelsAreComparedEachInItsUnit) {
  write_image(with(clean, {{"A", 0.1F}, {"Z", 100.0F}, {"N.X", -0.5F}, {"N.Y", 0.0F}}),
              folder / "reference.exr");
  const auto verdict = [&](float alpha, float depth, float normal) {
    write_image(with(clean, {{"A", alpha}, {"Z", depth}, {"N.X", normal}, {"N.Y", 0.0F}}),
                folder / "test.exr");
    return compare("test.exr reference.exr --tolerance 1%").exit_code;
  };
  EXPECT_EQ(verdict(0.109F, 100.9F, -0.504F), same);
  EXPECT_EQ(verdict(0.111F, 100.0F, -0.5F), different);
  EXPECT_EQ(verdict(0.1F, 98.9F, -0.5F), different);
  EXPECT_EQ(verdict(0.1F, 100.0F, -0.506F), different);
  compare("test.exr reference.exr --json result.json");
  const auto json = nlohmann::json::parse(text_of(folder / "result.json"));
  ASSERT_EQ(json["channels"].size(), 8U);
  EXPECT_EQ(json["channels"][3]["channel"], "A");
  EXPECT_EQ(json["channels"][7]["channel"], "all");
  EXPECT_EQ(json["channels"][7]["difference"], 0.0);  // of the colours alone
}

TEST_F(CompareCommand, WhatOnlyOneSideHasIsTroubleUnlessItIsLeftOut) {
  write_image(with(clean, {{"A", 1.0F}}), folder / "alpha.exr");
  Result result = compare("alpha.exr clean.exr");
  EXPECT_EQ(result.exit_code, trouble);
  EXPECT_TRUE(contains(result.output, "only the test has A: --channels R,G,B")) << result.output;
  result = compare("clean.exr alpha.exr");
  EXPECT_EQ(result.exit_code, trouble);
  EXPECT_TRUE(contains(result.output, "only the reference has A")) << result.output;
  result = compare("alpha.exr clean.exr --channels R,G,B --json result.json");
  EXPECT_EQ(result.exit_code, same);
  EXPECT_TRUE(contains(result.output, "test: not compared: A")) << result.output;
  const auto json = nlohmann::json::parse(text_of(folder / "result.json"));
  EXPECT_EQ(json["leftOut"], nlohmann::json::parse(R"({"test": ["A"], "reference": []})"));
}

TEST_F(CompareCommand, LayersAndChannelsMayHaveOtherNamesOnEachSide) {
  Image layer = clean;
  layer.channels = {"View.Combined.R", "View.Combined.G", "View.Combined.B"};
  write_image(layer, folder / "layer.exr");
  EXPECT_EQ(compare("layer.exr clean.exr").exit_code, trouble);
  EXPECT_EQ(compare("layer.exr clean.exr --layer View.Combined=").exit_code, same);
  EXPECT_EQ(compare("clean.exr layer.exr --layer =View.Combined --channels R,B").exit_code, same);
  EXPECT_EQ(compare("layer.exr layer.exr --layer View.Combined").exit_code, same);
  EXPECT_EQ(compare("clean.exr layer.exr --channels R=View.Combined.R").exit_code, same);
  EXPECT_EQ(compare("clean.exr layer.exr --channels R=View.Combined.G").exit_code, different);
  EXPECT_EQ(compare("clean.exr layer.exr --layer =View.Odd").exit_code, trouble);
}

TEST_F(CompareCommand, ChannelsOfNoiseAloneAreTrouble) {
  Image noise = clean;
  noise.channels = {"variance.R", "variance.G", "replicate0.R"};
  write_image(noise, folder / "noise.exr");
  const Result result = compare("noise.exr noise.exr");
  EXPECT_EQ(result.exit_code, trouble);
  EXPECT_TRUE(contains(result.output, "nothing to compare")) << result.output;
}

// What is not compared

TEST_F(CompareCommand, NoiseOfSingleSamplesIsNamedAndLeftOut) {
  write_image(with(clean, {{"Variance.R", 1}, {"m2_image.X", 1}}), folder / "a.exr");
  write_image(with(clean, {{"Variance.R", 2}, {"m2_image.X", 2}}), folder / "b.exr");
  const Result result = compare("a.exr b.exr --tolerance 0");
  EXPECT_EQ(result.exit_code, same) << result.output;
  EXPECT_TRUE(contains(result.output, "Variance.R m2_image.X tell of samples")) << result.output;
  EXPECT_TRUE(contains(result.output, "noise not known"));
}

TEST_F(CompareCommand, BadValuesOutsideOfCropAndRegionsDontCount) {
  Image bad = clean;
  bad.values[0] = std::numeric_limits<float>::infinity();
  bad.values[3] = std::numeric_limits<float>::quiet_NaN();
  write_image(bad, folder / "bad.exr");
  EXPECT_EQ(compare("bad.exr clean.exr --tolerance 0 --crop 2,0,30,24").exit_code, same);
  EXPECT_EQ(compare("bad.exr clean.exr --tolerance 0 --crop 1,0,30,24").exit_code, trouble);
  Image mask{32, 24, {"R", "G", "B"}, {}, {}};
  for (int i = 0; i < 32 * 24; ++i) mask.values.insert(mask.values.end(), 3, i < 2 ? 0.0F : 1.0F);
  write_image(mask, folder / "mask.png");
  EXPECT_EQ(compare("bad.exr clean.exr --tolerance 0 --regions mask.png").exit_code, same);
  mask.values.assign(mask.values.size(), 0.0F);
  write_image(mask, folder / "black.png");
  const Result result = compare("clean.exr clean.exr --regions black.png");
  EXPECT_EQ(result.exit_code, trouble);
  EXPECT_TRUE(contains(result.output, "no pixel to compare")) << result.output;
}

TEST_F(CompareCommand, MasksHoldCodes) {
  for (const float wrong : {std::numeric_limits<float>::quiet_NaN(), 1e30F, -1.0F}) {
    Image mask = clean;
    mask.values[7] = wrong;
    write_image(mask, folder / "mask.exr");
    const Result result = compare("clean.exr clean.exr --regions mask.exr");
    EXPECT_EQ(result.exit_code, trouble);
    EXPECT_TRUE(contains(result.output, "a mask's values are from 0 to 1")) << result.output;
  }
}

TEST_F(CompareCommand, AMasksKindIsTold) {
  Image grey{32, 24, {"Y"}, std::vector<float>(32 * 24, 1.0F), {}};
  write_image(grey, folder / "grey.exr");
  EXPECT_TRUE(contains(compare("clean.exr clean.exr --regions grey.exr").output,
                       "a mask in colour (R G B) is needed, this has only Y"));
}

// Formats
// Formats

TEST_F(CompareCommand, TransferFunctionsOfIntegersAreUndoneAndSaid) {
  write_image(clean, folder / "clean.png");
  // A code of 8 bits is off by 1/510 at most, where the slope of radiance is below 2.3.
  const Result result = compare("clean.png clean.exr --tolerance 0.0046 --crop 0,0,9,9");
  EXPECT_NE(result.output.find("test: uint8, srgb, made linear"), std::string::npos)
      << result.output;
}

// Has OpenImageIO write a red pixel and grey ones.
void store(const fs::path& file, const OIIO::ImageSpec& spec, float grey = 0.2F) {
  std::vector<float> values(spec.image_pixels() * size_t(spec.nchannels), grey);
  values[0] = 0.8F;
  const auto output = OIIO::ImageOutput::create(file.string());
  ASSERT_TRUE(output->open(file.string(), spec));
  ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, values.data()));
}

TEST_F(CompareCommand, EqualNumbersWithOtherTagsAreDifferentAndThatIsSaid) {
  constexpr std::array<float, 8> ap0 = {0.7347F, 0.2653F, 0,        1,
                                        0.0001F, -0.077F, 0.32168F, 0.33767F};
  OIIO::ImageSpec exr(8, 8, 3, OIIO::TypeDesc::FLOAT), png(8, 8, 3, OIIO::TypeDesc::UINT8);
  OIIO::ImageSpec tif(8, 8, 4, OIIO::TypeDesc::UINT8);
  store(folder / "plain.exr", exr);
  store(folder / "brighter.exr", exr, 0.3F);
  exr.attribute("chromaticities", OIIO::TypeDesc("float[8]"), ap0.data());
  store(folder / "ap0.exr", exr);
  for (const std::string encoding : {"linear", "sRGB"}) {
    png.attribute("oiio:ColorSpace", encoding);
    store(folder / (encoding + ".png"), png);
  }
  store(folder / "multiplied.tif", tif);
  tif.attribute("oiio:UnassociatedAlpha", 1);
  store(folder / "straight.tif", tif);
  using Pair = std::pair<std::string, std::string>;
  for (const auto& [files, tag] : {Pair("ap0.exr plain.exr", "primaries"),
                                   {"linear.png sRGB.png", "transfer function"},
                                   {"straight.tif multiplied.tif", "alpha"}}) {
    const Result result = compare(files + " --json result.json");
    EXPECT_EQ(result.exit_code, different) << result.output;
    EXPECT_TRUE(
        contains(result.output, "the stored numbers are equal, only tags differ (" + tag + ")"))
        << result.output;
    const auto json = nlohmann::json::parse(text_of(folder / "result.json"));
    EXPECT_EQ(json["onlyTagsDiffer"], nlohmann::json::array({tag}));
  }
  EXPECT_FALSE(contains(compare("ap0.exr brighter.exr").output, "only tags differ"));
}

TEST_F(CompareCommand, PfmIsReadWithItsFirstRowBelow) {
  std::string bytes = "PF\n32 24\n-1.0\n";
  for (int y = 23; y >= 0; --y) {
    const auto* row = reinterpret_cast<const char*>(&clean.values[size_t(y) * 32 * 3]);
    bytes.append(row, 32 * 3 * sizeof(float));
  }
  write_text(folder / "clean.pfm", bytes);
  const auto result = compare("clean.pfm clean.exr --tolerance 0");
  EXPECT_EQ(result.exit_code, same);
  EXPECT_EQ(result.output.find("states"), std::string::npos) << result.output;  // a curve
}

TEST_F(CompareCommand, PartsAreChosenByNameOrNumber) {
  const auto output = OIIO::ImageOutput::create("parts.exr");
  std::vector<OIIO::ImageSpec> specs(2, OIIO::ImageSpec(32, 24, 3, OIIO::TypeDesc::FLOAT));
  specs[0].attribute("name", "other");
  specs[1].attribute("name", "beauty");
  ASSERT_TRUE(output->open((folder / "parts.exr").string(), 2, specs.data()));
  const std::vector<float> ones(clean.values.size(), 1.0F);
  ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, ones.data()));
  ASSERT_TRUE(
      output->open((folder / "parts.exr").string(), specs[1], OIIO::ImageOutput::AppendSubimage));
  ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, ones.data()));
  ASSERT_TRUE(output->close());
  EXPECT_EQ(compare("parts.exr parts.exr --part beauty").exit_code, same);
  EXPECT_EQ(compare("parts.exr parts.exr --part 0").exit_code, same);
  EXPECT_EQ(compare("parts.exr parts.exr --part 0=beauty").exit_code, same);
  const Result result = compare("parts.exr parts.exr --part alpha");
  EXPECT_EQ(result.exit_code, trouble);
  EXPECT_NE(result.output.find("0 'other', 1 'beauty'"), std::string::npos) << result.output;
}

// A TIFF of the clean picture and a thumbnail of 8 x 6 pixels of this value.
void store_with_thumbnail(const fs::path& file, const Image& clean, float value) {
  const OIIO::ImageSpec specs[] = {{32, 24, 3, OIIO::TypeDesc::FLOAT},
                                   {8, 6, 3, OIIO::TypeDesc::FLOAT}};
  const std::vector<float> thumbnail(8 * 6 * 3, value);
  const auto output = OIIO::ImageOutput::create("x.tif");
  ASSERT_TRUE(output->open(file.string(), specs[0]));
  ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, clean.values.data()));
  ASSERT_TRUE(output->open(file.string(), specs[1], OIIO::ImageOutput::AppendSubimage));
  ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, thumbnail.data()) && output->close());
}

TEST_F(CompareCommand, PartsOfOtherFramesAreComparedEachForItself) {
  store_with_thumbnail(folder / "dark.tif", clean, 0.1F);
  store_with_thumbnail(folder / "bright.tif", clean, 0.2F);
  const Result result = compare("dark.tif dark.tif --json same.json");
  EXPECT_EQ(result.exit_code, same) << result.output;
  EXPECT_EQ(compare("dark.tif bright.tif --json different.json").exit_code, different);
  const auto json = nlohmann::json::parse(text_of(folder / "different.json"));
  EXPECT_EQ(json["verdict"], "different");
  EXPECT_EQ(json["parts"]["0"]["verdict"], "same");
  EXPECT_EQ(json["parts"]["1"]["verdict"], "different");
  const Result map = compare("dark.tif bright.tif -o map.png");
  EXPECT_EQ(map.exit_code, trouble);
  EXPECT_TRUE(contains(map.output, "part 0 has 32 x 24 pixels at 0,0, part 1 8 x 6 pixels at 0,0"));
  EXPECT_TRUE(contains(map.output, "--part 0 chooses one")) << map.output;
  store_with_thumbnail(folder / "bad.tif", clean, -1);
  EXPECT_TRUE(contains(compare("bad.tif dark.tif").output, "part 1: the test has 144 values"));
}

TEST_F(CompareCommand, CodesCanBeComparedAsTheyAreStored) {
  Image grey{32, 24, {"R", "G", "B"}, std::vector<float>(clean.values.size(), 0.5F), {}};
  write_image(grey, folder / "grey.png");
  compare("grey.png grey.png --codes --json result.json");
  const auto json = nlohmann::json::parse(text_of(folder / "result.json"));
  EXPECT_NEAR(json["channels"][0]["test"].get<double>(), 188.0 / 255.0, 1e-6);  // sRGB of 0.5
}

// The report

TEST_F(CompareCommand, SmallNumbersShowThatTheyAreNotZero) {
  Image test = clean;
  for (float& value : test.values) value *= 0.999999F;
  write_image(test, folder / "test.exr");
  const Result result = compare("test.exr clean.exr --tolerance 0");
  EXPECT_EQ(result.exit_code, different);
  EXPECT_FALSE(contains(result.output, "-0.000 %")) << result.output;
  EXPECT_TRUE(contains(result.output, " -0.0001")) << result.output;
}

TEST_F(CompareCommand, NumbersThatDifferAreShownWithTheDigitsThatTellThemApart) {
  Image test = clean;
  for (float& value : test.values) value *= 1.00001F;
  write_image(test, folder / "test.exr");
  // The mean of red is 0.576302.
  const Result result = compare("test.exr clean.exr --tolerance 0");
  EXPECT_TRUE(contains(result.output, "in R (0.57631, not 0.5763)")) << result.output;
}

TEST_F(CompareCommand, BlackPicturesAreTheSameAndThatIsSaid) {
  EXPECT_TRUE(contains(compare("clean.exr clean.exr").output, "same: all pixels are equal\n"));
  Image black = clean;
  std::ranges::fill(black.values, 0.0F);
  write_image(black, folder / "black.exr");
  const Result result = compare("black.exr black.exr");
  EXPECT_EQ(result.exit_code, same);
  EXPECT_TRUE(contains(result.output, "same: all pixels are equal, and their mean is 0\n"))
      << result.output;
}

TEST_F(CompareCommand, EqualMeansAreNotSaidToDifferByLessThanNothing) {
  Image test = clean;
  std::swap_ranges(test.values.begin(), test.values.begin() + 3, test.values.begin() + 3);
  write_image(test, folder / "test.exr");
  const Result result = compare("test.exr clean.exr --tolerance 0");
  EXPECT_TRUE(contains(result.output, "different: the means are equal, but not 2 pixels"));
}

TEST_F(CompareCommand, SamplesThatAreTooFewAreNotSaidToBeEnough) {
  Image noisy{32, 24, {"R", "G", "B", "variance.R", "variance.G", "variance.B"}, {}, {}};
  noisy.provenance.samples = "0:64";
  for (size_t i = 0; i < clean.values.size(); i += 3) {
    noisy.values.insert(noisy.values.end(), &clean.values[i], &clean.values[i] + 3);
    noisy.values.back() += i % 2 == 0 ? 0.01F : -0.01F;
    noisy.values.insert(noisy.values.end(), 3, 1e-4F);
  }
  write_image(noisy, folder / "noisy.exr");
  const std::string pair = "noisy.exr clean.exr --floor 0 --json result.json --tolerance ";
  compare(pair + "1");
  const auto json = nlohmann::json::parse(text_of(folder / "result.json"));
  double largest = 0.0;
  for (const auto& channel : json["channels"]) {
    largest = std::max(largest, channel["margin"].get<double>());
  }
  const Result result = compare(pair + std::to_string(0.99 * largest));
  EXPECT_EQ(result.exit_code, inconclusive) << result.output;
  // 1 / 0.99^2 = 1.02 of 64 are 65.3.
  EXPECT_TRUE(contains(result.output, "; 1.1 times the samples (66 spp) would tell"))
      << result.output;
}

TEST_F(CompareCommand, AlmostNothingInAnEmptyChannelIsTheSame) {
  Image reference = clean;
  for (size_t i = 2; i < reference.values.size(); i += 3) reference.values[i] = 0.0F;
  Image test = reference;
  test.values[2] = 1e-7F;
  write_image(test, folder / "test.exr");
  write_image(reference, folder / "reference.exr");
  EXPECT_EQ(compare("test.exr reference.exr").exit_code, same);
  const Result result = compare("test.exr reference.exr --tolerance 0");
  EXPECT_EQ(result.exit_code, different);
  EXPECT_TRUE(contains(result.output, "(1.302e-10, not 0)")) << result.output;
}

TEST_F(CompareCommand, JsonTellsTroubleAndInfiniteNumbers) {
  Result result = compare("clean.exr clean.exr --json -");
  EXPECT_EQ(nlohmann::json::parse(result.output)["channels"][0]["psnr"], "Infinity");
  result = compare("missing.exr clean.exr --json result.json");
  EXPECT_EQ(result.exit_code, trouble);
  const auto json = nlohmann::json::parse(text_of(folder / "result.json"));
  EXPECT_EQ(json["verdict"], "trouble");
  EXPECT_TRUE(contains(json["explanation"], "No such file"));
}

// Noise and regions

TEST_F(CompareCommand, AReportThatAFullDiskDoesNotHoldIsTrouble) {
  if (!fs::is_character_file("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
  for (const char* file : {"--json /dev/full", "--markdown /dev/full"}) {
    const Result result = compare(std::string("clean.exr clean.exr ") + file);
    EXPECT_EQ(result.exit_code, trouble);
    EXPECT_TRUE(contains(result.output, "No space left on device")) << result.output;
  }
  EXPECT_EQ(compare("clean.exr clean.exr >/dev/full").exit_code, trouble);
}

TEST_F(CompareCommand, ReplicatesTellTheNoise) {
  for (int seed = 1; seed <= 3; ++seed) {
    Image image = clean;
    for (size_t i = 0; i < image.values.size(); ++i) {
      image.values[i] *= 1.0F + 0.01F * float(int((i * 7919 + size_t(seed) * 104729) % 5) - 2);
    }
    write_image(image, folder / (std::to_string(seed) + ".exr"));
  }
  const std::string options = " --tolerance 1% --replicates 2.exr 3.exr";
  EXPECT_EQ(compare("1.exr clean.exr" + options).exit_code, different);
  EXPECT_EQ(compare("1.exr clean.exr --floor 0" + options).exit_code, same);
  EXPECT_EQ(compare("1.exr clean.exr --floor 0 --tolerance 0 --replicates 2.exr 3.exr").exit_code,
            inconclusive);
}

TEST_F(CompareCommand, TheReferencesCardStatesItsFloor) {
  Image noisy = clean;  // variances as from renders
  noisy.channels = {"R", "G", "B", "variance.R", "variance.G", "variance.B"};
  noisy.values.clear();
  for (size_t i = 0; i < clean.values.size(); i += 3) {
    for (size_t c = 0; c < 3; ++c) noisy.values.push_back(clean.values[i + c] * 1.015F);
    noisy.values.insert(noisy.values.end(), 3, 1e-12F);
  }
  write_image(noisy, folder / "noisy.exr");
  const std::string pair = "noisy.exr clean.exr --tolerance 1%";
  EXPECT_EQ(compare(pair + " --floor 0").exit_code, different);
  std::ofstream(folder / "card.json") << R"({"pictures": [{"file": "clean.exr", "floor":
    {"wholePercent": 0.6, "regionsPercent": {"wall": 5}}}]})";
  // 1.5 % of difference, of which the reference's floor may be 0.6 %: neither is sure.
  const Result result = compare(pair);
  EXPECT_EQ(result.exit_code, inconclusive) << result.output;
  EXPECT_NE(result.output.find("floor 0.6 % of the image, 5 % elsewhere, by its card.json"),
            std::string::npos)
      << result.output;
  EXPECT_NE(result.output.find("a tolerance above 2.1 % could be met"), std::string::npos)
      << result.output;
  EXPECT_EQ(compare("noisy.exr clean.exr --tolerance 2.6%").exit_code, same);
  std::ofstream(folder / "card.json") << "no card";
  EXPECT_EQ(compare(pair).exit_code, trouble);
  fs::remove(folder / "card.json");
}

TEST_F(CompareCommand, PixelsThatDifferMayBeAllowedAndAreTold) {
  Image edge = clean;
  for (const int x : {3, 4, 5}) edge.values[edge.pixel(x, 7) * 3] += 0.1F;
  write_image(edge, folder / "edge.exr");
  const std::string pair = "edge.exr clean.exr --floor 0 --tolerance 1% ";
  const Result refused = compare(pair + "--max-outliers 2");
  EXPECT_EQ(refused.exit_code, different);
  EXPECT_NE(refused.output.find("the means differ by less than 1 % (0.00576), but not 3 pixels "
                                "(0.39 %), most clearly at 3,7; --max-outliers lets them pass"),
            std::string::npos)
      << refused.output;
  for (const char* enough : {"3", "0.4%"}) {
    const Result allowed = compare(pair + "--max-outliers " + enough);
    EXPECT_EQ(allowed.exit_code, same) << allowed.output;
    EXPECT_NE(allowed.output.find("same: the means differ by less than 1 % (0.00576), but for 3 "
                                  "pixels (0.39 %)"),
              std::string::npos)
        << allowed.output;
  }
  EXPECT_EQ(compare(pair + "--max-outliers 0.3%").exit_code, different);
  // The value is 0.1 brighter than one of at least 0.1.
  EXPECT_EQ(compare(pair + "--max-outliers 3 --hard-limit 101%").exit_code, same);
  const Result limited = compare(pair + "--max-outliers 3 --hard-limit 0.099");
  EXPECT_EQ(limited.exit_code, different);
  EXPECT_TRUE(contains(limited.output, "3 beyond the hard limit")) << limited.output;
}

TEST_F(CompareCommand, RegionsHaveTheMasksNames) {
  Image mask{32, 24, {"R", "G", "B"}, {}, {.regions = {{"#FF0000", "red wall"}}}};
  for (int i = 0; i < 32 * 24; ++i) {
    const float red = i % 32 < 10, blue = i % 32 > 20;
    mask.values.insert(mask.values.end(), {red, 0.0F, blue});
  }
  write_image(mask, folder / "mask.png");
  Image test = clean;
  for (size_t i = 0; i < test.values.size(); ++i) test.values[i] *= i / 3 % 32 < 10 ? 1.1F : 1.0F;
  write_image(test, folder / "test.exr");
  EXPECT_EQ(compare("test.exr clean.exr --regions mask.png --json result.json").exit_code,
            different);
  const auto json = nlohmann::json::parse(text_of(folder / "result.json"));
  EXPECT_EQ(json["verdict"], "different");
  ASSERT_EQ(json["regions"].size(), 8U);
  for (const auto& region : json["regions"]) {
    const bool is_red = region["region"] == "red wall";
    EXPECT_TRUE(is_red || region["region"] == "#0000FF") << region;
    EXPECT_NEAR(region["relativeDifference"].get<double>(), is_red ? 0.1 : 0.0, 1e-6);
  }
}

// Maps

TEST_F(CompareCommand, MapShowsLessInBlueAndMoreInRedWithItsScale) {
  Image test = clean;
  for (size_t i = 0; i < test.values.size(); ++i) {
    test.values[i] += i / 3 % 32 < 8 ? -0.05F : i / 3 % 32 > 23 ? 0.05F : 0.0F;
  }
  write_image(test, folder / "test.exr");
  EXPECT_EQ(compare("test.exr clean.exr -o map.png").exit_code, different);
  const Image map = read_image(folder / "map.png", "", Integers::codes);
  EXPECT_EQ(map.provenance.scale, "0.05");
  const auto code = [&](int x, size_t c) { return map.values[map.pixel(x, 10) * 3 + c]; };
  EXPECT_GT(code(2, 2), 2 * code(2, 0));
  EXPECT_EQ(code(15, 0), 1.0F);
  EXPECT_EQ(code(15, 2), 1.0F);
  EXPECT_GT(code(30, 0), 2 * code(30, 2));
}

TEST_F(CompareCommand, OtherSizesAreTroubleButDrawn) {
  const Image small{20, 12, clean.channels, std::vector<float>(20 * 12 * 3, 0.5F), {}};
  write_image(small, folder / "small.exr");
  EXPECT_EQ(compare("small.exr clean.exr -o map.png").exit_code, trouble);
  const Image map = read_image(folder / "map.png", "", Integers::codes);
  const size_t beyond = map.pixel(28, 20) * 3;            // where the test is black
  EXPECT_GT(map.values[beyond + 2], map.values[beyond]);  // blue, not white
}

TEST_F(CompareCommand, FlipGatesByMeanAndPercentileWhereAsked) {
  Image test = clean;
  for (size_t i = 0; i < test.values.size() / 10; ++i) test.values[i] += 0.2F;  // a tenth
  write_image(test, folder / "test.exr");
  const std::string pair = "test.exr clean.exr --tolerance 50% --max-outliers 100% ";
  EXPECT_EQ(compare(pair + "--flip ldr --json result.json").exit_code, same);
  const auto flip = nlohmann::json::parse(text_of(folder / "result.json"))["flip"];
  const double mean = flip["mean"], p95 = flip["p95"];
  EXPECT_GT(p95, 2.0 * mean);
  for (const auto& [option, value] : {std::pair("mean", mean), {"p95", p95}}) {
    const auto limit = [&](double factor) {
      return pair + "--flip ldr --flip-" + option + " " + std::to_string(factor * value);
    };
    EXPECT_EQ(compare(limit(1.01)).exit_code, same);
    const Result result = compare(limit(0.99));
    EXPECT_EQ(result.exit_code, different);
    EXPECT_TRUE(contains(result.output, "different: looks different: FLIP")) << result.output;
  }
  EXPECT_EQ(compare(pair + "--flip-mean 0.1").exit_code, trouble);
  compare(pair + "--flip ldr --pixels-per-degree 20 --json result.json");
  EXPECT_NE(nlohmann::json::parse(text_of(folder / "result.json"))["flip"]["mean"], mean);
}

TEST_F(CompareCommand, FlipIsToldAndDrawnButJudgesNothing) {
  Image test = clean;
  test.values[(12 * 32 + 20) * 3] += 5.0F;
  write_image(test, folder / "test.exr");
  const std::string options = "test.exr clean.exr --max-outliers 1 --tolerance 10% --map flip ";
  const Result result =
      compare(options + "--flip ldr -o map.png --json result.json --markdown r.md");
  EXPECT_EQ(result.exit_code, same) << result.output;
  EXPECT_NE(result.output.find("(LDR, 67 pixels per degree, "), std::string::npos) << result.output;
  EXPECT_NE(result.output.find("1 firefly, without"), std::string::npos) << result.output;
  EXPECT_NE(text_of(folder / "r.md").find("![map](map.png)"), std::string::npos);
  const auto json = nlohmann::json::parse(text_of(folder / "result.json"));
  EXPECT_GT(json["flip"]["mean"], 0.001);
  const Image map = read_image(folder / "map.png", "", Integers::codes);
  const auto green = [&](int x, int y) { return map.values[map.pixel(x, y) * 3 + 1]; };
  EXPECT_LT(green(20, 12), 0.9F);
  EXPECT_GT(green(0, 0), 0.99F);
  EXPECT_EQ(compare(options + "-o map.png").exit_code, trouble);
}

// Gates

TEST_F(CompareCommand, GateRunsAllPairsAndExpectsSomeToFail) {
  Image bright = clean;
  for (float& value : bright.values) value *= 1.02F;
  write_image(bright, folder / "bright.exr");
  const std::string good = R"(
    [[compare]]
    name = "equal"
    test = "clean.exr"
    reference = "clean.exr"
    tolerance = "0.5%"
    channels = ["R", "G"]
    max-outliers = 3
    [[compare]]
    test = "bright.exr"
    reference = "clean.exr"
    expect = "different"
  )";
  write_text(folder / "gate.toml", good);
  Result result = compare("--gate gate.toml");
  EXPECT_EQ(result.exit_code, same) << result.output;
  EXPECT_NE(result.output.find("ok   equal: same"), std::string::npos) << result.output;
  EXPECT_NE(result.output.find("ok   bright.exr: different"), std::string::npos) << result.output;

  write_text(folder / "gate.toml",
             good + "[[compare]]\ntest = 'bright.exr'\nreference = 'clean.exr'\n");
  EXPECT_EQ(compare("--gate gate.toml").exit_code, different);
  write_text(
      folder / "gate.toml",
      good + "[[compare]]\ntest = 'clean.exr'\nreference = 'clean.exr'\nexpect = 'different'\n");
  EXPECT_EQ(compare("--gate gate.toml").exit_code, different);
  write_text(folder / "gate.toml",
             good + "[[compare]]\ntest = 'missing.exr'\nreference = 'clean.exr'\n");
  result = compare("--gate gate.toml --junit junit.xml");
  EXPECT_EQ(result.exit_code, trouble);
  EXPECT_NE(result.output.find("FAIL missing.exr: trouble: missing.exr: cannot open"),
            std::string::npos)
      << result.output;
  EXPECT_NE(text_of(folder / "junit.xml").find("<error message=\"trouble, not same\">"),
            std::string::npos);
}

TEST_F(CompareCommand, BrokenGatesAreTrouble) {
  const std::pair<std::string, std::string> cases[] = {
      {"[[compare]", "gate.toml:1"},
      {"", "no [[compare]]"},
      {"[[compare]]\ntest = 'clean.exr'\n", "TEST and REFERENCE are required"},
      {"[[compare]]\ntest = 'clean.exr'\nreference = 'clean.exr'\ncolour = 1\n", "--colour"},
      {"[[compare]]\ntest = 'clean.exr'\nreference = 'clean.exr'\ntolerance = 'x'\n", "'x'"},
      {"\n[[compare]]\nexpect = 'equal'\n", "gate.toml:3: 'expect' is not one of"}};
  for (const auto& [text, reason] : cases) {
    write_text(folder / "gate.toml", text);
    const Result result = compare("--gate gate.toml");
    EXPECT_EQ(result.exit_code, trouble) << text;
    EXPECT_NE(result.output.find(reason), std::string::npos) << result.output;
  }
}

TEST_F(CompareCommand, FoldersArePairedByName) {
  Image bright = clean;
  for (float& value : bright.values) value *= 1.02F;
  fs::create_directories(folder / "out/deep");
  fs::create_directories(folder / "references/deep");
  write_image(clean, folder / "out/a.exr");
  write_image(bright, folder / "out/deep/b.exr");
  write_image(clean, folder / "references/a.exr");
  write_image(clean, folder / "references/deep/b.exr");
  write_image(clean, folder / "references/c.exr");
  const Result result = compare("out references --tolerance 1% --junit junit.xml");
  EXPECT_EQ(result.exit_code, trouble);
  EXPECT_TRUE(contains(result.output, "ok   a.exr: same")) << result.output;
  EXPECT_TRUE(contains(result.output, "FAIL deep/b.exr: different")) << result.output;
  EXPECT_TRUE(contains(result.output, "FAIL c.exr: trouble: out/c.exr: cannot open"))
      << result.output;
  EXPECT_TRUE(contains(text_of(folder / "junit.xml"), "tests=\"3\""));
  fs::remove(folder / "references/c.exr");
  EXPECT_EQ(compare("out references --tolerance 5%").exit_code, same);
  fs::create_directory(folder / "empty");
  EXPECT_EQ(compare("empty empty").exit_code, trouble);
}

TEST_F(CompareCommand, ReferencesAreUpdatedOnlyWhenAsked) {
  Image bright = clean;
  for (float& value : bright.values) value *= 1.02F;
  write_image(bright, folder / "bright.exr");
  const std::string before = text_of(folder / "clean.exr");
  EXPECT_EQ(compare("bright.exr clean.exr").exit_code, different);
  EXPECT_EQ(text_of(folder / "clean.exr"), before);
  const Result result = compare("bright.exr clean.exr --update");
  EXPECT_EQ(result.exit_code, different);
  EXPECT_NE(result.output.find("clean.exr is now bright.exr"), std::string::npos) << result.output;
  EXPECT_EQ(compare("bright.exr clean.exr --tolerance 0").exit_code, same);
}

TEST_F(CompareCommand, UpdatesHaveTheReferencesFormat) {
  write_image(clean, folder / "clean.png");
  Image large{40, 30, clean.channels, std::vector<float>(40 * 30 * 3, 0.5F), {}};
  write_image(large, folder / "large.exr");
  write_text(folder / "gate.toml", R"(
    [[compare]]
    test = "clean.png"
    reference = "new.exr"
    [[compare]]
    test = "clean.exr"
    reference = "large.exr"
  )");
  const Result result = compare("--gate gate.toml --update");
  EXPECT_EQ(result.exit_code, trouble);
  EXPECT_TRUE(contains(result.output, "new.exr is now clean.png")) << result.output;
  EXPECT_TRUE(contains(result.output, "large.exr is now clean.exr")) << result.output;
  EXPECT_TRUE(text_of(folder / "new.exr").starts_with("v/1\x01"));
  EXPECT_EQ(compare("clean.png new.exr --tolerance 0").exit_code, same);
  EXPECT_EQ(compare("clean.exr large.exr --tolerance 0").exit_code, same);
}

TEST_F(CompareCommand, UpdatesHoldWhatWasComparedAndLoseNothingElse) {
  Image bright = clean;
  for (float& value : bright.values) value *= 3.0F;
  write_image(bright, folder / "bright.exr");
  compare("clean.exr mean.exr --replicates bright.exr --update");
  Image mean = clean;
  for (float& value : mean.values) value *= 2.0F;
  write_image(mean, folder / "expected.exr");
  EXPECT_EQ(
      compare("mean.exr expected.exr --tolerance 0.0001% --floor 0 --channels R,G,B").exit_code,
      inconclusive);  // it has the variance of two replicates
  EXPECT_EQ(read_image(folder / "mean.exr").channels.size(), 6U);

  write_image(with(clean, {{"A", 1.0F}}), folder / "alpha.exr");
  const std::string before = text_of(folder / "alpha.exr");
  const Result result = compare("bright.exr alpha.exr --channels R,G,B --update");
  EXPECT_EQ(result.exit_code, trouble);
  EXPECT_TRUE(contains(result.output, "would lose its A")) << result.output;
  EXPECT_EQ(text_of(folder / "alpha.exr"), before);
}

TEST_F(CompareCommand, UnfitTestsDontBecomeReferences) {
  Image bad = clean;
  bad.values[0] = std::numeric_limits<float>::quiet_NaN();
  write_image(bad, folder / "bad.exr");
  EXPECT_EQ(compare("bad.exr clean.exr --update").exit_code, trouble);
  EXPECT_EQ(compare("bad.exr new.exr --update").exit_code, trouble);
  EXPECT_EQ(compare("missing.exr clean.exr --update").exit_code, trouble);
  Image bright = clean;
  bright.values[9] += 0.5F;
  write_image(bright, folder / "bright.exr");
  EXPECT_EQ(compare("bright.exr clean.exr --crop 9,9,99,99 --update").exit_code, trouble);
  EXPECT_FALSE(fs::exists(folder / "new.exr"));
  EXPECT_EQ(compare("clean.exr clean.exr --tolerance 0").exit_code, same);
}

}  // namespace
}  // namespace plumb
