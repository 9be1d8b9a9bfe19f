// SPDX-License-Identifier: Apache-2.0

// What may be relied on about pictures in files.
#include "images/image.h"
#include "images/printable.h"

#include <OpenImageIO/imageio.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <bit>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <fstream>
#include <limits>
#include <set>

namespace plumb {
namespace {

namespace fs = std::filesystem;

// Each test has an empty folder of its own.
class ImageTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder = fs::path(testing::TempDir()) /
             ("plumb-" + std::to_string(getpid()) + "-" + std::string(test->name()));
    fs::create_directories(folder);
  }

  void TearDown() override {
    fs::permissions(folder, fs::perms::owner_all);
    fs::remove_all(folder);
  }

  std::set<std::string> names_in_folder() const {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder)) {
      names.insert(entry.path().filename().string());
    }
    return names;
  }

  fs::path folder;
};

using Names = std::set<std::string>;

// Values from 0 to 1 that don't compress well.
Image noise(int width, int height) {
  Image image{width, height, {"R", "G", "B"}, {}, {}};
  uint32_t state = 1;
  for (int i = 0; i < width * height * 3; ++i) {
    state = state * 1664525U + 1013904223U;
    image.values.push_back(static_cast<float>(state >> 8) / 16777216.0F);
  }
  return image;
}

std::string bytes_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void write_text(const fs::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

std::vector<unsigned char> png_pixels(const fs::path& file) {
  const auto input = OIIO::ImageInput::open(file.string());
  if (input == nullptr) throw std::runtime_error(OIIO::geterror());
  const OIIO::ImageSpec& spec = input->spec();
  EXPECT_EQ(spec.format, OIIO::TypeDesc::UINT8);
  EXPECT_EQ(spec.nchannels, 3);
  std::vector<unsigned char> pixels(spec.image_pixels() * 3);
  EXPECT_TRUE(input->read_image(0, 0, 0, 3, OIIO::TypeDesc::UINT8, pixels.data()));
  return pixels;
}

// The message of the FileError that `call` throws.
template <typename Call>
std::string error_of(Call call) {
  try {
    call();
  } catch (const FileError& error) {
    return error.what();
  }
  return "no FileError";
}

// Expects an error that names the file and gives the reason.
void expect_error(const std::string& message, const fs::path& file, const std::string& reason) {
  EXPECT_NE(message.find(file.string()), std::string::npos) << message;
  EXPECT_NE(message.find(reason), std::string::npos) << message;
}

// Files can't grow beyond some size while this lives, as on a full disk.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) {
    old_action_ = std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &old_limit_);
    rlimit limit = old_limit_;
    limit.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &old_limit_);
    std::signal(SIGXFSZ, old_action_);
  }

 private:
  rlimit old_limit_{};
  void (*old_action_)(int) = SIG_DFL;
};

// EXR

TEST_F(ImageTest, ExrKeepsEveryBitOfEveryChannel) {
  using Limits = std::numeric_limits<float>;
  const std::vector<float> specials = {0.0F,
                                       -0.0F,
                                       -1.5F,
                                       1.0F / 3.0F,
                                       Limits::quiet_NaN(),
                                       -Limits::quiet_NaN(),
                                       Limits::infinity(),
                                       -Limits::infinity(),
                                       Limits::denorm_min(),
                                       -Limits::denorm_min(),
                                       Limits::max(),
                                       Limits::lowest()};
  Image image{7, 5, {"R", "G", "B", "variance.R", "variance.G", "variance.B"}, {}, {}};
  for (size_t i = 0; i < 7 * 5 * 6; ++i) {
    image.values.push_back(i % 3 == 0 ? specials[i / 3 % specials.size()] : float(i) * 0.1F);
  }
  write_image(image, folder / "picture.exr");
  const Image read = read_image(folder / "picture.exr");

  EXPECT_EQ(read.width, 7);
  EXPECT_EQ(read.height, 5);
  EXPECT_EQ(read.channels, image.channels);
  ASSERT_EQ(read.values.size(), image.values.size());
  for (size_t i = 0; i < image.values.size(); ++i) {
    EXPECT_EQ(std::bit_cast<uint32_t>(read.values[i]), std::bit_cast<uint32_t>(image.values[i]))
        << "value " << i;
  }
}

TEST_F(ImageTest, ExrKeepsProvenance) {
  Image image = noise(2, 2);
  image.provenance = {.renderer = "Cornell box: \"red\", größer",
                      .scene_notes = "one line\nand another",
                      .seed = std::numeric_limits<int>::max(),
                      .replicates = -7,
                      .relative_error = std::numeric_limits<double>::infinity(),
                      .wall_seconds = 0.1,
                      .cpu_seconds = std::numeric_limits<double>::denorm_min(),
                      .rays = 3.0,
                      .runs = std::string(2000, 'x'),
                      .regions = {{"#000001", "lamp"}, {"#FFFFFF", "floor"}}};
  write_image(image, folder / "picture.exr");
  EXPECT_EQ(read_image(folder / "picture.exr").provenance, image.provenance);
}

TEST(Printable, IsAllThatIsSeenAndTheRestEscaped) {
  for (const std::string seen : {"", "R", "größer °", "日本", "🎨", R"(C:\x)"}) {
    EXPECT_EQ(printable(seen), seen);
  }
  EXPECT_EQ(printable("\x1b[31mred\x7f\t\r\n"), R"(\x1b[31mred\x7f\x09\x0d\x0a)");
  EXPECT_EQ(printable(std::string("a\0b", 3)), R"(a\x00b)");
  EXPECT_EQ(printable("a\nb\r", LineEnds::kept), "a\nb\\x0d");
  EXPECT_EQ(printable("\xc2\x9b"), R"(\xc2\x9b)");  // what begins a terminal's commands, too
  // No UTF-8: cut, too long, a surrogate, beyond the last character; and what XML can't hold.
  for (const std::string wrong :
       {"\xff", "\x80", "\xc3", "\xe6\x97", "\xc0\x80", "\xe0\x80\x80", "\xed\xa0\x80",
        "\xf4\x90\x80\x80", "\xfc\x80\x80", "\xef\xbf\xbf"}) {
    EXPECT_EQ(printable(wrong).size(), 4 * wrong.size()) << printable(wrong);
  }
}

TEST(Printable, NumbersThatDifferHaveTheDigitsThatTellThemApart) {
  using Texts = std::array<std::string, 2>;
  EXPECT_EQ(told_apart(0.5, 0.12345678), (Texts{"0.5", "0.1235"}));
  EXPECT_EQ(told_apart(0.454321, 0.454327), (Texts{"0.45432", "0.45433"}));
  EXPECT_EQ(told_apart(1.0, std::nextafter(1.0, 2.0)), (Texts{"1", "1.0000000000000002"}));
  EXPECT_EQ(told_apart(0.12345678, 0.12345678), (Texts{"0.1235", "0.1235"}));
}

TEST_F(ImageTest, WhatFilesSayIsPrintable) {
  Image image = noise(2, 2);
  image.channels = {"R", "G", "B\x1b"};
  image.provenance.renderer = "a\n\x1b";
  image.provenance.scene_notes = "one\ntwo\x1b";
  image.provenance.regions = {{"#000001", "lamp\xff"}};
  write_image(image, folder / "picture.exr");
  const Image read = read_image(folder / "picture.exr");
  EXPECT_EQ(read.channels.back(), R"(B\x1b)");
  EXPECT_EQ(read.provenance.renderer, R"(a\x0a\x1b)");
  EXPECT_EQ(read.provenance.scene_notes, "one\ntwo\\x1b");
  EXPECT_EQ(read.provenance.regions[0].second, R"(lamp\xff)");
}

TEST_F(ImageTest, StoredPicturesTellWhatTheyAre) {
  const Provenance ours = read_image(PLUMB_SCENES "/cornell/plumbline.exr").provenance;
  EXPECT_EQ(ours.renderer, "plumbline");
  EXPECT_EQ(ours.samples_per_pixel(), 16384.0);
  EXPECT_EQ(ours.seed, 0);
  EXPECT_EQ(ours.rays, 6063673650.0);
  EXPECT_FALSE(ours.quality);
  const Provenance theirs = read_image(PLUMB_SCENES "/cornell/cycles.exr").provenance;
  EXPECT_EQ(theirs.renderer, "Blender 3.4.1 Cycles");
  EXPECT_EQ(theirs.scene_hash, ours.scene_hash);
  EXPECT_EQ(theirs.quality, "best");
  EXPECT_EQ(theirs.replicates, 8);
  EXPECT_EQ(theirs.process_seconds, 627.101783008);
  EXPECT_FALSE(theirs.method);
}

TEST_F(ImageTest, WhatAnotherProgramSaysUnderOurNamesInOtherTypesIsLeftOut) {
  OIIO::ImageSpec spec(1, 1, 1, OIIO::TypeDesc::FLOAT);
  spec.attribute("plumbline:seed", "seven");
  spec.attribute("plumbline:scene", 7);
  spec.attribute("plumbline:wallSeconds", 7);
  const auto output = OIIO::ImageOutput::create("exr");
  ASSERT_TRUE(output->open((folder / "picture.exr").string(), spec));
  const float value = 1.0F;
  ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, &value));
  ASSERT_TRUE(output->close());
  EXPECT_EQ(read_image(folder / "picture.exr").provenance, Provenance{});
}

TEST(Provenance, OfPartsAddsUpUnlessTheyAreOfDifferentRenders) {
  const Provenance first{.renderer = "a", .seed = 1, .wall_seconds = 1.0, .host = "x, 2 threads"};
  Provenance second = first;
  second.samples = "4:8";
  second.host = "y";
  Provenance whole = first;
  add_part(whole, second);
  add_part(whole, second);
  EXPECT_EQ(whole.wall_seconds, 3.0);
  EXPECT_EQ(whole.host, "x, 2 threads; y");
  EXPECT_FALSE(is_same_render(first, second));
  second.samples = {};
  EXPECT_TRUE(is_same_render(first, second));
  second.seed = 2;
  EXPECT_FALSE(is_same_render(first, second));
  EXPECT_THROW(add_part(whole, second), std::invalid_argument);
  second = first;
  second.fault = "half-pixel";
  EXPECT_THROW(add_part(whole, second), std::invalid_argument);
}

TEST_F(ImageTest, ExrTellsOtherProgramsWhoMadeItAndInWhichColours) {
  Image image = noise(2, 2);
  image.provenance.method = "mis";
  write_image(image, folder / "picture.exr");
  const auto input = OIIO::ImageInput::open((folder / "picture.exr").string());
  ASSERT_NE(input, nullptr);
  const OIIO::ImageSpec& spec = input->spec();
  EXPECT_EQ(spec.format, OIIO::TypeDesc::FLOAT);
  EXPECT_EQ(spec.get_string_attribute("compression"), "zip");
  EXPECT_EQ(spec.get_string_attribute("Software"), "Plumbline " PLUMB_VERSION);
  EXPECT_EQ(spec.get_string_attribute("plumbline:method"), "mis");
  const auto* colours = spec.find_attribute("chromaticities");
  ASSERT_NE(colours, nullptr);
  EXPECT_FLOAT_EQ(colours->get<float>(0), 0.64F);
  EXPECT_FLOAT_EQ(colours->get<float>(7), 0.329F);
}

// PNG

double srgb(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

TEST_F(ImageTest, PngHoldsTheNearestSrgbCodes) {
  Image image{256, 3, {"R", "G", "B"}, {}, {}};
  for (int i = 0; i < 256 * 3 * 3; ++i) {
    image.values.push_back(static_cast<float>(i) / (256.0F * 9.0F));
  }
  write_image(image, folder / "picture.png");
  const auto codes = png_pixels(folder / "picture.png");
  ASSERT_EQ(codes.size(), image.values.size());
  for (size_t i = 0; i < codes.size(); ++i) {
    EXPECT_NEAR(codes[i], 255.0 * srgb(double{image.values[i]}), 0.5001) << image.values[i];
  }
}

TEST_F(ImageTest, PngIsBrightenedByPowersOfTwo) {
  Image image{1, 1, {"R", "G", "B"}, {0.05F, 0.1F, 0.2F}, {}};
  for (const double exposure : {-1.5, 0.0, 2.0}) {
    write_image(image, folder / "picture.png", exposure);
    const auto codes = png_pixels(folder / "picture.png");
    for (size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(codes[c], 255.0 * srgb(double{image.values[c]} * std::exp2(exposure)), 0.5001);
    }
  }
}

TEST_F(ImageTest, PngClampsAndShowsWhatIsNoNumberAsBlack) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  const Image image{
      3, 1, {"R", "G", "B"}, {nan, -nan, -1, -infinity, 0, 1, 1.01F, infinity, 1e30F}, {}};
  write_image(image, folder / "picture.png");
  EXPECT_EQ(png_pixels(folder / "picture.png"),
            (std::vector<unsigned char>{0, 0, 0, 0, 0, 255, 255, 255, 255}));
}

TEST_F(ImageTest, PngShowsTheFirstThreeChannels) {
  const Image image{2, 1, {"R", "G", "B", "variance.R"}, {1, 0, 1, 9, 0, 1, 0, 9}, {}};
  write_image(image, folder / "picture.png");
  EXPECT_EQ(png_pixels(folder / "picture.png"),
            (std::vector<unsigned char>{255, 0, 255, 0, 255, 0}));
}

TEST_F(ImageTest, IntegersAreReadAsCodesOrMadeLinear) {
  const Image image = noise(20, 10);
  write_image(image, folder / "picture.png");
  const Image linear = read_image(folder / "picture.png");
  const Image codes = read_image(folder / "picture.png", "", Integers::codes);
  EXPECT_EQ(linear.encoding, "uint8, srgb, made linear");
  ASSERT_EQ(codes.values.size(), image.values.size());
  for (size_t i = 0; i < image.values.size(); ++i) {
    EXPECT_NEAR(codes.values[i], srgb(double{image.values[i]}), 0.501 / 255.0);
    EXPECT_NEAR(srgb(double{linear.values[i]}), double{codes.values[i]}, 1e-6);
  }
}

// Names

TEST(ImageFormat, FollowsTheExtensionInEitherCase) {
  EXPECT_EQ(image_format("out/a.exr"), ImageFormat::exr);
  EXPECT_EQ(image_format("A.EXR"), ImageFormat::exr);
  EXPECT_EQ(image_format("a.b.png"), ImageFormat::png);
}

TEST(ImageFormat, RefusesOtherExtensions) {
  for (const char* name : {"a.jpg", "a", "exr", ".exr", "a.exr.gz", ""}) {
    EXPECT_THROW(image_format(name), ImageError) << name;
  }
}

// Writing

TEST_F(ImageTest, WritingReplacesTheFileAndLeavesNothingElse) {
  write_text(folder / "picture.exr", "earlier");
  write_image(noise(4, 4), folder / "picture.exr");
  EXPECT_EQ(read_image(folder / "picture.exr").values, noise(4, 4).values);
  EXPECT_EQ(names_in_folder(), Names{"picture.exr"});
}

TEST_F(ImageTest, FullDiskLeavesTheEarlierFileAndNothingElse) {
  for (const char* name : {"picture.exr", "picture.png"}) {
    const fs::path file = folder / name;
    write_text(file, "earlier");
    {
      const FullDisk full(4096);
      expect_error(error_of([&] { write_image(noise(100, 100), file); }), file, "too large");
    }
    EXPECT_EQ(bytes_of(file), "earlier");
  }
  EXPECT_EQ(names_in_folder(), (Names{"picture.exr", "picture.png"}));
}

TEST_F(ImageTest, FolderAsTargetIsRefused) {
  const fs::path file = folder / "folder.exr";
  fs::create_directory(file);
  expect_error(error_of([&] { write_image(noise(2, 2), file); }), file, "Is a directory");
  expect_error(error_of([&] { check_writable(file); }), file, "Is a directory");
  EXPECT_EQ(names_in_folder(), Names{"folder.exr"});
}

TEST_F(ImageTest, MissingFolderIsRefused) {
  const fs::path file = folder / "missing" / "picture.exr";
  expect_error(error_of([&] { write_image(noise(2, 2), file); }), file, "No such file");
  expect_error(error_of([&] { check_writable(file); }), file, "No such file");
}

TEST_F(ImageTest, ProtectedFolderAndProtectedFileAreRefused) {
  if (geteuid() == 0) GTEST_SKIP() << "permissions don't hold the superuser back";
  const fs::path file = folder / "picture.exr";
  write_text(file, "earlier");
  fs::permissions(file, fs::perms::owner_read);
  expect_error(error_of([&] { check_writable(file); }), file, "Permission denied");
  fs::permissions(file, fs::perms::owner_all);
  fs::permissions(folder, fs::perms::owner_read | fs::perms::owner_exec);
  expect_error(error_of([&] { check_writable(file); }), file, "Permission denied");
  expect_error(error_of([&] { write_image(noise(2, 2), file); }), file, "Permission denied");
  EXPECT_EQ(bytes_of(file), "earlier");
}

TEST_F(ImageTest, LinksAreWrittenThrough) {
  fs::create_directory(folder / "elsewhere");
  fs::create_symlink("second.exr", folder / "first.exr");
  fs::create_symlink("elsewhere/picture.exr", folder / "second.exr");
  for (int i = 1; i <= 2; ++i) {  // to a file that isn't there yet, then to one that is
    write_image(noise(i, i), folder / "first.exr");
    EXPECT_TRUE(fs::is_symlink(folder / "first.exr"));
    EXPECT_TRUE(fs::is_symlink(folder / "second.exr"));
    EXPECT_EQ(read_image(folder / "elsewhere" / "picture.exr").width, i);
  }
}

TEST_F(ImageTest, LinkToItselfIsRefused) {
  const fs::path file = folder / "loop.exr";
  fs::create_symlink("loop.exr", file);
  expect_error(error_of([&] { write_image(noise(2, 2), file); }), file, "symbolic links");
}

TEST_F(ImageTest, DevicesAreWrittenToAndStay) {
  if (!fs::is_character_file("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
  const fs::path full = folder / "full.exr";
  const fs::path null = folder / "null.exr";
  fs::create_symlink("/dev/full", full);
  fs::create_symlink("/dev/null", null);
  EXPECT_NO_THROW(check_writable(null));
  EXPECT_NO_THROW(write_image(noise(2, 2), null));
  expect_error(error_of([&] { write_image(noise(2, 2), full); }), full, "No space left");
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(ImageTest, WhatIsOpenIsWrittenInPlaceEvenIfItIsAFile) {
  const fs::path file = folder / "open.txt";
  write_text(file, "what was there");
  const int descriptor = open(file.c_str(), O_RDWR);
  write_file("/dev/fd/" + std::to_string(descriptor), "text");
  std::array<char, 8> bytes{};
  EXPECT_EQ(read(descriptor, bytes.data(), bytes.size()), 4);
  close(descriptor);
  EXPECT_EQ(bytes_of(file), "text");
  EXPECT_EQ(names_in_folder(), Names{"open.txt"});
}

TEST_F(ImageTest, CheckingLeavesNoTrace) {
  write_text(folder / "picture.exr", "earlier");
  check_writable(folder / "picture.exr");
  check_writable(folder / "other.png");
  EXPECT_EQ(bytes_of(folder / "picture.exr"), "earlier");
  EXPECT_EQ(names_in_folder(), Names{"picture.exr"});
}

TEST_F(ImageTest, WrongNumbersOfValuesAreRefused) {
  Image image = noise(2, 2);
  image.values.pop_back();
  EXPECT_THROW(write_image(image, folder / "picture.exr"), ImageError);
  EXPECT_THROW(write_image(Image{}, folder / "picture.exr"), ImageError);
  const Image gray{1, 1, {"Y"}, {1.0F}, {}};
  EXPECT_THROW(write_image(gray, folder / "picture.png"), ImageError);
  EXPECT_TRUE(names_in_folder().empty());
}

// Reading what isn't fit to be read

TEST_F(ImageTest, ReadingAMissingFileIsAnError) {
  const fs::path file = folder / "missing.exr";
  expect_error(error_of([&] { read_image(file); }), file, "No such file");
}

TEST_F(ImageTest, ReadingAFolderIsAnError) {
  const fs::path file = folder / "folder.exr";
  fs::create_directory(file);
  expect_error(error_of([&] { read_image(file); }), file, "Is a directory");
}

TEST_F(ImageTest, ReadingAnEmptyFileIsAnError) {
  const fs::path file = folder / "empty.exr";
  write_text(file, "");
  expect_error(error_of([&] { read_image(file); }), file, "empty");
}

TEST_F(ImageTest, ReadingSomethingElseIsAnError) {
  const fs::path file = folder / "text.exr";
  write_text(file, "This is no picture, whatever its name says.\n");
  expect_error(error_of([&] { read_image(file); }), file, "not an EXR image");
  write_image(noise(4, 4), folder / "picture.png");
  fs::rename(folder / "picture.png", folder / "renamed.exr");
  expect_error(error_of([&] { read_image(folder / "renamed.exr"); }), folder / "renamed.exr",
               "not an EXR image");
}

TEST_F(ImageTest, ReadingACutFileIsAnErrorWhereverItIsCut) {
  const fs::path file = folder / "picture.exr";
  write_image(noise(40, 40), file);
  const std::string whole = bytes_of(file);
  for (size_t size = 1; size < whole.size(); size += 1 + size / 20) {
    write_text(file, whole.substr(0, size));
    expect_error(error_of([&] { read_image(file); }), file, "EXR image");
  }
  write_text(file, whole.substr(0, whole.size() - 1));
  expect_error(error_of([&] { read_image(file); }), file, "damaged EXR image");
}

TEST_F(ImageTest, ReadingADamagedFileDoesNotCrash) {
  const fs::path file = folder / "picture.exr";
  write_image(noise(20, 20), file);
  const std::string whole = bytes_of(file);
  for (size_t i = 0; i < whole.size(); i += 1 + whole.size() / 200) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(~damaged[i]);
    write_text(file, damaged);
    error_of([&] { read_image(file); });
  }
}

}  // namespace
}  // namespace plumb
