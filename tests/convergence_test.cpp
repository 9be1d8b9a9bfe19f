// SPDX-License-Identifier: Apache-2.0

// Whether fits of error against samples hold what their intervals promise, and what a study of
// pictures says. All random numbers have fixed seeds.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "compare/exhibit.h"
#include "compare/power_law.h"
#include "compare/study.h"

namespace plumb {
namespace {

// A series as pictures of `pixels` pixels would give it, with normal noise whose variance falls as
// N^-exponent, all of whose pixels are off by the root of `floor`.
struct Truth {
  const char* name;
  double exponent, floor;
  int counts, runs, pixels;

  std::vector<Observation> series(std::mt19937_64& random) const {
    std::vector<Observation> observations;
    for (int i = 0; i < counts * runs; ++i) {
      const double samples = std::exp2(i / runs);
      const double variance = std::pow(samples, -exponent);
      // The sum of the squares of normal numbers, one of which has all the bias.
      std::gamma_distribution<double> others((pixels - 1) / 2.0, 2.0);
      std::normal_distribution<double> one(std::sqrt(pixels * floor / variance), 1.0);
      const double square = std::pow(one(random), 2.0);
      observations.push_back({samples, (others(random) + square) * variance / pixels});
    }
    return observations;
  }
};

class Coverage : public testing::TestWithParam<Truth> {};

TEST_P(Coverage, IntervalsHoldTheTruthIn95PercentOfAllSeries) {
  constexpr int trials = 2000;
  const Truth& truth = GetParam();
  std::mt19937_64 random(1);
  int exponents = 0;
  int floors = 0;
  for (int i = 0; i < trials; ++i) {
    const PowerLaw law = fit_power_law(truth.series(random));
    exponents += law.exponent.low <= truth.exponent && truth.exponent <= law.exponent.high;
    floors += law.floor.low <= truth.floor && truth.floor <= law.floor.high;
  }
  EXPECT_NEAR(100.0 * exponents / trials, 95.0, 2.0);
  EXPECT_NEAR(100.0 * floors / trials, 95.0, 2.0);
}

INSTANTIATE_TEST_SUITE_P(Fits, Coverage,
                         testing::Values(Truth{"no_floor", 1.0, 0.0, 12, 3, 1000},
                                         Truth{"single_runs", 1.0, 0.0, 7, 1, 1000},
                                         Truth{"hidden_floor", 1.0, 1e-3, 12, 3, 1000},
                                         Truth{"reached_floor", 1.0, 1e-2, 12, 3, 1000},
                                         Truth{"high_floor", 1.0, 3e-2, 12, 3, 200},
                                         Truth{"short_series", 1.0, 1e-1, 8, 2, 1000},
                                         Truth{"steep", 1.3, 0.0, 12, 3, 1000},
                                         Truth{"flat", 0.7, 1e-3, 12, 3, 1000}),
                         [](const auto& test) { return test.param.name; });

TEST(PowerLaw, IsFoundExactlyWithoutNoise) {
  std::vector<Observation> exact;
  for (const double n : {1.0, 4.0, 16.0, 64.0, 256.0}) {
    exact.push_back({n, 0.3 * std::pow(n, -1.2) + 1e-4});
  }
  const PowerLaw law = fit_power_law(exact);
  EXPECT_NEAR(law.scale, 0.3, 1e-5);
  EXPECT_NEAR(law.exponent.value, 1.2, 1e-5);
  EXPECT_NEAR(law.floor.value, 1e-4, 1e-8);
}

TEST(PowerLaw, NeedsThreeCountsAndFourPictures) {
  EXPECT_THROW(fit_power_law({{1, 1}, {2, 0.5}, {4, 0.25}}), std::invalid_argument);
  EXPECT_THROW(fit_power_law({{1, 1}, {1, 1.1}, {2, 0.5}, {2, 0.6}}), std::invalid_argument);
  EXPECT_NO_THROW(fit_power_law({{1, 1}, {1, 1.1}, {2, 0.5}, {4, 0.2}}));
}

TEST(PowerLaw, NeedsErrorsThatTellSomething) {
  EXPECT_THROW(fit_power_law({{1, 1}, {2, 1}, {4, 1}, {8, 1}}), std::invalid_argument);
  EXPECT_THROW(fit_power_law({{1, 1}, {2, 0.5}, {4, 0.2}, {8, 0}}), std::invalid_argument);
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(fit_power_law({{1, 1}, {2, 0.5}, {4, unknown}, {8, 0.2}}), std::invalid_argument);
}

TEST(PowerLaw, HasNoTroubleWithErrorsThatRise) {
  const PowerLaw law = fit_power_law({{1, 1}, {1, 1.1}, {2, 1.3}, {4, 1.2}, {8, 1.6}});
  EXPECT_TRUE(std::isfinite(law.exponent.low) && std::isfinite(law.floor.high));
}

// Grey pictures of 64 x 64 pixels, mean 1, with normal noise.
class Pictures {
 public:
  // Their claimed variance is right; without noise there is none to claim.
  Picture draw(double bias, double variance) {
    std::normal_distribution<double> noise(1.0 + bias, std::sqrt(variance));
    Image image{64, 64, {"R", "G", "B", "variance.R", "variance.G", "variance.B"}, {}, {}};
    for (int pixel = 0; pixel < 64 * 64; ++pixel) {
      for (int c = 0; c < 3; ++c) image.values.push_back(static_cast<float>(noise(random_)));
      image.values.insert(image.values.end(), 3, static_cast<float>(variance));
    }
    return to_picture("picture", std::move(image));
  }

 private:
  std::mt19937_64 random_{1};
};

// Renders with 1 to 1024 samples, three of each.
void add_series(Study& study, Pictures& pictures, const std::string& name, double bias) {
  for (double samples = 1.0; samples <= 1024.0; samples *= 2.0) {
    for (int run = 0; run < 3; ++run) {
      study.add(pictures.draw(bias, 0.01 / samples), {name, "", samples, 0.001 * samples, 0.0});
    }
  }
}

TEST(Study, TellsNoiseFromBias) {
  Pictures pictures;
  Study study(pictures.draw(0.0, 1e-6));
  add_series(study, pictures, "right", 0.0);
  add_series(study, pictures, "wrong", 0.01);
  const auto series = study.series();
  const Convergence right = study.convergence(series[0], 3);
  EXPECT_NEAR(right.law.exponent.value, 1.0, 0.01);
  EXPECT_FALSE(right.stops);
  EXPECT_LT(right.bias.high, 0.002);
  const Convergence wrong = study.convergence(series[1], 3);
  EXPECT_TRUE(wrong.stops);
  EXPECT_NEAR(wrong.bias.value, 0.01 / std::sqrt(1.01), 1e-4);  // relMSE adds 0.01 below
}

TEST(Study, SubtractsTheReferencesNoise) {
  Pictures pictures;
  Study study(pictures.draw(0.0, 1e-4));  // ten times that of the best render
  add_series(study, pictures, "right", 0.0);
  const auto series = study.series();
  EXPECT_NEAR(study.reference_noise().back(), 1e-4 / 1.01, 1e-6);
  EXPECT_NEAR(study.convergence(series[0], 3).law.exponent.value, 1.0, 0.02);
  EXPECT_FALSE(study.convergence(series[0], 3).stops);
  const Exhibit exhibit = convergence(study);
  EXPECT_NE(to_text(exhibit).find("the reference is noisier than the picture"), std::string::npos);
}

// By our program: its samples, and their seed.
Picture drawn(Picture picture, int seed, const std::string& samples) {
  picture.image.provenance = {.renderer = "plumbline",
                              .scene_hash = "a",
                              .sampler = "sobol",
                              .seed = seed,
                              .samples = samples};
  return picture;
}

TEST(Study, LeavesOutWhatSharesSamplesWithTheReference) {
  Pictures pictures;
  const Picture reference = drawn(pictures.draw(0.0, 1e-4), 7, "0:1024");
  Study study(reference);
  const auto is_taken = [&](const Picture& picture) {
    const size_t before = study.left_out().size();
    study.add(picture, {"any", "", 0.0, 0.0, 0.0, "a.exr"});
    return study.left_out().size() == before;
  };
  const auto other = [&] { return pictures.draw(0.0, 1e-2); };
  EXPECT_FALSE(is_taken(reference));
  EXPECT_EQ(study.left_out().back(),
            "a.exr: left out, as it has the same pixels as the reference.");
  Picture copy = reference;
  copy.image.provenance = {};
  EXPECT_FALSE(is_taken(copy));
  EXPECT_FALSE(is_taken(drawn(other(), 7, "0:64")));
  EXPECT_FALSE(is_taken(drawn(other(), 7, "1000:1100")));
  EXPECT_EQ(study.left_out().back(), "a.exr: left out, as it shares samples with the reference.");
  EXPECT_TRUE(is_taken(drawn(other(), 7, "1024:1088")));
  EXPECT_TRUE(is_taken(drawn(other(), 8, "0:64")));
  EXPECT_TRUE(is_taken(other()));
  EXPECT_EQ(study.series().front().renders.size(), 3U);
}

// Another program's replicates have a seed each.
TEST(Study, LeavesOutWhatSharesASeedWithAnotherProgramsReference) {
  Pictures pictures;
  const auto theirs = [&](int seed, int replicates) {
    Picture picture = drawn(pictures.draw(0.0, 1e-4), seed, "0:64");
    picture.image.provenance.sampler.reset();
    picture.image.provenance.replicates = replicates;
    return picture;
  };
  Study study(theirs(1, 8));
  for (const auto& [seed, replicates] : {std::pair{8, 1}, {9, 1}, {5, 8}}) {
    study.add(theirs(seed, replicates), {"theirs", "", 0.0, 0.0, 0.0});
  }
  EXPECT_EQ(study.left_out().size(), 2U);
}

// Quasi-random samples' error falls ever less fast, until it falls as 1 / N.
TEST(Study, TakesSlowingDownForNoFloor) {
  Pictures pictures;
  Study study(pictures.draw(0.0, 1e-8));
  for (double samples = 1.0; samples <= 1024.0; samples *= 2.0) {
    const double variance = 0.001 / samples + 0.01 * std::pow(samples, -1.5);
    for (int run = 0; run < 3; ++run) {
      study.add(pictures.draw(0.0, variance), {"sobol", "", samples, 0.0, 0.0});
    }
  }
  const Convergence convergence = study.convergence(study.series()[0], 3);
  EXPECT_FALSE(convergence.stops);
  EXPECT_GT(convergence.law.exponent.low, 1.2);
}

TEST(Chart, SaysHowLongAnErrorTakes) {
  Pictures pictures;
  Study study(pictures.draw(0.0, 1e-8));
  add_series(study, pictures, "right", 0.0);    // relative error 1 % at 100 spp, in 0.1 s
  add_series(study, pictures, "biased", 0.03);  // never
  const Exhibit exhibit = speed_and_accuracy(study);
  ASSERT_EQ(exhibit.rows.size(), 2U);
  EXPECT_NEAR(std::stod(exhibit.rows[0][4]), 0.1 / 1.01, 0.003);
  EXPECT_EQ(exhibit.rows[0][6].substr(0, 3), "~9.");  // a hundred times as long, not measured
  EXPECT_EQ(exhibit.rows[1][4], "never");
}

TEST(Chart, SaysWhichSeriesCantBeFittedAndShowsTheOthers) {
  Pictures pictures;
  Study study(pictures.draw(0.0, 1e-8));
  const Picture stubborn = pictures.draw(0.03, 1e-3);
  for (double samples = 1.0; samples <= 8.0; samples *= 2.0) {
    study.add(stubborn, {"stubborn", "", samples, samples, 0.0});
  }
  study.add(pictures.draw(0.0, 1e-2), {"lonely", "", 1, 1.0, 0.0});
  add_series(study, pictures, "right", 0.0);
  for (const Exhibit& exhibit : {speed_and_accuracy(study), convergence(study)}) {
    const std::string text = to_text(exhibit);
    EXPECT_NE(text.find("stubborn: its error is the same with any number"), std::string::npos);
    EXPECT_NE(text.find("lonely: a fit needs four pictures"), std::string::npos);
    EXPECT_EQ(text.find("nan"), std::string::npos) << text;
    EXPECT_EQ(exhibit.rows.back()[0], "right");
    EXPECT_EQ(exhibit.plot.curves.size(), 3U);
  }
}

TEST(Chart, MarksThePointsThanWhichNoneIsFasterAndMoreAccurate) {
  Pictures pictures;
  Study study(pictures.draw(0.0, 1e-8));
  study.add(pictures.draw(0.0, 1e-2), {"fast", "", 1, 1.0, 0.0});
  study.add(pictures.draw(0.0, 1e-2), {"slow", "", 1, 9.0, 0.0});
  study.add(pictures.draw(0.0, 1e-4), {"good", "", 9, 5.0, 0.0});
  const Exhibit exhibit = speed_and_accuracy(study);
  ASSERT_EQ(exhibit.plot.front.size(), 2U);
  EXPECT_EQ(exhibit.plot.front[0].x, 1.0);
  EXPECT_EQ(exhibit.plot.front[1].x, 5.0);
}

TEST(Chart, TakesTheMedianOfTheRunsSeconds) {
  Pictures pictures;
  Study study(pictures.draw(0.0, 1e-8));
  for (const double seconds : {1.0, 9.0, 2.0}) {
    study.add(pictures.draw(0.0, 1e-2), {"renderer", "", 1, seconds, 0.0});
  }
  EXPECT_EQ(study.series()[0].points[0].label.seconds, 2.0);
}

}  // namespace
}  // namespace plumb
