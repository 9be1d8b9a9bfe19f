// SPDX-License-Identifier: Apache-2.0

// What may be relied on about pictures as others store them: windows, orientation, colours, parts.
#include <ImfChannelList.h>
#include <ImfOutputFile.h>
#include <ImfRgbaFile.h>
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>

#include "images/image.h"

namespace plumb {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;
using Values = std::vector<float>;

// Each test has an empty folder of its own.
class StoredImageTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder = fs::path(testing::TempDir()) /
             ("plumb-stored-" + std::to_string(getpid()) + "-" + std::string(test->name()));
    fs::create_directories(folder);
  }
  void TearDown() override { fs::remove_all(folder); }

  // Has OpenImageIO write the values as spec says.
  fs::path store(const std::string& name, const OIIO::ImageSpec& spec, const Values& values) {
    const auto output = OIIO::ImageOutput::create((folder / name).string());
    EXPECT_NE(output, nullptr) << OIIO::geterror();
    EXPECT_TRUE(output->open((folder / name).string(), spec)) << output->geterror();
    EXPECT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, values.data())) << output->geterror();
    EXPECT_TRUE(output->close());
    return folder / name;
  }

  fs::path folder;
};

// A spec whose pixels lie at x, y of a display window.
OIIO::ImageSpec in_display(int x, int y, int width, int height, int full_width, int full_height,
                           int channels = 1) {
  OIIO::ImageSpec spec(width, height, channels, OIIO::TypeDesc::FLOAT);
  spec.x = x;
  spec.y = y;
  spec.full_width = full_width;
  spec.full_height = full_height;
  return spec;
}

bool has_note(const Image& image, const std::string& words) {
  return std::ranges::any_of(
      image.notes, [&](const std::string& note) { return note.find(words) != std::string::npos; });
}

void expect_near(const Values& found, const Values& wanted, float tolerance) {
  ASSERT_EQ(found.size(), wanted.size());
  for (size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], wanted[i], tolerance) << i;
}

// Windows and orientation

TEST_F(StoredImageTest, PixelsLieWhereTheFileSaysAndTheRestIsBlack) {
  const Image image = read_image(store("crop.exr", in_display(1, 1, 2, 1, 4, 3), {5, 6}));
  EXPECT_EQ(image.width, 4);
  EXPECT_EQ(image.height, 3);
  EXPECT_EQ(image.values, (Values{0, 0, 0, 0, 0, 5, 6, 0, 0, 0, 0, 0}));
  EXPECT_TRUE(has_note(image, "2 x 1 pixels at 1,1 of 4 x 3"));
}

TEST_F(StoredImageTest, ATrimmedPictureIsTheSameAsItsFullFrame) {
  const Values full = {0, 0, 0, 0, 0, 7, 8, 0, 0, 0, 0, 0};
  const Image whole = read_image(store("full.exr", in_display(0, 0, 4, 3, 4, 3), full));
  const Image trimmed = read_image(store("trimmed.exr", in_display(1, 1, 2, 1, 4, 3), {7, 8}));
  EXPECT_EQ(trimmed.values, whole.values);
  EXPECT_TRUE(whole.notes.empty());
}

TEST_F(StoredImageTest, WhatLiesOutsideTheDisplayWindowIsKept) {
  const Image image = read_image(store("over.exr", in_display(-1, 0, 3, 1, 2, 2), {1, 2, 3}));
  EXPECT_EQ(image.width, 3);
  EXPECT_EQ(image.height, 2);
  EXPECT_EQ(image.left, -1);
  EXPECT_EQ(image.top, 0);
  EXPECT_EQ(image.values, (Values{1, 2, 3, 0, 0, 0}));
  EXPECT_EQ(image.display.x, 1);
  EXPECT_EQ(image.display.width, 2);
  EXPECT_TRUE(has_note(image, "beyond its display window"));
}

TEST_F(StoredImageTest, ThePlaceOfTheDisplayWindowStaysWhenItIsTurned) {
  for (const auto& [orientation, x, width] : {std::array{1, 1, 2}, {2, 0, 2}, {6, 0, 2}}) {
    OIIO::ImageSpec spec = in_display(-1, 0, 3, 2, 2, 2);
    spec.attribute("Orientation", orientation);
    const Image image = read_image(store("turned.exr", spec, {1, 2, 3, 4, 5, 6}));
    EXPECT_EQ(image.display.x, x) << orientation;
    EXPECT_EQ(image.display.width, width) << orientation;
    EXPECT_EQ(image.left + image.display.x, 0) << orientation;
    EXPECT_EQ(image.top + image.display.y, 0) << orientation;
  }
}

TEST_F(StoredImageTest, AFrameThatDoesNotBeginAtZeroIsToldAndWrittenAgain) {
  OIIO::ImageSpec spec = in_display(20, 10, 2, 1, 2, 1);
  spec.full_x = 20;
  spec.full_y = 10;
  const Image image = read_image(store("moved.exr", spec, {1, 2}));
  EXPECT_EQ(image.left, 20);
  EXPECT_EQ(image.top, 10);
  write_image(image, folder / "again.exr");
  EXPECT_EQ(read_image(folder / "again.exr").left, 20);
}

TEST_F(StoredImageTest, EveryOrientationIsTurnedUpright) {
  // Where TIFF 6.0 puts the stored rows 0 1 2 and 3 4 5; from 5 on, rows become columns.
  const std::array<Values, 8> upright = {{{0, 1, 2, 3, 4, 5},
                                          {2, 1, 0, 5, 4, 3},
                                          {5, 4, 3, 2, 1, 0},
                                          {3, 4, 5, 0, 1, 2},
                                          {0, 3, 1, 4, 2, 5},
                                          {3, 0, 4, 1, 5, 2},
                                          {5, 2, 4, 1, 3, 0},
                                          {2, 5, 1, 4, 0, 3}}};
  for (const char* name : {"turned.tif", "turned.exr"}) {
    for (int orientation = 1; orientation <= 8; ++orientation) {
      OIIO::ImageSpec spec(3, 2, 1, OIIO::TypeDesc::FLOAT);
      spec.attribute("Orientation", orientation);
      const Image image = read_image(store(name, spec, {0, 1, 2, 3, 4, 5}));
      EXPECT_EQ(image.width, orientation < 5 ? 3 : 2);
      EXPECT_EQ(image.values, upright[size_t(orientation - 1)]) << orientation;
      EXPECT_EQ(has_note(image, "upright"), orientation != 1);
    }
  }
}

TEST_F(StoredImageTest, RadianceFilesMayBeStoredUpwards) {
  // Of each pixel three mantissas and the exponent of their scale, 2^(129 - 136).
  std::ofstream(folder / "up.hdr", std::ios::binary)
      << "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n+Y 2 +X 1\n"
      << "\x40\x40\x40\x81\x80\x80\x80\x81";
  const Image image = read_image(folder / "up.hdr");
  ASSERT_EQ(image.values.size(), 6U);
  EXPECT_GT(image.values[0], image.values[3]);
}

// Colours

TEST_F(StoredImageTest, GammasAreUndoneAsStatedAndTwoPointTwoIsTakenAsSrgb) {
  const double srgb = std::pow((0.5 + 0.055) / 1.055, 2.4);
  const std::pair<const char*, double> cases[] = {
      {"linear", 0.5}, {"Gamma1.8", std::pow(0.5, 1.8)}, {"Gamma2.2", srgb}, {"sRGB", srgb}};
  for (const auto& [space, value] : cases) {
    OIIO::ImageSpec spec(1, 1, 1, OIIO::TypeDesc::UINT16);
    spec.attribute("oiio:ColorSpace", space);
    const Image image = read_image(store("picture.png", spec, {0.5F}));
    EXPECT_NEAR(image.values[0], value, 2e-5) << space;
    EXPECT_EQ(has_note(image, "gamma"), std::string(space) == "Gamma2.2");
  }
}

TEST_F(StoredImageTest, ATransferFunctionThatIsNotKnownIsNoted) {
  OIIO::ImageSpec spec(4, 4, 3, OIIO::TypeDesc::UINT16);
  spec.attribute("oiio:ColorSpace", "KodakLog");
  EXPECT_TRUE(has_note(read_image(store("log.dpx", spec, Values(48, 0.5F))), "KodakLog"));
}

TEST_F(StoredImageTest, StraightAndPremultipliedAlphaAreTheSamePicture) {
  OIIO::ImageSpec spec(1, 1, 4, OIIO::TypeDesc::FLOAT);
  const Image exr = read_image(store("pre.exr", spec, {0.1F, 0.05F, 0.02F, 0.5F}));
  spec = OIIO::ImageSpec(1, 1, 4, OIIO::TypeDesc::UINT16);
  spec.attribute("oiio:ColorSpace", "sRGB");
  spec.attribute("oiio:UnassociatedAlpha", 1);
  const auto code = [](double linear) {
    return float(1.055 * std::pow(linear, 1.0 / 2.4) - 0.055);
  };
  const Values straight = {code(0.2), code(0.1), code(0.04), 0.5F};
  for (const char* name : {"straight.png", "straight.tif"}) {
    const Image image = read_image(store(name, spec, straight));
    // A step of a code is 1.5e-5, and the curve no steeper than 2.4.
    expect_near(image.values, exr.values, 4e-5F);
    EXPECT_TRUE(has_note(image, "straight"));
  }
  EXPECT_NEAR(read_image(folder / "straight.png", "", Integers::codes).values[0], code(0.2), 2e-5);
  EXPECT_TRUE(exr.notes.empty());
}

TEST_F(StoredImageTest, CodesThatAreMultipliedByAlphaAreMadeLinearWithoutIt) {
  OIIO::ImageSpec spec(1, 1, 4, OIIO::TypeDesc::UINT16);
  const float code = 0.6F, alpha = 0.25F;
  const Values values = {code * alpha, code * alpha, code * alpha, alpha};
  const Image image = read_image(store("pre.tif", spec, values));
  const double linear = std::pow((0.6 + 0.055) / 1.055, 2.4) * 0.25;
  EXPECT_NEAR(image.values[0], linear, 1e-4);
}

constexpr std::array<float, 8> ap0 = {0.7347F, 0.2653F, 0, 1, 0.0001F, -0.077F, 0.32168F, 0.33767F};

OIIO::ImageSpec of_primaries(const std::array<float, 8>& primaries, const Names& channels) {
  OIIO::ImageSpec spec(1, 1, int(channels.size()), OIIO::TypeDesc::FLOAT);
  spec.channelnames = channels;
  spec.attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), primaries.data());
  return spec;
}

TEST_F(StoredImageTest, PrimariesBecomeThoseOfRec709) {
  // The matrix from ACES AP0 as the Academy's transforms have it, with Bradford's adaptation.
  const Names channels = {"R", "G", "B", "diffuse.R", "diffuse.G", "diffuse.B"};
  const Image image = read_image(store("ap0.exr", of_primaries(ap0, channels), {1, 1, 1, 1, 0, 0}));
  EXPECT_EQ(image.channels, channels);
  expect_near(image.values, {1, 1, 1, 2.52169F, -0.27648F, -0.01538F}, 2e-4F);
  EXPECT_TRUE(has_note(image, "Its primaries are not those of Rec. 709"));
  EXPECT_TRUE(image.is_converted);
}

// The white of Rec. 709 by x = 0.3127, y = 0.329, as X = x / y, Y = 1, Z = (1 - x - y) / y.
TEST_F(StoredImageTest, TristimulusValuesKeepTheirColour) {
  const std::array<float, 8> axes = {1, 0, 0, 1, 0, 0, 1.0F / 3, 1.0F / 3};
  const Image image =
      read_image(store("xyz.exr", of_primaries(axes, {"R", "G", "B"}), {0.950456F, 1, 1.089058F}));
  expect_near(image.values, {1, 1, 1}, 1e-4F);
  EXPECT_TRUE(has_note(image, "as X, Y and Z"));
}

TEST_F(StoredImageTest, VariancesAreConvertedWithTheSquaresOfTheMatrix) {
  const Names channels = {"R", "G", "B", "variance.R", "variance.G", "variance.B"};
  const Image image = read_image(store("ap0.exr", of_primaries(ap0, channels), {0, 0, 0, 1, 0, 0}));
  expect_near(image.values, {0, 0, 0, 6.35892F, 0.07644F, 0.00024F}, 1e-3F);
}

TEST_F(StoredImageTest, RoundedPrimariesOfRec709AreThoseOfRec709) {
  const std::array<float, 8> rounded = {0.64F, 0.33F, 0.3F, 0.6F, 0.15F, 0.06F, 0.3127F, 0.32902F};
  const Image image =
      read_image(store("same.exr", of_primaries(rounded, {"R", "G", "B"}), {1, 0.5F, 0}));
  EXPECT_EQ(image.values, (Values{1, 0.5F, 0}));
  EXPECT_FALSE(image.is_converted);
  EXPECT_TRUE(image.notes.empty());
}

// The matrix from Rec. 2020 as Rec. ITU-R BT.2087 has it.
TEST_F(StoredImageTest, PrimariesOfAPngBecomeThoseOfRec709) {
  OIIO::ImageSpec spec(1, 1, 3, OIIO::TypeDesc::UINT16);
  spec.attribute("oiio:ColorSpace", "linear");
  const fs::path file = store("rec2020.png", spec, {1, 0, 0});
  std::ifstream stream(file, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  const char chunk[] =
      "\0\0\0\x20"
      "cHRM"
      "\x00\x00\x7a\x26\x00\x00\x80\x84"
      "\x00\x01\x14\x90\x00\x00\x72\x10"
      "\x00\x00\x42\x68\x00\x01\x37\x54"
      "\x00\x00\x33\x2c\x00\x00\x11\xf8"
      "\x10\xb0\xf8\xa4";
  bytes.insert(33, chunk, sizeof(chunk) - 1);  // after the signature and IHDR
  std::ofstream(file, std::ios::binary) << bytes;
  const Image image = read_image(file);
  expect_near(image.values, {1.6605F, -0.1246F, -0.0182F}, 1e-3F);
  EXPECT_TRUE(has_note(image, "red 0.708,0.292"));
  EXPECT_FALSE(read_image(file, "", Integers::codes).is_converted);
}

std::string number(uint32_t value, int bytes, bool is_little_endian) {
  std::string text;
  for (int i = 0; i < bytes; ++i) {
    text += static_cast<char>(value >> 8 * (is_little_endian ? i : bytes - 1 - i));
  }
  return text;
}

// A part of a TIFF, at this place in the file: one red pixel, all of whose fields are of 32 bits.
std::string tiff_part(uint32_t place, uint32_t next, const std::vector<uint32_t>& primaries,
                      bool is_little_endian) {
  constexpr uint32_t integer = 4, fraction = 5, fields = 11;
  const uint32_t bits = place + 2 + 12 * fields + 4, pixel = bits + 12, colours = pixel + 4;
  const auto bytes = [&](uint32_t value, int count) {
    return number(value, count, is_little_endian);
  };
  std::string text = bytes(fields, 2);
  for (const auto& [tag, type, count, value] :
       std::vector<std::array<uint32_t, 4>>{{256, integer, 1, 1},
                                            {257, integer, 1, 1},
                                            {258, integer, 3, bits},
                                            {259, integer, 1, 1},
                                            {262, integer, 1, 2},
                                            {273, integer, 1, pixel},
                                            {277, integer, 1, 3},
                                            {278, integer, 1, 1},
                                            {279, integer, 1, 3},
                                            {318, fraction, 2, colours + 48},
                                            {319, fraction, 6, colours}}) {
    text += bytes(tag, 2) + bytes(type, 2) + bytes(count, 4) + bytes(value, 4);
  }
  text += bytes(next, 4);
  for (int c = 0; c < 3; ++c) text += bytes(8, 4);
  text += std::string("\xff\0\0\0", 4);
  for (const uint32_t x : primaries) text += bytes(x, 4) + bytes(10000, 4);
  return text;
}

// The matrix from Rec. 2020 as Rec. ITU-R BT.2087 has it.
TEST_F(StoredImageTest, PrimariesOfATiffBecomeThoseOfRec709) {
  const std::vector<uint32_t> rec709{6400, 3300, 3000, 6000, 1500, 600, 3127, 3290};
  const std::vector<uint32_t> rec2020{7080, 2920, 1700, 7970, 1310, 460, 3127, 3290};
  for (const bool is_little_endian : {true, false}) {
    const std::string first = tiff_part(8, 226, rec709, is_little_endian);
    ASSERT_EQ(first.size(), 218U);
    std::ofstream(folder / "wide.tif", std::ios::binary)
        << (is_little_endian ? "II" : "MM") << number(42, 2, is_little_endian)
        << number(8, 4, is_little_endian) << first << tiff_part(226, 0, rec2020, is_little_endian);
    expect_near(read_image(folder / "wide.tif", "0").values, {1, 0, 0}, 0);
    const Image image = read_image(folder / "wide.tif", "1");
    expect_near(image.values, {1.6605F, -0.1246F, -0.0182F}, 1e-3F);
    EXPECT_TRUE(has_note(image, "red 0.708,0.292"));
  }
}

TEST_F(StoredImageTest, AnIccProfileIsNotAppliedAndThatIsSaid) {
  OIIO::ImageSpec spec(1, 1, 3, OIIO::TypeDesc::UINT8);
  const std::string profile(200, 'P');
  spec.attribute("ICCProfile", OIIO::TypeDesc(OIIO::TypeDesc::UINT8, 200), profile.data());
  EXPECT_TRUE(has_note(read_image(store("p3.tif", spec, {1, 1, 1})), "Its ICC profile was not"));
}

TEST_F(StoredImageTest, LuminanceAndSubsampledChromaBecomeColours) {
  const std::string file = (folder / "chroma.exr").string();
  {
    const std::vector<Imf::Rgba> pixels(64, Imf::Rgba(0.5F, 0.25F, 0.125F));
    Imf::RgbaOutputFile output(file.c_str(), 8, 8, Imf::WRITE_YC);
    output.setFrameBuffer(pixels.data(), 1, 8);
    output.writePixels(8);
  }
  const Image image = read_image(file);
  EXPECT_EQ(image.channels, (Names{"R", "G", "B"}));
  ASSERT_EQ(image.values.size(), 192U);
  // Half precision has 11 bits, and Y, RY and BY are rounded to fewer on the way.
  for (size_t i = 0; i < 192; ++i) EXPECT_NEAR(image.values[i], 0.5 / double(1 << i % 3), 0.01);
  EXPECT_TRUE(has_note(image, "chroma"));
}

TEST_F(StoredImageTest, OtherSubsampledChannelsAreRefused) {
  const std::string file = (folder / "half_depth.exr").string();
  {
    const Values depth(4, 1.0F);
    Imf::Header header(4, 4);
    header.channels().insert("Z", Imf::Channel(Imf::FLOAT, 2, 2));
    Imf::FrameBuffer buffer;
    buffer.insert(
        "Z", Imf::Slice(Imf::FLOAT, const_cast<char*>(reinterpret_cast<const char*>(depth.data())),
                        4, 8, 2, 2));
    Imf::OutputFile output(file.c_str(), header);
    output.setFrameBuffer(buffer);
    output.writePixels(4);
  }
  EXPECT_THROW(read_image(file), ImageError);
}

// Parts and sizes

TEST_F(StoredImageTest, PartsThatWereNotReadAreNamed) {
  const std::string file = (folder / "parts.exr").string();
  const auto output = OIIO::ImageOutput::create(file);
  std::vector<OIIO::ImageSpec> specs(3, OIIO::ImageSpec(1, 1, 1, OIIO::TypeDesc::FLOAT));
  const Names names = {"left", "right", "depth"};
  for (size_t i = 0; i < 3; ++i) specs[i].attribute("oiio:subimagename", names[i]);
  ASSERT_TRUE(output->open(file, 3, specs.data()));
  for (int i = 0; i < 3; ++i) {
    if (i > 0) {
      ASSERT_TRUE(output->open(file, specs[size_t(i)], OIIO::ImageOutput::AppendSubimage));
    }
    const auto value = float(i);
    ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, &value));
  }
  ASSERT_TRUE(output->close());
  const Image first = read_image(file);
  EXPECT_EQ(first.part, "left");
  EXPECT_EQ(first.other_parts, (Names{"right", "depth"}));
  for (const char* part : {"right", "1"}) {
    const Image second = read_image(file, part);
    EXPECT_EQ(second.values, Values{1});
    EXPECT_EQ(second.other_parts, (Names{"left", "depth"}));
  }
}

TEST_F(StoredImageTest, LargePicturesOfOneColourAreGood) {
  OIIO::ImageSpec spec(6000, 6000, 1, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:BitsPerSample", 1);
  spec.attribute("compression", "zip");
  const fs::path file = store("black.tif", spec, Values(36'000'000));
  EXPECT_LT(fs::file_size(file), 36'000'000U / 1000);
  EXPECT_EQ(read_image(file).width, 6000);
}

TEST_F(StoredImageTest, WhatNeedsMoreThanHalfOfTheMemoryIsRefused) {
  const fs::path file =
      store("huge.exr", in_display(0, 0, 1, 1, 10'000'000, 10'000'000), Values{1});
  try {
    read_image(file);
    FAIL();
  } catch (const ImageError& error) {
    EXPECT_NE(std::string(error.what()).find("half of the memory"), std::string::npos);
  }
}

TEST_F(StoredImageTest, WhatNeedsMoreThanTheProcessMayHaveIsRefused) {
  const fs::path file = store("large.exr", in_display(0, 0, 1, 1, 2000, 2000), Values{1});
  EXPECT_EQ(read_image(file).width, 2000);
  rlimit usual{};
  getrlimit(RLIMIT_RSS, &usual);
  const rlimit small{1 << 24, usual.rlim_max};
  setrlimit(RLIMIT_RSS, &small);
  EXPECT_THROW(read_image(file), ImageError);
  setrlimit(RLIMIT_RSS, &usual);
}

// A header's numbers are not believed before the file's size is looked at.
TEST_F(StoredImageTest, NoFewBytesAskForGigabytes) {
  // What is said of an EXR of 8 x 8 pixels after 2^27 is written somewhere behind an attribute's
  // name.
  const auto error_with = [&](const std::string& compression, const std::string& attribute,
                              size_t offset) -> std::string {
    OIIO::ImageSpec spec = in_display(0, 0, 8, 8, 8, 8);
    spec.attribute("who", "me");
    spec.attribute("compression", compression);
    const fs::path file = store("picture.exr", spec, Values(64));
    std::fstream stream(file, std::ios::binary | std::ios::in | std::ios::out);
    const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    stream.seekp(std::streamoff(bytes.find(attribute + '\0') + attribute.size() + 1 + offset));
    stream.write("\0\0\0\x08", 4);
    stream.close();
    try {
      read_image(file);
    } catch (const ImageError& error) {
      return error.what();
    }
    return "";
  };
  const size_t right = std::string("box2i").size() + 1 + 4 + 8,
               size = std::string("string").size() + 1;
  for (const auto* compression : {"none", "rle", "zip", "piz", "pxr24", "b44", "b44a", "dwaa"}) {
    const std::string error = error_with(compression, "dataWindow", right);
    EXPECT_NE(error.find("134217729 x 8 pixels in"), error.npos) << compression << ": " << error;
  }
  const std::string error = error_with("none", "who", size);
  EXPECT_NE(error.find("an attribute is larger than the file"), error.npos) << error;
}

TEST_F(StoredImageTest, TheSamePictureIsTheSameBytesAndHasNoDate) {
  const Image image{2, 1, {"R", "G", "B"}, {1, 2, 3, 4, 5, 6}, {}};
  const auto bytes = [&] {
    write_image(image, folder / "picture.exr");
    std::ifstream stream(folder / "picture.exr", std::ios::binary);
    return std::string{std::istreambuf_iterator<char>(stream), {}};
  };
  const std::string once = bytes();
  EXPECT_EQ(bytes(), once);
  EXPECT_EQ(once.find("capDate"), std::string::npos);
}

}  // namespace
}  // namespace plumb
