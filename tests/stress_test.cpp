// SPDX-License-Identifier: Apache-2.0

// The stress scenes can be read and tried, and double-precision pictures of those with a closed
// form meet it.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "cli/trial.h"
#include "scene_files/precision.h"
#include "tests/test_scenes.h"

namespace plumb::cli {
namespace {

namespace fs = std::filesystem;

const fs::path folder = PLUMB_SCENES "/stress";
const std::atomic<bool> never{false};
constexpr Method methods[] = {Method::bsdf, Method::nee, Method::mis};

std::vector<StressScene> scenes() {
  std::vector<StressScene> all;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".xml") all.emplace_back(entry.path());
  }
  return all;
}

// Paths of a thousand bounces are followed for fewer samples.
int64_t few_samples(const StressScene& stress) {
  const std::string& name = stress.scene.name;
  const bool is_long = name == "needle" || name == "white_opening" || name == "long_paths";
  return is_long ? 16 : 256;
}

// No false alarms: seeds are fixed, and the samples' number doesn't depend on time.
TEST(Stress, NoMethodIsBiasedInDoubleNorInFloatUnlessThatIsSaid) {
  const auto all = scenes();
  ASSERT_GE(all.size(), 33U);
  for (const StressScene& stress : all) {
    const Limits limits{.samples = {0, few_samples(stress)}};
    const Picture truth = stress.find_truth(limits, never);
    for (const Method method : methods) {
      for (const Precision precision : {Precision::float32, Precision::float64}) {
        if (precision == Precision::float32 && stress.beyond_float) continue;
        const Settings settings{.method = method, .precision = precision, .seed = 1, .bounces = {}};
        const auto trial = try_method(stress.scene, settings, limits, never);
        ASSERT_TRUE(trial.has_value());
        const Assessment assessment = assess(*trial, truth, 1e-6);
        EXPECT_TRUE(assessment.is_right())
            << stress.scene.name << ", method " << int(method) << ", precision " << int(precision)
            << ": " << 100.0 * assessment.bias << " % +- " << 100.0 * assessment.error;
      }
    }
  }
}

// Without the allowance for samples that have not been met, which bsdf needs for tiny lamps.
TEST(Stress, ClosedFormsAreMetInDoubleWithinFiveStandardErrors) {
  for (const StressScene& stress : scenes()) {
    if (stress.oracle != Oracle::radiance) continue;
    for (const Method method : {Method::nee, Method::mis}) {
      const Settings settings{
          .method = method, .precision = Precision::float64, .seed = 2, .bounces = {}};
      const auto m =
          test::measure(test::render_film(stress.scene, settings, {0, 4 * few_samples(stress)}));
      const double radiance = std::stod(stress.value);
      EXPECT_NEAR(m.mean, radiance, 5.0 * m.standard_error + 1e-5 * radiance)
          << stress.scene.name << ", method " << int(method);
    }
  }
}

TEST(Stress, WhatIsSaidToBeBeyondFloatIsRenderedInDoubleByDefault) {
  for (const StressScene& stress : scenes()) {
    EXPECT_EQ(!needs_double(stress.scene).empty(), stress.beyond_float) << stress.scene.name;
  }
}

TEST(StressCommand, PrintsATableAndExitsWithZero) {
  const std::string command =
      PLUMB_EXECUTABLE " stress --folder " PLUMB_SCENES
                       "/stress --scene slit,edge_pixel --methods mis,default --spp 64 2>&1";
  FILE* pipe = popen(command.c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  std::string out;
  for (int c = 0; (c = fgetc(pipe)) != EOF;) out += static_cast<char>(c);
  EXPECT_EQ(pclose(pipe), 0) << out;
  for (const char* row :
       {"| slit | mis float |", "| edge_pixel | mis double |", "| slit | default |",
        "\n\n| scene | mis float | mis double | default |\n|---|---|---|---|\n| slit | ",
        "\n| edge_pixel | holds | holds | holds |\n"}) {
    EXPECT_NE(out.find(row), std::string::npos) << out;
  }
}

}  // namespace
}  // namespace plumb::cli
