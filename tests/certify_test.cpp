// SPDX-License-Identifier: Apache-2.0

// `plumb certify`, tried with renderers that are known: this one, healthy and with faults, and
// scripts that misbehave.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "images/image.h"
#include "other_renderers/description.h"
#include "tests/plumb_command.h"

namespace plumb {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr const char* closed_forms = PLUMB_SCENES "/closed_forms";

class Certify : public PlumbCommand {
 protected:
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder / name) << text;
    return folder / name;
  }

  // This renderer as anybody's, with more options.
  std::string describe_ours(const std::string& more = "", const std::string& keys = "") const {
    return write("ours.toml", fmt::format(R"(
name = "Ours"
command = ["{}", "render", "{{scene}}", "--spp", "{{spp}}", "--seed", "{{seed}}",
           "--size", "{{width}}x{{height}}", "--bounces", "0:{{bounces}}",
           "--threads", "{{threads}}", "-o", "{{output}}"{}]
version = ["{}", "--version"]
same_bits = true
{})",
                                          PLUMB_EXECUTABLE, more, PLUMB_EXECUTABLE, keys));
  }

  std::string describe_script(const std::string& script, const std::string& keys = "") const {
    const std::string file = write("script.sh", "#!/bin/sh\n" + script + "\n");
    chmod(file.c_str(), 0755);
    return write("script.toml",
                 "command = [\"./script.sh\", \"{scene}\", \"{output}\", \"{spp}\"]\n" + keys);
  }

  Json certify(const std::string& description, const std::string& scenes, int status,
               const std::string& more = "") const {
    const Result result = plumb(
        fmt::format("certify --quick --folder {} --with {} --scene {} --time 300 -o page.html {}",
                    PLUMB_SCENES, description, scenes, more));
    EXPECT_EQ(result.exit_code, status) << result.output;
    std::ifstream stream(folder / "page.json");
    return stream ? Json::parse(stream) : Json();
  }

  static Json answer(const Json& certificate, const std::string& name) {
    for (const Json& answer : certificate["answers"]) {
      if (answer["name"] == name) return answer;
    }
    ADD_FAILURE() << "no answer to " << name;
    return {};
  }
};

TEST_F(Certify, ARightRendererPassesTheClosedForms) {
  std::string scenes;
  for (const auto& entry : fs::directory_iterator(closed_forms)) {
    if (entry.path().extension() == ".xml") scenes += entry.path().stem().string() + ",";
  }
  scenes.pop_back();
  const Json certificate = certify(describe_ours(), scenes, 0);
  EXPECT_EQ(certificate["passed"], true);
  EXPECT_EQ(certificate["answers"].size(), 26u);  // four are about the program
  for (const Json& answer : certificate["answers"]) {
    EXPECT_EQ(answer["mark"], "right") << answer.dump(1);
  }
}

TEST_F(Certify, AFaultIsFoundByTheFirstSceneThatShowsIt) {
  const auto first_wrong = [&](const std::string& fault) {
    const Json certificate =
        certify(describe_ours(fmt::format(R"(, "--fault", "{}")", fault)),
                "01_lamp,02_matte_floor,03_tilted_lamp,04_lamps_back,11_room,12_white_room", 1);
    for (const Json& answer : certificate["answers"]) {
      if (answer["mark"] == "wrong") return answer["name"].get<std::string>();
    }
    return std::string();
  };
  EXPECT_EQ(first_wrong("inverse-pi"), "02_matte_floor");
  EXPECT_EQ(first_wrong("half-lamp-area"), "02_matte_floor");
  EXPECT_EQ(first_wrong("emitter-cosine"), "02_matte_floor");
  EXPECT_EQ(first_wrong("two-sided-lamp"), "04_lamps_back");
  EXPECT_EQ(first_wrong("five-bounces"), "11_room");
}

TEST_F(Certify, ABlackPictureIsWrongByAllOfIt) {
  const Json certificate =
      certify(describe_ours(R"(, "--fault", "lamp-missing")"), "02_matte_floor", 1);
  EXPECT_EQ(answer(certificate, "02_matte_floor")["text"], "-100 ± 0 %");
}

TEST_F(Certify, APictureIsFoundThatIsUpsideDownMirroredOrShifted) {
  for (const char* keys : {"[picture]\nflipped = true", "[picture]\nmirrored = true"}) {
    const Json certificate = certify(describe_ours("", keys), "00_corners", 1);
    EXPECT_EQ(answer(certificate, "00_corners")["mark"], "wrong");
  }
  certify(describe_ours(R"(, "--fault", "half-pixel")"), "00_corners", 1);
}

TEST_F(Certify, SinglePixelsOfThousandsAreToldButDecideNothing) {
  // A black chip right before the camera hides a pixel of the lamp.
  write("draw.py", R"py(
import pathlib, re, subprocess, sys
plumb, file, output, samples, seed = sys.argv[1:]
scene = pathlib.Path(file)
text = re.sub(r'value="(\w+\.obj)"', rf'value="{scene.parent}/\1"', scene.read_text())
pathlib.Path("scene.xml").write_text(text.replace("</scene>", """<shape type="rectangle">
  <transform name="to_world">
    <scale value="0.0013"/><rotate y="1" angle="180"/><translate x="278.0014" y="273.2553" z="-799"/>
  </transform>
  <ref id="black"/>
</shape></scene>"""))
subprocess.run([plumb, "render", "scene.xml", "--spp", samples, "--seed", seed, "-o", output], check=True)
)py");
  const std::string description = write("draw.toml", fmt::format(R"(
command = ["python3", "{{here}}/draw.py", "{}", "{{scene}}", "{{output}}", "{{spp}}", "{{seed}}"])",
                                                                 PLUMB_EXECUTABLE));
  const Json box = answer(certify(description, "cornell", 0, "--tolerance 4"), "cornell");
  EXPECT_EQ(box["mark"], "right");
  EXPECT_GT(box["samplesPerPixel"], 64);  // after a round that left the rest open
  EXPECT_NE(box["text"].get<std::string>().find(", but for "), std::string::npos) << box;
}

TEST_F(Certify, ThePageShowsWhatIsWrongAndWhatItMayBe) {
  certify(describe_ours(R"(, "--fault", "inverse-pi")"), "02_matte_floor", 1);
  std::ifstream stream(folder / "page.html");
  const std::string page(std::istreambuf_iterator<char>(stream), {});
  EXPECT_NE(page.find("If this is wrong: by pi"), std::string::npos);
  EXPECT_NE(page.find("data:image/png;base64,"), std::string::npos);
  std::ifstream xml(folder / "page.xml");
  const std::string junit(std::istreambuf_iterator<char>(xml), {});
  EXPECT_NE(junit.find("<failure"), std::string::npos);
}

TEST_F(Certify, WhatIsWrongIsPlacedInThePicture) {
  const auto worst_of = [&](const std::string& description) {
    const Json worst = answer(certify(description, "cornell", 1), "cornell")["worst"];
    EXPECT_GT(std::abs(worst["bias"].get<double>()) - worst["error"].get<double>(), 0.005);
    const std::string place = worst.contains("region")
                                  ? worst["region"].get<std::string>()
                                  : fmt::format("block at {},{}", worst["window"][0].get<int>(),
                                                worst["window"][1].get<int>());
    const std::string text =
        fmt::format("; most clearly {}, {}: ", place, worst["channel"].get<std::string>());
    for (const char* file : {"page.html", "page.xml"}) {
      std::ifstream stream(folder / file);
      const std::string page(std::istreambuf_iterator<char>(stream), {});
      EXPECT_NE(page.find(text), std::string::npos) << file << text;
    }
    return worst;
  };
  const Json block = worst_of(describe_ours(R"(, "--fault", "five-bounces")"));
  EXPECT_EQ(block["window"][2], 8);
  EXPECT_EQ(block["window"][3], 8);
  // A little light too much on all of the ceiling.
  EXPECT_EQ(worst_of(describe_ours(R"(, "--fault", "one-sided-mis")"))["region"], "ceiling");
}

TEST_F(Certify, WhatMeetsLampsByChanceIsToldToSampleThem) {
  // Too short and too strict for any answer.
  const auto noisy = [&](const std::string& method) {
    const std::string description = describe_ours(fmt::format(R"(, "--method", "{}")", method));
    const Result result =
        plumb(fmt::format("certify --quick --folder {} --with {} --scene cornell --time 0.1 "
                          "--tolerance 0.001 -o page.html",
                          PLUMB_SCENES, description));
    EXPECT_EQ(result.exit_code, 3) << result.output;
    std::ifstream stream(folder / "page.json");
    return Json::parse(stream);
  };
  const Json naive = noisy("bsdf");
  const auto text = answer(naive, "cornell")["text"].get<std::string>();
  EXPECT_NE(text.find(" times ours"), std::string::npos) << text;
  EXPECT_NE(naive["advice"].get<std::string>().find("next event estimation"), std::string::npos);
  EXPECT_EQ(noisy("mis")["advice"], "");
}

TEST_F(Certify, TheLongestTimeAndAllQuestionsAreTold) {
  const std::string command =
      fmt::format("certify --folder {} --with {} ", PLUMB_SCENES, describe_script("exit 1"));
  const Result limits = plumb(command + "--scene 01_lamp,02_matte_floor --time 90");
  EXPECT_NE(limits.output.find("script has up to 90 s for each of 2 questions (--time), 3 min in "
                               "all; first rounds may take longer, up to 600 s a run"),
            std::string::npos)
      << limits.output;
  const Result names = plumb(command + "--scene '?'");
  EXPECT_EQ(names.exit_code, 2);
  for (const char* name : {"00_corners", "cornell/4:", "veach", "tiny_lamp"}) {
    EXPECT_NE(names.output.find(name), std::string::npos) << names.output;
  }
}

TEST_F(Certify, ASceneIsHeldAgainstItsStoredPicture) {
  const Json right = certify(describe_ours(), "cornell,cornell/0:1", 0, "--tolerance 4");
  EXPECT_EQ(answer(right, "cornell")["mark"], "right");
  EXPECT_EQ(answer(right, "cornell/0:1")["mark"], "right");
  EXPECT_EQ(right["paces"].size(), 2u);  // with ours
  const Json wrong = certify(describe_ours(R"(, "--fault", "five-bounces")"), "cornell,cornell/0:1",
                             1, "--tolerance 4");
  EXPECT_EQ(answer(wrong, "cornell")["mark"], "wrong");
  EXPECT_EQ(answer(wrong, "cornell/0:1")["mark"], "right");
}

TEST_F(Certify, WhatAProgramDoesNotKnowItIsNotAskedFor) {
  const Json certificate =
      certify(describe_ours("", R"(cannot = ["glass", "sky"])"), "01_lamp,10_sky,17_pane", 0);
  EXPECT_EQ(answer(certificate, "10_sky")["mark"], "can't");
  EXPECT_EQ(answer(certificate, "17_pane")["text"], "Ours knows no glass");
}

TEST_F(Certify, AMisbehavingProgramHasFailed) {
  const auto failure = [&](const std::string& script, const std::string& keys = "") {
    const Json certificate = certify(describe_script(script, keys), "01_lamp", 1);
    return answer(certificate, "runs")["text"].get<std::string>();
  };
  const auto expect = [](const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  expect(failure("sleep 60", "time_limit = 0.3"), "took longer than its time limit");
  expect(failure("trap '' TERM; sleep 60", "time_limit = 0.3"), "took longer");
  expect(failure("echo 'Error: no such thing'; exit 3"), "no such thing (exit status 3");
  expect(failure("kill -SEGV $$"), "SIGSEGV");
  expect(failure("true"), "left no picture.exr");
  const std::string small = fmt::format("{} render {}/01_lamp.xml --spp 1 --size 8x8 -o $2",
                                        PLUMB_EXECUTABLE, closed_forms);
  expect(failure(small), "is 8x8, not 16x16");
  std::string pfm = R"(printf 'PF\n16 16\n-1.0\n' > $2; )";
  pfm += R"(for i in $(seq 768); do printf '\000\000\300\177'; done >> $2)";
  expect(failure(pfm, "output = \"pfm\""), "768 values that are infinite or no numbers");
}

TEST_F(Certify, AProgramThatTakesXmlForJsonIsToldOfTheFormat) {
  write("draw.py", "import json, sys\njson.load(open(sys.argv[1]))\nraise ValueError('no more')");
  const auto failure = [&](const std::string& keys) {
    const std::string description = write("draw.toml", R"(
name = "My tracer"
command = ["python3", "{here}/draw.py", "{scene}", "{output}", "{spp}"]
)" + keys);
    const Json certificate = certify(description, "01_lamp", 1);
    return answer(certificate, "runs")["text"].get<std::string>();
  };
  const std::string hint = "its description needs scene = \"json\"";
  const std::string xml = failure(""), json = failure("scene = \"json\"");
  EXPECT_NE(xml.find(hint), std::string::npos) << xml;
  EXPECT_TRUE(xml.starts_with("My tracer: json.decoder.JSONDecodeError")) << xml;
  EXPECT_EQ(json.find(hint), std::string::npos) << json;
  EXPECT_TRUE(json.starts_with("My tracer: ValueError: no more")) << json;
}

TEST_F(Certify, NeighboursThatShareRandomNumbersAreFound) {
  write("draw.py", R"(
import random, struct, sys
output, seed, shared = sys.argv[1], int(sys.argv[2]), float(sys.argv[3])
random.seed(seed)
mean = 0.1 * (1 + shared * random.gauss(0, 1))
with open(output, "wb") as file:
    file.write(b"PF\n16 16\n-1.0\n")
    for pixel in range(256):
        file.write(struct.pack("<3f", *[mean * (1 + 0.1 * random.gauss(0, 1))] * 3))
)");
  const auto noise = [&](const std::string& shared) {
    const std::string description = write("draw.toml", fmt::format(R"(
command = ["python3", "{{here}}/draw.py", "{{output}}", "{{seed}}", "{}", "{{scene}}", "{{spp}}"]
output = "pfm")",
                                                                   shared));
    return answer(certify(description, "02_matte_floor", 1), "honest noise")["mark"];
  };
  EXPECT_EQ(noise("0"), "right");
  EXPECT_EQ(noise("0.1"), "wrong");
}

TEST_F(Certify, ADescriptionIsReadWithItsPlaceInErrors) {
  const auto complaint = [&](const std::string& text) {
    try {
      read_description(write("bad.toml", text));
      return std::string("none");
    } catch (const std::exception& error) {
      return std::string(error.what());
    }
  };
  const auto expect = [](const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  const std::string good = "command = [\"x\", \"{scene}\", \"{output}\"]\n";
  EXPECT_EQ(complaint(good), "none");
  expect(complaint(""), "there is no 'command'");
  expect(complaint(R"(command = ["x", "{scene}"])"), "lacks '{output}'");
  expect(complaint(R"(command = ["x", "{scene}", "{output}", "{samples}"])"),
         "'{samples}' is no placeholder");
  expect(complaint(good + "sceen = \"json\""), "bad.toml:2:9: 'sceen' is no key");
  expect(complaint(good + "scene = \"obj\""), "'scene' must be");
  expect(complaint(good + "cannot = [\"dance\"]"), "'dance' is none of");
  expect(complaint(good + "[picture]\ncolour_space = \"acescg\""), "must be one of");
  expect(complaint(good + "[picture]\nscale = \"big\""), "'scale' must be a number");
  expect(complaint(good + "time_limit ="), "line 2");
}

TEST_F(Certify, TheDescriptionsOfOtherProgramsCanBeRead) {
  const fs::path described = fs::path(PLUMB_SCENES).parent_path() / "other_renderers/described";
  for (const auto& entry : fs::directory_iterator(described)) {
    if (entry.path().extension() != ".toml") continue;
    const OtherRenderer renderer = read_description(entry.path());
    EXPECT_TRUE(renderer.has_samples) << entry.path();
  }
}

TEST_F(Certify, APictureIsTurnedAndDecodedAsTheDescriptionSays) {
  // Written upside down, mirrored, by gamma 2.2 and half as bright: read as it was.
  const std::string scene = PLUMB_SCENES "/cornell/scene.xml";
  const auto draw = [&](const std::string& keys) {
    const std::string file = describe_ours("", keys);
    const Result result = plumb(fmt::format(
        "reference {} --with {} --size 32x32 --spp 16 --seeds 1 --seed 1 -o picture.exr", scene,
        file));
    EXPECT_EQ(result.exit_code, 0) << result.output;
    return read_image(folder / "picture.exr").values;
  };
  const std::vector<float> plain = draw("");
  const std::vector<float> turned = draw("[picture]\nflipped = true\nmirrored = true\nscale = 2");
  ASSERT_EQ(plain.size(), turned.size());
  for (size_t i = 0; i < plain.size() / 3; ++i) {
    for (size_t c = 0; c < 3; ++c) {
      EXPECT_EQ(turned[i * 3 + c], 2.0f * plain[plain.size() - 3 * (i + 1) + c]);
    }
  }
  const std::vector<float> decoded = draw("[picture]\ncolour_space = \"gamma2.2\"");
  for (size_t i = 0; i < plain.size(); ++i) {
    EXPECT_NEAR(decoded[i], std::pow(plain[i], 2.2f), 1e-5f * std::max(1.0f, decoded[i]));
  }
}

TEST_F(Certify, PlainScenesHoldAllNumbersInWorldSpace) {
  const Result result =
      plumb(fmt::format("export {}/cornell/scene.xml --to json -o scene.json", PLUMB_SCENES));
  ASSERT_EQ(result.exit_code, 0) << result.output;
  std::ifstream stream(folder / "scene.json");
  const Json scene = Json::parse(stream);
  EXPECT_EQ(scene["shapes"].size(), 8u);
  const Json& lamp = scene["shapes"].back();
  EXPECT_EQ(lamp["id"], "lamp");
  EXPECT_EQ(lamp["radiance"], Json({17, 12, 4}));
  EXPECT_EQ(lamp["triangles"].size(), 2u);
  for (const Json& triangle : lamp["triangles"]) {
    for (const Json& corner : triangle) EXPECT_NEAR(corner[1], 548.3, 1e-9);
  }
  // The camera looks along +z, so its back is -z; x grows to the left of the picture.
  const Json& camera = scene["camera"];
  EXPECT_NEAR(camera["camera_to_world"][2][2], -1.0, 1e-12);
  EXPECT_NEAR(camera["camera_to_world"][0][0], -1.0, 1e-12);
  EXPECT_NEAR(camera["camera_to_world"][2][3], -800.0, 1e-12);
  EXPECT_GT(camera["corner_rays"]["top_left"][0], 0.0);
  EXPECT_GT(camera["corner_rays"]["top_left"][1], 0.0);
}

}  // namespace
}  // namespace plumb
