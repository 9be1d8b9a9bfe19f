// SPDX-License-Identifier: Apache-2.0

// When a trial holds, and when it is noisy, biased or broken.
#include "compare/assessment.h"

#include <gtest/gtest.h>

#include <cmath>

namespace plumb {
namespace {

class Assess : public testing::Test {
 protected:
  // A picture of 16 x 16 pixels of radiance 1, with one that is `first`.
  static Trial trial(float first, float variance, double samples) {
    Image image{16, 16, {"R", "G", "B", "variance.R", "variance.G", "variance.B"}, {}, {}};
    for (int i = 0; i < 256; ++i) {
      const float value = i == 0 ? first : 1.0F;
      image.values.insert(image.values.end(), {value, value, value, variance, variance, variance});
    }
    return {.picture = {.side = "test", .image = image, .degrees_of_freedom = 3},
            .program = "",
            .seconds = 1.0,
            .samples = samples,
            .brightest = 1.0,
            .tail = {}};
  }

  static Picture truth(float radiance) {
    Image image{16, 16, {"R", "G", "B"}, {}, {}};
    image.values.assign(16 * 16 * 3, radiance);
    return {.side = "reference", .image = image};
  }
};

TEST_F(Assess, TellsBiasFromNoise) {
  const float variance = 1e-4F;  // of a pixel; 6e-4 of the mean
  EXPECT_EQ(assess(trial(1.0F, variance, 1e9), truth(1.0F), 1e-3).outcome, Outcome::holds);
  EXPECT_EQ(assess(trial(1.0F, variance, 1e9), truth(1.001F), 1e-3).outcome, Outcome::holds);
  EXPECT_EQ(assess(trial(1.0F, variance, 1e9), truth(1.01F), 1e-3).outcome, Outcome::biased);
  EXPECT_EQ(assess(trial(1.0F, variance, 1e9), truth(0.99F), 1e-3).outcome, Outcome::biased);
}

TEST_F(Assess, SeesABiasOfOneBlock) {
  EXPECT_EQ(assess(trial(2.0F, 1e-6F, 1e9), truth(1.0F), 1e-3).outcome, Outcome::biased);
}

TEST_F(Assess, AllowsForBrightSamplesThatWereNotMet) {
  EXPECT_EQ(assess(trial(1.0F, 0.0F, 1e4), truth(1.001F), 1e-3).outcome, Outcome::holds);
  EXPECT_EQ(assess(trial(1.0F, 0.0F, 1e9), truth(1.001F), 1e-3).outcome, Outcome::biased);
  EXPECT_EQ(assess(trial(1.0F, 0.0F, 1e4), truth(0.999F), 1e-3).outcome, Outcome::biased)
      << "what is too bright has been met";
}

TEST_F(Assess, BreaksOnWhatIsNotFinite) {
  EXPECT_EQ(assess(trial(std::nanf(""), 1e-4F, 1e9), truth(1.0F), 1e-3).outcome, Outcome::breaks);
  Trial unfit = trial(1.0F, 1e-4F, 1e9);
  unfit.tail = SampleTail{.unfit = 1};
  EXPECT_EQ(assess(unfit, truth(1.0F), 1e-3).outcome, Outcome::breaks);
}

// Two pixels of mean 1, whose samples are 0 or 2, but for one firefly in a thousand.
TEST(SampleTail, TellsFirefliesFromEvenScatter) {
  SampleTailEstimator even({1, 1, 1, 1, 1, 1});
  for (int i = 0; i < 500; ++i) even.add({0, 0, 0, 2, 2, 2});
  EXPECT_DOUBLE_EQ(even.estimate().kurtosis, 1.0);
  EXPECT_DOUBLE_EQ(even.estimate().fireflies, 0.001);
  SampleTailEstimator uneven({1, 1, 1, 1, 1, 1});
  for (int i = 0; i < 499; ++i) uneven.add({0, 0, 0, 2, 2, 2});
  uneven.add({0, 0, 0, 101, 101, 101});
  const SampleTail tail = uneven.estimate();
  EXPECT_DOUBLE_EQ(tail.fireflies, 10000.0 / 10999.0);
  EXPECT_EQ(tail.brightest, 101.0);
  EXPECT_EQ(tail.unfit, 0);
  uneven.add({-1, 0, 0, std::nanf(""), 2, 2});
  EXPECT_EQ(uneven.estimate().unfit, 2);
}

}  // namespace
}  // namespace plumb
