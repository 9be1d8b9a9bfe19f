// SPDX-License-Identifier: Apache-2.0

// What may be relied on about the command line: it is run as a user would run it.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "images/image.h"

namespace plumb {
namespace {

namespace fs = std::filesystem;

constexpr const char* scene_start = R"(<scene version="3.0.0">
  <sensor type="perspective">
    <float name="fov" value="60"/>
    <transform name="to_world"><lookat origin="0, 1, 4" target="0, 1, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm">
      <integer name="width" value="8"/>
      <integer name="height" value="6"/>
      <rfilter type="box"/>
    </film>
  </sensor>
  <shape type="rectangle">
    <transform name="to_world"><rotate x="1" angle="-90"/><scale value="3"/></transform>
  </shape>
)";
constexpr const char* scene_lamp = R"(
  <shape type="sphere">
    <point name="center" x="0" y="2" z="0"/>
    <float name="radius" value="0.5"/>
    <emitter type="area"><rgb name="radiance" value="5, 4, 3"/></emitter>
  </shape>
)";

std::string text_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void write_text(const fs::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

struct Result {
  int exit_code;  // or the signal that killed it, negative
  std::string out;
  std::string err;
};

// Each test has a folder of its own, in which `plumb` runs, with two scenes.
class CliTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder = fs::path(testing::TempDir()) /
             ("plumb-" + std::to_string(getpid()) + "-" + std::string(test->name()));
    fs::create_directories(folder / "folder.exr");
    write_text(folder / "scene.xml", std::string(scene_start) + scene_lamp + "</scene>");
    write_text(folder / "unlit.xml", std::string(scene_start) + "</scene>");
  }

  void TearDown() override { fs::remove_all(folder); }

  // `arguments` are separated by spaces; without `stderr_to`, stderr goes into a file.
  pid_t start(const std::string& arguments, int stderr_to = -1) const {
    std::istringstream stream(arguments);
    std::vector<std::string> words{PLUMB_EXECUTABLE};
    for (std::string word; stream >> word;) words.push_back(word);
    std::vector<char*> argv(words.size() + 1);  // ends with a null pointer
    std::ranges::transform(words, argv.begin(), [](std::string& word) { return word.data(); });

    const pid_t child = fork();
    if (child != 0) return child;
    const auto open_new = [](const char* name) {
      return open(name, O_WRONLY | O_CREAT | O_TRUNC, 0666);
    };
    if (chdir(folder.c_str()) == 0) {
      dup2(open_new("stdout.txt"), STDOUT_FILENO);
      dup2(stderr_to >= 0 ? stderr_to : open_new("stderr.txt"), STDERR_FILENO);
      execv(argv[0], argv.data());
    }
    _exit(127);
  }

  Result finish(pid_t child) const {
    int status = 0;
    EXPECT_EQ(waitpid(child, &status, 0), child);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status),
            text_of(folder / "stdout.txt"), text_of(folder / "stderr.txt")};
  }

  Result plumb(const std::string& arguments) const { return finish(start(arguments)); }

  static bool has_terminals() {
    const int terminal = posix_openpt(O_RDWR | O_NOCTTY);
    if (terminal >= 0) close(terminal);
    return terminal >= 0;
  }

  // Sends the signal once its progress, which it shows on a terminal alone, has these words.
  Result interrupt(const std::string& arguments, const std::string& words, int signal) const {
    const int terminal = posix_openpt(O_RDWR | O_NOCTTY);
    EXPECT_GE(terminal, 0);
    EXPECT_EQ(grantpt(terminal), 0);
    EXPECT_EQ(unlockpt(terminal), 0);
    const int terminal_end = open(ptsname(terminal), O_RDWR | O_NOCTTY);
    const pid_t child = start(arguments, terminal_end);
    close(terminal_end);
    std::string shown;
    char buffer[256];
    for (ssize_t n = 1; n > 0 && shown.find(words) == std::string::npos;) {
      n = read(terminal, buffer, sizeof(buffer));
      shown.append(buffer, size_t(std::max<ssize_t>(n, 0)));
    }
    kill(child, signal);
    Result result = finish(child);
    close(terminal);
    return result;
  }

  // Expects success.
  Image render(const std::string& arguments) const {
    const Result result = plumb("render " + arguments + " -o rendered.exr");
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return read_image(folder / "rendered.exr");
  }

  // Expects exit code 2, one line on stderr with `fragment`, and the files as they were.
  void expect_trouble(const std::string& arguments, const std::string& fragment) const {
    SCOPED_TRACE("plumb " + arguments);
    write_text(folder / "earlier.exr", "earlier");
    const Result result = plumb(arguments);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.out, "");
    EXPECT_NE(result.err.find(fragment), std::string::npos) << result.err;
    EXPECT_EQ(result.err.find('\n'), result.err.size() - 1) << result.err;
    EXPECT_EQ(text_of(folder / "earlier.exr"), "earlier");
    EXPECT_FALSE(fs::exists(folder / "new.exr"));
  }

  fs::path folder;
};

TEST_F(CliTest, EveryHelpHasAnExampleAndFitsIntoATerminal) {
  for (const std::string command :
       {"", "render ", "radiosity ", "merge ", "export ", "reference ", "compare ", "power "}) {
    const Result result = plumb(command + "--help");
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_EQ(result.err, "");
    EXPECT_NE(result.out.find("\nUsage: plumb " + command), std::string::npos) << result.out;
    EXPECT_NE(result.out.find("\nExample"), std::string::npos) << result.out;
    std::istringstream lines(result.out);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80U) << line;
  }
  EXPECT_EQ(plumb("--version").out, "plumb " PLUMB_VERSION "\n");
}

TEST_F(CliTest, ReferenceListsItsProgramsForOtherPrograms) {
  const Result result = plumb("reference --list");
  EXPECT_EQ(result.exit_code, 0);
  for (const char* word : {"povray", "cycles", "mitsuba", "isInstalled", "hasSamples"}) {
    EXPECT_NE(result.out.find('"' + std::string(word) + '"'), std::string::npos) << word;
  }
}

TEST_F(CliTest, TroubleIsToldInOneLineBeforeAnyFileIsTouched) {
  const std::pair<std::string, std::string> cases[] = {
      {"", "no command"},
      {"rendr", "rendr"},
      {"render", "SCENE"},
      {"render scene.xml", "--output"},
      {"render scene.xml -o", "--output"},
      {"render scene.xml -o new.exr other.xml", "other.xml"},
      {"render scene.xml -o new.exr --colour", "--colour"},
      {"render missing.xml -o new.exr", "missing.xml: no such file"},
      {"render scene.xml -o new.jpg", "new.jpg: unknown image format"},
      {"render scene.xml -o new.exr -o missing/new.exr", "No such file or directory"},
      {"render scene.xml -o new.exr -o folder.exr", "folder.exr: cannot write: Is a directory"},
      {"render scene.xml -o new.exr -o new.exr", "new.exr is given twice"},
      {"render scene.xml -o new.png --exposure nan",
       "--exposure: 'nan' is not a number from -100 to 100"},
      {"render scene.xml -o new.exr --size 0x5", "--size: '0' is not a whole number"},
      {"render scene.xml -o new.exr --spp 0", "--spp: '0' is not a whole number"},
      {"render scene.xml -o new.exr --spp 99999999999999999999", "--spp"},
      {"render scene.xml -o new.exr --time 0", "--time: '0' is not a number from 0.001"},
      {"render scene.xml -o new.exr --error nan", "--error: 'nan' is not"},
      {"render scene.xml -o new.exr --samples 5:5", "--samples: '5:5' is not a range"},
      {"render scene.xml -o new.exr --samples 0:4 --spp 4", "excludes"},
      {"render scene.xml -o new.exr --from sun", "no shape has the id \"sun\""},
      {"render scene.xml -o new.exr --from a --by a", "--from excludes --by"},
      {"render scene.xml -o new.exr --bounces 3:1", "--bounces: '3:1' is not a range"},
      {"render scene.xml -o new.exr --method best", "bsdf, nee, mis"},
      {"render scene.xml -o new.exr --seed -1", "--seed"},
      {"render scene.xml -o new.exr --threads 0", "--threads"},
      {"render unlit -o earlier.exr", "unlit"},
      {"render scene.xml -o new.exr --fault inverse-pi --precision double", "float only"},
      {"power scene.xml", "plumbline.exr"},
      {"power scene.xml --time 0", "--time"},
      {"merge", "PART"},
      {"merge missing.exr -o new.exr", "missing.exr"},
      {"merge earlier.exr -o earlier.exr", "earlier.exr: not an EXR image"},
  };
  for (const auto& [arguments, fragment] : cases) expect_trouble(arguments, fragment);
}

TEST_F(CliTest, RenderWritesLinearPictureWithNoiseAndPreview) {
  const Result result = plumb("render scene.xml --spp 8 -o a.exr -o a.png --exposure -1");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.err, "");
  EXPECT_NE(result.out.find("wrote a.exr\nwrote a.png\n"), std::string::npos) << result.out;
  const Image image = read_image(folder / "a.exr");
  EXPECT_EQ(image.width, 8);
  EXPECT_EQ(image.height, 6);
  EXPECT_EQ(image.channels,
            (std::vector<std::string>{"R", "G", "B", "variance.R", "variance.G", "variance.B"}));
  EXPECT_TRUE(text_of(folder / "a.png").starts_with("\x89PNG"));
}

TEST_F(CliTest, ImageTellsHowItWasMade) {
  const Image image = render(
      "scene.xml --size 5x4 --spp 6 --method nee --sampler independent --precision double "
      "--bounces 1:3 --seed 7 --threads 1");
  EXPECT_EQ(image.width, 5);
  EXPECT_EQ(image.height, 4);
  const Provenance& made = image.provenance;
  EXPECT_EQ(made.renderer, "plumbline");
  EXPECT_EQ(made.version, PLUMB_VERSION);
  EXPECT_EQ(made.scene, folder.filename());
  EXPECT_EQ(made.scene_hash.value().size(), 40U);
  EXPECT_EQ(made.method, "nee");
  EXPECT_EQ(made.precision, "double");
  EXPECT_EQ(made.sampler, "independent");
  EXPECT_EQ(made.bounces, "1:3");
  EXPECT_EQ(made.samples, "0:6");
  EXPECT_EQ(made.seed, 7);
  EXPECT_EQ(made.replicates, 4);
  EXPECT_NE(made.host.value().find(", 1 thread, "), std::string::npos);
  for (const auto& number : {made.relative_error, made.wall_seconds, made.cpu_seconds, made.rays}) {
    EXPECT_GT(number.value(), 0.0);
  }
  EXPECT_EQ(render("scene.xml").provenance.samples.value(), "0:64");
}

TEST_F(CliTest, ASceneThatNeedsDoubleIsRenderedSoAndThatIsSaid) {
  const std::string gap = PLUMB_SCENES "/stress/gap.xml";
  const auto render_gap = [&](const std::string& options) {
    const Result result = plumb("render " + gap + " --spp 4 -o gap.exr " + options);
    EXPECT_EQ(result.exit_code, 0);
    return std::pair(result.err, read_image(folder / "gap.exr"));
  };
  const auto [note, fitting] = render_gap("");
  EXPECT_EQ(note,
            "plumb: in double precision, because float is too coarse for the gap between "
            "'plate_left' and 'plate_right'\n");
  EXPECT_EQ(fitting.provenance.precision, "double");
  EXPECT_EQ(fitting.values, render_gap("--precision double").second.values);
  for (const std::string insisting : {"--precision float", "--fault inverse-pi"}) {
    const auto [silence, coarse] = render_gap(insisting);
    EXPECT_EQ(silence, "");
    EXPECT_EQ(coarse.provenance.precision, "float");
  }
  EXPECT_EQ(render_gap("--method plain").first, "");
  EXPECT_EQ(plumb("render " + gap + " --aov object -o mask.exr").err, "");
  EXPECT_EQ(render("scene.xml").provenance.precision, "float");
}

TEST_F(CliTest, LampsThatEveryPathMeetsAreLeftToChanceAndThatIsSaid) {
  const std::string scene = PLUMB_SCENES "/stress/white_opening.xml";
  const auto method_of = [&](const std::string& options) {
    const Result result = plumb("render " + scene + " --spp 4 -o open.exr " + options);
    EXPECT_EQ(result.exit_code, 0);
    return std::pair(read_image(folder / "open.exr").provenance.method, result.err);
  };
  const std::string note =
      "plumb: lamps are left to chance (bsdf), by which every path meets them\n";
  EXPECT_EQ(method_of(""), std::pair(std::optional<std::string>("bsdf"), note));
  for (const std::string other : {"--method mis", "--bounces 0:9", "--fault inverse-pi"}) {
    EXPECT_EQ(method_of(other), std::pair(std::optional<std::string>("mis"), std::string()));
  }
}

TEST_F(CliTest, RenderingEndsWithTheFirstLimit) {
  EXPECT_EQ(render("scene.xml --spp 5 --time 1000").provenance.samples.value(), "0:5");
  EXPECT_GE(render("scene.xml --time 0.05").provenance.wall_seconds.value(), 0.05);
  // Other samples tell how many it takes, and either know the error to some ten per cent.
  const Image accurate = render("scene.xml --error 2%");
  EXPECT_LE(accurate.provenance.relative_error.value(), 0.02 * 1.25);
  const std::string samples = accurate.provenance.samples.value();
  EXPECT_EQ(accurate.values, render("scene.xml --spp " + samples.substr(2)).values);
  EXPECT_EQ(render("scene.xml --error 0.02 --spp 9").values, render("scene.xml --spp 9").values);
}

TEST_F(CliTest, MergedPartsEqualTheWhole) {
  const Image whole = render("scene.xml --samples 0:50");
  for (const char* range : {"0:3", "3:20", "20:50"}) {
    const std::string part = std::string("scene.xml --samples ") + range;
    EXPECT_EQ(plumb("render " + part + " -o " + range + ".exr").exit_code, 0);
  }
  EXPECT_EQ(plumb("merge 20:50.exr 3:20.exr -o 3:50.exr").exit_code, 0);
  const Result result = plumb("merge 3:50.exr 0:3.exr -o merged.exr");
  EXPECT_EQ(result.exit_code, 0) << result.err;

  const Image merged = read_image(folder / "merged.exr");
  EXPECT_EQ(merged.provenance.samples.value(), "0:50");
  EXPECT_EQ(merged.provenance.relative_error.value(), whole.provenance.relative_error.value());
  EXPECT_EQ(merged.provenance.rays.value(), whole.provenance.rays.value());
  EXPECT_EQ(merged.channels, whole.channels);
  EXPECT_EQ(merged.values, whole.values);

  EXPECT_EQ(plumb("merge 0:3.exr 3:50.exr --last -o last.exr").exit_code, 0);
  const Image last = read_image(folder / "last.exr");
  const Image at_once = render("scene.xml --spp 50");
  EXPECT_EQ(last.channels, at_once.channels);
  EXPECT_EQ(last.values, at_once.values);
}

// All of a file but costs and machine, which stand in the provenance.
void expect_same_file(const Image& a, const Image& b) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.channels, b.channels);
  EXPECT_EQ(a.values, b.values);
  EXPECT_EQ(a.provenance.samples, b.provenance.samples);
  EXPECT_EQ(a.provenance.crop, b.provenance.crop);
  EXPECT_EQ(a.provenance.rays, b.provenance.rays);
  EXPECT_EQ(a.provenance.relative_error, b.provenance.relative_error);
}

TEST_F(CliTest, ACropIsThePlaceOfThePictureThatItSays) {
  for (const std::string settings : {"--spp 7", "--spp 2 --method plain", "--samples 3:9"}) {
    const Image whole = render("scene.xml " + settings);
    render("scene.xml --crop 2,1,5,3 " + settings);
    const Image crop = read_data_window(folder / "rendered.exr");
    EXPECT_EQ(crop.width, 5);
    EXPECT_EQ(crop.height, 3);
    EXPECT_EQ(crop.left, 2);
    EXPECT_EQ(crop.top, 1);
    EXPECT_EQ(crop.display, (Window{-2, -1, 8, 6}));
    EXPECT_EQ(crop.provenance.crop.value(), "2,1,5,3");
    ASSERT_EQ(crop.channels, whole.channels);
    const size_t stride = whole.channels.size();
    for_each_pixel({0, 0, 5, 3}, [&](int x, int y) {
      for (size_t c = 0; c < stride; ++c) {
        EXPECT_EQ(crop.values[crop.pixel(x, y) * stride + c],
                  whole.values[whole.pixel(x + 2, y + 1) * stride + c]);
      }
    });
  }
  const Result whole = plumb("render scene.xml --spp 2 --crop 0,0,8,6 -o all.exr");
  EXPECT_EQ(whole.exit_code, 0);
  expect_same_file(read_image(folder / "all.exr"), render("scene.xml --spp 2"));
}

TEST_F(CliTest, ACropsMaskAndPictureAreComparedWhereTheyAre) {
  render("scene.xml --spp 64");
  fs::rename(folder / "rendered.exr", folder / "whole.exr");
  render("scene.xml --spp 64 --crop 4,2,4,4");
  ASSERT_EQ(plumb("render scene.xml --aov object --crop 4,2,4,4 -o mask.exr").exit_code, 0);
  const Result result = plumb("compare rendered.exr whole.exr --crop 4,2,4,4 --regions mask.exr");
  EXPECT_EQ(result.exit_code, 0) << result.out << result.err;
}

TEST_F(CliTest, ACropsMaskHasTheColoursOfTheWholeOne) {
  const std::string cornell = PLUMB_SCENES "/cornell/scene.xml --size 32x32 -o mask.exr --aov ";
  for (const char* kind : {"object", "side", "shadow"}) {
    ASSERT_EQ(plumb("render " + cornell + kind).exit_code, 0);
    const Image whole = read_image(folder / "mask.exr");
    ASSERT_EQ(plumb("render " + cornell + kind + " --crop 17,12,9,14").exit_code, 0);
    const Image crop = read_data_window(folder / "mask.exr");
    for_each_pixel({0, 0, 9, 14}, [&](int x, int y) {
      for (size_t c = 0; c < 3; ++c) {
        EXPECT_EQ(crop.values[crop.pixel(x, y) * 3 + c],
                  whole.values[whole.pixel(x + 17, y + 12) * 3 + c]);
      }
    });
    for (const auto& region : crop.provenance.regions)
      EXPECT_EQ(std::ranges::count(whole.provenance.regions, region), 1) << region.second;
  }
}

TEST_F(CliTest, AMaskOfLinearValuesNamesItsRegionsToo) {
  const std::string cornell = PLUMB_SCENES "/cornell/scene.xml --size 32x32 ";
  ASSERT_EQ(plumb("render " + cornell + "--spp 16 -o box.exr").exit_code, 0);
  ASSERT_EQ(plumb("render " + cornell + "--aov object -o mask.exr -o mask.png").exit_code, 0);
  const Result by_codes = plumb("compare box.exr box.exr --regions mask.png");
  EXPECT_NE(by_codes.out.find("| left_wall "), std::string::npos) << by_codes.out;
  EXPECT_EQ(plumb("compare box.exr box.exr --regions mask.exr").out, by_codes.out);
}

TEST_F(CliTest, CropsInAnyOrderEqualTheWhole) {
  const auto draw = [&](const std::string& name, const std::string& words) {
    ASSERT_EQ(plumb("render scene.xml " + words + " -o " + name + ".exr").exit_code, 0);
  };
  for (const char* samples : {"--spp 9", "--samples 0:9"}) {
    draw("top", std::string(samples) + " --crop 0,0,8,1");
    draw("left", std::string(samples) + " --crop 0,1,3,5");
    draw("right", std::string(samples) + " --crop 3,1,5,5");
    const Image whole = render(std::string("scene.xml ") + samples);
    ASSERT_EQ(plumb("merge right.exr top.exr left.exr -o all.exr").exit_code, 0);
    expect_same_file(read_image(folder / "all.exr"), whole);
    const Result below = plumb("merge right.exr left.exr -o below.exr");
    EXPECT_NE(below.out.find("pixels 0,1,8,5 of 8x6"), std::string::npos) << below.out;
    ASSERT_EQ(plumb("merge below.exr top.exr --last -o all.exr").exit_code, 0);
    expect_same_file(read_image(folder / "all.exr"), render("scene.xml --spp 9"));
  }
}

TEST_F(CliTest, PartsByPixelsAndSamplesEqualTheWhole) {
  std::string parts;
  for (const std::string crop : {"0,4,8,2", "0,0,8,4"}) {
    for (const std::string samples : {"5:9", "0:4", "4:5"}) {
      const std::string name = samples + "-" + crop + ".exr";
      const std::string words = " --samples " + samples + " --crop " + crop;
      ASSERT_EQ(plumb("render scene.xml" + words + " -o " + name).exit_code, 0);
      parts += " " + name;
    }
  }
  ASSERT_EQ(plumb("merge" + parts + " -o all.exr").exit_code, 0);
  expect_same_file(read_image(folder / "all.exr"), render("scene.xml --samples 0:9"));
  ASSERT_EQ(plumb("merge" + parts + " --last -o all.exr").exit_code, 0);
  expect_same_file(read_image(folder / "all.exr"), render("scene.xml --spp 9"));
}

TEST_F(CliTest, CropsThatDontMakeUpThePictureAreRefused) {
  const std::pair<std::string, std::string> parts[] = {
      {"a", "--spp 4 --crop 0,0,4,6"},         {"b", "--spp 4 --crop 4,0,4,3"},
      {"c", "--spp 4 --crop 3,3,5,3"},         {"d", "--spp 4 --crop 5,3,3,3"},
      {"more", "--spp 5 --crop 4,0,4,6"},      {"sums", "--samples 0:4 --crop 4,0,4,6"},
      {"right", "--spp 4 --crop 4,0,4,6"},     {"early", "--samples 0:2 --crop 4,0,4,6"},
      {"late", "--samples 3:4 --crop 4,0,4,6"}};
  for (const auto& [name, words] : parts) {
    ASSERT_EQ(plumb("render scene.xml " + words + " -o " + name + ".exr").exit_code, 0);
  }
  const std::pair<std::string, std::string> cases[] = {
      {"a b", "no part has pixels 4,3,4,3"},
      {"d b a", "no part has pixels 4,3,1,3"},
      {"b d", "no part has pixels 4,3,1,3"},
      {"b --last", ""},
      {"b c a", "a.exr and c.exr overlap: both have pixels 3,3,1,3"},
      {"a more", "pixels 0,0,4,6 have samples 0:4, pixels 4,0,4,6 0:5"},
      {"a early late", "samples 0:2 and 3:4 of pixels 4,0,4,6 leave a gap"},
      {"a right late", "right.exr: lacks sums"},
      {"b right --last", "overlap: both have pixels 4,0,4,3"}};
  for (const auto& [names, fragment] : cases) {
    std::istringstream stream(names);
    std::string words = "merge";
    for (std::string name; stream >> name;) words += " " + name + (name[0] == '-' ? "" : ".exr");
    if (fragment.empty()) {
      EXPECT_EQ(plumb(words + " -o new.exr").exit_code, 0) << "a crop alone may be finished";
      fs::remove(folder / "new.exr");
    } else {
      expect_trouble(words + " -o new.exr", fragment);
    }
  }
  EXPECT_EQ(plumb("merge a.exr sums.exr -o new.exr").exit_code, 0) << "sums are not needed";
  fs::remove(folder / "new.exr");
  expect_trouble("render scene.xml --crop 4,0,5,6 -o new.exr", "beyond the picture, which has 8x6");
  expect_trouble("render scene.xml --crop 0,0,4,3 --fault flipped -o new.exr", "--crop excludes");
}

TEST_F(CliTest, MergeRefusesWhatDoesNotBelongTogether) {
  const std::pair<std::string, std::string> parts[] = {
      {"a", "scene.xml --samples 0:8"},
      {"overlap", "scene.xml --samples 4:12"},
      {"later", "scene.xml --samples 12:16"},
      {"seed", "scene.xml --samples 8:16 --seed 2"},
      {"scene", "unlit.xml --samples 8:16"},
      {"size", "scene.xml --samples 8:16 --size 6x8"},
      {"whole", "scene.xml --spp 8"},
      {"fault", "scene.xml --samples 8:16 --fault half-pixel"},
  };
  for (const auto& [name, arguments] : parts) {
    ASSERT_EQ(plumb("render -o " + name + ".exr " + arguments).exit_code, 0);
  }
  const std::pair<std::string, std::string> cases[] = {
      {"a", "samples 0:8 and 0:8 overlap"},
      {"overlap", "samples 0:8 and 4:12 overlap"},
      {"later", "samples 0:8 and 12:16 leave a gap"},
      {"seed", "seed.exr: not the same seed"},
      {"scene", "scene.exr: not the same scene"},
      {"size", "size.exr: not the same size"},
      {"whole", "whole.exr: lacks sums"},
      {"fault", "fault.exr: not the same fault"},
  };
  for (const auto& [other, fragment] : cases) {
    expect_trouble("merge a.exr " + other + ".exr -o new.exr", fragment);
  }
}

TEST_F(CliTest, PlantedFaultIsToldByThePicture) {
  const Image faulty = render("scene.xml --fault webgl-demo");
  EXPECT_EQ(faulty.provenance.fault.value(), "webgl-demo");
  const Image healthy = render("scene.xml");
  EXPECT_FALSE(healthy.provenance.fault);
  EXPECT_NE(faulty.values, healthy.values);
}

TEST_F(CliTest, UnknownFaultIsAnsweredByAllThatAreKnown) {
  for (const char* command : {"render scene.xml -o new.exr", "power scene.xml"}) {
    const Result result = plumb(std::string(command) + " --fault inverse");
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_NE(result.err.find("'inverse' is not one of\n"), std::string::npos) << result.err;
    EXPECT_NE(result.err.find("\n  inverse-pi          1/pi is forgotten"), std::string::npos);
    EXPECT_EQ(std::ranges::count(result.err, '\n'), 1 + 52);
  }
}

// The lines of a table, its head left out.
std::vector<std::string> rows_of(const std::string& table) {
  std::vector<std::string> rows;
  std::istringstream lines(table);
  for (std::string line; std::getline(lines, line);) rows.push_back(line);
  EXPECT_GE(rows.size(), 2U);
  rows.erase(rows.begin(), rows.begin() + std::min<ptrdiff_t>(2, std::ssize(rows)));
  return rows;
}

TEST_F(CliTest, PowerFindsFaultsAndNothingWhereThereIsNone) {
  const std::string scenes = PLUMB_SCENES;
  const Result result =
      plumb("power --time 1 " + scenes + "/cornell/scene.xml " + scenes + "/seed/scene.xml");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const std::vector<std::string> rows = rows_of(result.out);
  EXPECT_EQ(rows.size(), 32U) << result.out;
  for (const std::string& row : rows) {
    const bool is_found = row.find("not found") == std::string::npos;
    const auto tells = [&](const char* fault) { return row.find(fault) != std::string::npos; };
    if (tells(" none ")) {
      EXPECT_FALSE(is_found) << row;
    }
    if (tells(" inverse-pi ")) {
      EXPECT_TRUE(is_found) << row;
    }
    if (tells(" gamma-reflectance ")) {
      EXPECT_TRUE(is_found) << row;
    }
  }
}

TEST_F(CliTest, PowerTakesAnyScene) {
  render("scene.xml --size 32x32 --spp 4096");
  const Result result =
      plumb("power scene.xml --reference rendered.exr --time 1 --fault half-lamp-area");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const std::vector<std::string> rows = rows_of(result.out);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_NE(rows[0].find("not found"), std::string::npos) << rows[0];
  EXPECT_NE(rows[1].find("half-lamp-area"), std::string::npos) << rows[1];
  EXPECT_EQ(rows[1].find("not found"), std::string::npos) << rows[1];
}

TEST_F(CliTest, UnlitSceneIsBlackWithAWarning) {
  const Result result = plumb("render unlit.xml --spp 4 -o black.exr");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_NE(result.err.find("warning: unlit.xml: no lamp"), std::string::npos) << result.err;
  const Image image = read_image(folder / "black.exr");
  EXPECT_TRUE(std::ranges::all_of(image.values, [](float value) { return value == 0.0F; }));
}

TEST_F(CliTest, InterruptSavesWhatIsFinishedWithItsTrueCount) {
  if (!has_terminals()) GTEST_SKIP() << "no pseudo-terminals here";
  for (const int signal : {SIGINT, SIGTERM}) {
    const Result result = interrupt("render scene.xml --time 300 -o saved.exr", " spp", signal);

    EXPECT_EQ(result.exit_code, 128 + signal);
    const auto samples = read_image(folder / "saved.exr").provenance.samples.value();
    const std::string count = samples.substr(samples.find(':') + 1);
    EXPECT_NE(result.out.find(": " + count + " spp in "), std::string::npos) << result.out;
    EXPECT_EQ(read_image(folder / "saved.exr").values, render("scene.xml --spp " + count).values);
  }
}

// A room in which everything reflects everything, and a room of perfect mirrors.
TEST_F(CliTest, PathsThatNeverEndAreToldWhenTheTimeIsUpOrSomebodyAsks) {
  if (!has_terminals()) GTEST_SKIP() << "no pseudo-terminals here";
  const auto room =
      [&](const std::string& name, const std::string& bsdf, const std::string& lamp) {
        std::ofstream(folder / name)
            << R"(<scene version="3.0.0"><sensor type="perspective"><float name="fov" value="70"/>)"
               R"(<film type="hdrfilm"><integer name="width" value="32"/>)"
               R"(<integer name="height" value="32"/><rfilter type="box"/></film></sensor>)"
               R"(<shape type="cube"><transform name="to_world"><scale value="3"/></transform>)"
               R"(<bsdf type="twosided">)"
            << bsdf << R"(</bsdf></shape><shape type="sphere"><float name="radius" value="0.3"/>)"
            << R"(<point name="center" x="1" y="1" z="1"/>)" << lamp
            << R"(<emitter type="area"/></shape></scene>)";
      };
  const std::string white = R"(<bsdf type="diffuse"><rgb name="reflectance" value="1"/></bsdf>)";
  const std::string mirror = R"(<bsdf type="conductor"/>)";
  room("white.xml", white, white);
  room("mirrors.xml", mirror, mirror);
  for (const std::string scene : {"white.xml", "mirrors.xml"}) {
    const Result late = plumb("render " + scene + " --time 0.1 -o never.exr");
    EXPECT_EQ(late.exit_code, 2);
    EXPECT_NE(late.err.find("bounces: every surface that it meets reflects everything"),
              std::string::npos)
        << late.err;
    EXPECT_NE(late.err.find("there is no picture to save"), std::string::npos) << late.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "never.exr"));
    EXPECT_EQ(interrupt("render " + scene + " -o never.exr", "first pass", SIGTERM).exit_code,
              128 + SIGTERM);
    EXPECT_EQ(plumb("render " + scene + " --bounces 0:9 --spp 4 -o never.exr").exit_code, 0);
    std::filesystem::remove(folder / "never.exr");
  }
}

TEST_F(CliTest, ASceneFileAsksForBouncesAndSamplesUnlessTheCommandDoes) {
  std::ofstream(folder / "asks.xml")
      << R"(<scene version="3.0.0"><integrator type="path"><integer name="max_depth" value="3"/>)"
         R"(</integrator><sensor type="perspective"><sampler type="independent">)"
         R"(<integer name="sample_count" value="8"/></sampler><film type="hdrfilm">)"
         R"(<integer name="width" value="8"/><integer name="height" value="8"/>)"
         R"(<rfilter type="box"/></film></sensor><shape type="sphere"><emitter type="area"/>)"
         R"(</shape></scene>)";
  const auto said = [&](const std::string& options) {
    EXPECT_EQ(plumb("render asks.xml -o asks.exr " + options).exit_code, 0);
    const Image image = read_image(folder / "asks.exr");
    return image.provenance.bounces.value() + " " + image.provenance.samples.value();
  };
  EXPECT_EQ(said(""), "0:2 0:8");
  EXPECT_EQ(said("--bounces 1:4 --spp 12"), "1:4 0:12");
  const Result result = plumb("render asks.xml -o asks.exr");
  EXPECT_NE(result.err.find("max_depth\" value=\"3\">: --bounces 0:2"), std::string::npos)
      << result.err;
  EXPECT_NE(read_image(folder / "asks.exr").provenance.scene_notes.value().find("--bounces 0:2"),
            std::string::npos);
}

}  // namespace
}  // namespace plumb
