// SPDX-License-Identifier: Apache-2.0

// What may be relied on when two pictures are compared. The pictures are made of numbers here:
// pixels with normal, skewed or rare noise, whose variances come from four replicates, as the
// renderer's do.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "compare/comparison.h"
#include "compare/markdown.h"
#include "compare/report.h"

namespace plumb {
namespace {

using Random = std::mt19937_64;
using Truth = std::function<double(int x, int y)>;
using Noise = std::function<double(Random&)>;  // a sample's noise, mean 0

constexpr int side = 64;

double normal(Random& random) { return std::normal_distribution(0.0, 0.5)(random); }

// One sample in a thousand meets a lamp: skewed noise, of which most pixels see nothing.
double firefly(Random& random) {
  return 0.1 * (std::bernoulli_distribution(0.001)(random) ? 999.0 : -1.0);
}

double uniform_truth(int, int) { return 1.0; }

// A picture with the same truth in three channels.
Picture render(uint64_t seed, int samples, const Truth& truth = uniform_truth,
               const Noise& noise = normal) {
  Random random(seed);
  Picture picture{"test",
                  {side, side, {"R", "G", "B", "variance.R", "variance.G", "variance.B"}, {}, {}},
                  {},
                  {},
                  {}};
  picture.degrees_of_freedom = 3;
  picture.image.provenance = {.samples = "0:" + std::to_string(samples)};
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      double mean = 0.0;
      double squares = 0.0;
      for (int replicate = 0; replicate < 4; ++replicate) {
        const int count = samples / 4;
        double sum = 0.0;
        for (int s = 0; s < count; ++s) sum += noise(random);
        const double value = sum / count;
        mean += value / 4;
        squares += value * value;
      }
      const double variance = (squares - 4 * mean * mean) / 12;
      for (int c = 0; c < 3; ++c) picture.image.values.push_back(float(truth(x, y) + mean));
      for (int c = 0; c < 3; ++c) picture.image.values.push_back(float(variance));
    }
  }
  return picture;
}

// Says that the picture was drawn with this seed, by our program.
Picture drawn(uint64_t seed, Picture picture) {
  picture.image.provenance.sampler = "independent";
  picture.image.provenance.seed = static_cast<int>(seed);
  return picture;
}

// Without noise, and without a word about it.
Picture exact(const Truth& truth) {
  Picture picture{"test", {side, side, {"R", "G", "B"}, {}, {}}, {}, {}, {}};
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x)
      picture.image.values.insert(picture.image.values.end(), 3, float(truth(x, y)));
  }
  return picture;
}

Comparison judge(Picture test, Picture reference, const Judgement& judgement = {},
                 const Regions& regions = {}) {
  const auto channels = match(test, reference, {}, true);
  return compare(test, reference, channels, {0, 0, side, side}, regions, judgement);
}

Judgement tolerating(double relative) {
  Judgement judgement;
  judgement.tolerance = {relative, true};
  return judgement;
}

const Level& level(const Comparison& comparison, Unit unit) {
  for (const Level& level : comparison.levels) {
    if (level.unit == unit) return level;
  }
  throw std::out_of_range(to_string(unit));
}

// The errors

TEST(Errors, FollowTheirFormulas) {
  Picture test{"test", {2, 1, {"Y"}, {1.5F, 0.0F}, {}}, {}, {}, {}};
  Picture reference{"reference", {2, 1, {"Y"}, {1.0F, 3.0F}, {}}, {}, {}, {}};
  match(test, reference, {}, false);
  const Comparison comparison = compare(test, reference, {"Y"}, {0, 0, 2, 1}, {}, {});
  const Errors& e = comparison.errors[0];
  EXPECT_DOUBLE_EQ(comparison.image[0].estimate.difference, -1.25);
  EXPECT_DOUBLE_EQ(e.mae, (0.5 + 3) / 2);
  EXPECT_DOUBLE_EQ(e.mse, (0.25 + 9) / 2);
  EXPECT_DOUBLE_EQ(e.rel_mse, (0.25 / 1.01 + 9 / 9.01) / 2);
  EXPECT_DOUBLE_EQ(e.smape, (2 * 0.5 / 2.51 + 2 * 3 / 3.01) / 2);
  EXPECT_DOUBLE_EQ(e.psnr(), 10 * std::log10(9 / e.mse));
  EXPECT_EQ(e.x, 1);
  EXPECT_EQ(e.max_test, 0.0);
  EXPECT_EQ(e.max_reference, 3.0);
}

TEST(Errors, SquaredErrorIsBiasAndNoise) {
  const Comparison comparison = judge(render(1, 16, [](int, int) { return 1.05; }), render(2, 64));
  const Errors& e = comparison.errors[3];
  // A pixel's mean has the variance 0.25 / samples. The mean of 4096 pixels' squares scatters by
  // sqrt(2 / 4096) = 2.2 % of it, that of their variances by sqrt(2 / 3 / 4096) = 1.3 %.
  EXPECT_NEAR(e.bias_squared, 0.05 * 0.05, 0.05 * 2 * 4 * std::sqrt(0.25 * 5 / 64 / 4096));
  EXPECT_NEAR(e.test_noise, 0.25 / 16, 0.05 * 0.25 / 16);
  EXPECT_NEAR(e.reference_noise, 0.25 / 64, 0.05 * 0.25 / 64);
  EXPECT_NEAR(e.mse, e.bias_squared + e.test_noise + e.reference_noise, 0.1 * e.mse);
}

TEST(Errors, NintyFivePercentIntervalsHoldTheTruthInNinetyFivePercent) {
  int held = 0;
  for (uint64_t pair = 0; pair < 200; ++pair) {
    const Estimate e = judge(render(2 * pair, 4), render(2 * pair + 1, 8)).image[0].estimate;
    held += std::abs(e.difference) < e.confidence;
  }
  EXPECT_NEAR(held, 190, 3.5 * std::sqrt(200 * 0.95 * 0.05));
}

// The verdict

TEST(CriticalValue, BoundsSumsOfRandomSigns) {
  // P(|sum of n signs| > c sqrt(n)), exactly, by counting.
  for (const int n : {2, 10, 50, 64}) {
    for (const double false_alarm : {0.1, 1e-3, 1e-9}) {
      const double c = critical_value(false_alarm, 1);
      double tail = 0.0;
      for (int plus = 0; plus <= n; ++plus) {
        if (std::abs(2 * plus - n) <= c * std::sqrt(n)) continue;
        tail += std::exp(std::lgamma(n + 1) - std::lgamma(plus + 1) - std::lgamma(n - plus + 1) -
                         n * std::log(2));
      }
      EXPECT_LE(tail, false_alarm) << n;
    }
  }
  EXPECT_NEAR(critical_value(1e-3, 100), critical_value(1e-5, 1), 1e-9);
}

// At the default level, one alarm in a thousand pairs: among 240 a third one is seen with a
// probability of 0.002. With tolerance 0, the hardest.
TEST(Verdict, HonestNoiseOfAnyShapeIsNotDifferent) {
  int alarms = 0;
  for (uint64_t pair = 0; pair < 240; ++pair) {
    const Noise& noise = pair % 2 == 0 ? Noise(normal) : Noise(firefly);
    const int samples = pair % 3 == 0 ? 4 : pair % 3 == 1 ? 16 : 64;
    const auto comparison = judge(
        render(2 * pair, samples, uniform_truth, noise),
        render(2 * pair + 1, pair % 5 == 0 ? 256 : samples, uniform_truth, noise), tolerating(0));
    alarms += comparison.verdict == Verdict::different;
  }
  EXPECT_LE(alarms, 2);
}

// Half of the pixels are edges, whose replicates often agree by chance and so claim no noise.
TEST(Verdict, AgreeingReplicatesAreNoProofOfPrecision) {
  const Noise coin = [](Random& random) { return std::bernoulli_distribution(0.5)(random) - 0.5; };
  for (uint64_t pair = 0; pair < 40; ++pair) {
    const auto comparison = judge(render(2 * pair, 4, uniform_truth, coin),
                                  render(2 * pair + 1, 256, uniform_truth, coin), tolerating(0));
    EXPECT_NE(comparison.verdict, Verdict::different);
  }
}

TEST(Verdict, IsSameWithinTheToleranceDifferentBeyondElseInconclusive) {
  // The image's mean has a standard error of 0.5 sqrt(2 / 64) / 64 = 0.14 %.
  const Picture reference = render(1, 64);
  const auto verdict = [&](double mean, double tolerance) {
    return judge(render(2, 64, [=](int, int) { return mean; }), reference, tolerating(tolerance))
        .verdict;
  };
  EXPECT_EQ(verdict(1.0, 0.02), Verdict::same);
  EXPECT_EQ(verdict(1.01, 0.02), Verdict::same);
  EXPECT_EQ(verdict(1.02, 0.02), Verdict::inconclusive);
  EXPECT_EQ(verdict(1.03, 0.02), Verdict::different);
  EXPECT_EQ(verdict(0.97, 0.02), Verdict::different);
  EXPECT_EQ(verdict(1.0, 0.001), Verdict::inconclusive);
  EXPECT_EQ(verdict(1.01, 0.001), Verdict::different);
}

// A picture of 4 samples that all miss what the 64 of the reference meet would claim no noise.
TEST(Verdict, FewSamplesAreInconclusiveWhereMoreAreDifferent) {
  const auto verdict = [](int test, int reference) {
    return judge(render(1, test, [](int, int) { return 1.5; }), render(2, reference)).verdict;
  };
  EXPECT_EQ(verdict(16, 64), Verdict::different);
  EXPECT_EQ(verdict(12, 64), Verdict::inconclusive);
  EXPECT_EQ(verdict(64, 12), Verdict::inconclusive);
  EXPECT_EQ(
      judge(drawn(1, render(1, 4, [](int, int) { return 1.5; })), drawn(1, render(1, 4))).verdict,
      Verdict::different);
}

TEST(Replicates, AreNoMoreThanTheSamples) {
  for (const auto& [samples, freedom] :
       {std::pair{"0:2", 1}, {"5:8", 2}, {"0:4", 3}, {"0:64", 3}}) {
    Image image{1, 1, {"Y"}, {1}, {.samples = samples, .replicates = 4}};
    EXPECT_EQ(to_picture("test", std::move(image)).degrees_of_freedom, freedom) << samples;
  }
}

TEST(Verdict, SaysHowManySamplesWouldDecide) {
  const auto compare_with = [](int samples) {
    return judge(render(3, samples), render(4, samples), tolerating(0.01));
  };
  const Comparison few = compare_with(16);
  ASSERT_EQ(few.verdict, Verdict::inconclusive);
  EXPECT_GT(few.samples_factor, 1.0);
  const int enough = 4 * int(std::ceil(16 * few.samples_factor / 4));
  EXPECT_EQ(compare_with(enough).verdict, Verdict::same);
  EXPECT_EQ(compare_with(enough).samples_factor, 1.0);
}

TEST(Verdict, BiasThatItClaimsToSeeIsSeen) {
  const double visible =
      level(judge(render(1, 16), render(2, 16), tolerating(0.01)), Unit::image).visible;
  int seen = 0;
  for (uint64_t pair = 10; pair < 50; ++pair) {
    const auto comparison = judge(render(2 * pair, 16, [=](int, int) { return 1 + visible; }),
                                  render(2 * pair + 1, 16), tolerating(0.01));
    seen += level(comparison, Unit::image).different > 0;
  }
  EXPECT_GE(seen, 34);  // of 40, with 95 % each: fewer in 1 % of all cases
}

TEST(Verdict, TellsNoPercentageAboveAll) {
  Comparison comparison = judge(render(1, 16), render(2, 16), tolerating(0.01));
  for (Level& l : comparison.levels) {
    l.visible = l.unit == Unit::image   ? 0.12
                : l.unit == Unit::block ? 5.78
                                        : std::numeric_limits<double>::infinity();
  }
  const std::string text = explain(comparison, {});
  EXPECT_NE(text.find("found: 12 % of the image, more than all of a typical block, nothing of a "
                      "typical pixel."),
            std::string::npos)
      << text;
}

// Shared samples

TEST(EqualPixels, AreTheSameAtAnyTolerance) {
  for (const double tolerance : {0.0, 0.001}) {
    for (const bool is_known : {false, true}) {
      const auto picture = [&] { return is_known ? drawn(1, render(1, 16)) : render(1, 16); };
      const auto comparison = judge(picture(), picture(), tolerating(tolerance));
      EXPECT_EQ(comparison.verdict, Verdict::same);
      EXPECT_EQ(comparison.is_paired, is_known);
      EXPECT_EQ(level(comparison, Unit::image).visible, tolerance);
    }
  }
}

TEST(EqualPixels, AreTheSameWhateverTheFloor) {
  Judgement judgement = tolerating(0.001);
  judgement.floor = Amount{0.003, true};
  EXPECT_EQ(judge(render(1, 16), render(1, 16), judgement).verdict, Verdict::same);
}

// A factor of 0.1 % on every sample, of which two renders with other seeds would need 0.5^2 2 / 16
// / 4096 / (0.001 / 4.5)^2 = 150 times as many.
TEST(Paired, SeesAFactorOfAThousandthWithSixteenSamples) {
  Picture brighter = drawn(1, render(1, 16));
  for (float& value : brighter.image.values) value *= 1.001F;
  const Picture reference = drawn(1, render(1, 16));
  for (const auto& [tolerance, verdict] : {std::pair{0.0, Verdict::different},
                                           {0.0009, Verdict::different},
                                           {0.0011, Verdict::same}}) {
    const auto comparison = judge(brighter, reference, tolerating(tolerance));
    EXPECT_TRUE(comparison.is_paired);
    EXPECT_EQ(comparison.verdict, verdict) << tolerance;
    // The scatter is that of 0.001 times a pixel.
    EXPECT_NEAR(comparison.image[0].estimate.standard_error, 0.001 * 0.125 / side,
                0.1 * 0.001 * 0.125 / side);
  }
  EXPECT_EQ(judge(brighter, drawn(2, render(2, 16)), tolerating(0.0009)).verdict,
            Verdict::inconclusive);
}

TEST(Paired, SeesAFaultInARegionWhereItIs) {
  const Truth fault = [](int x, int y) { return x / 8 == 3 && y / 8 == 5 ? 1.001 : 1.0; };
  const auto comparison =
      judge(drawn(1, render(1, 16, fault)), drawn(1, render(1, 16)), tolerating(0));
  EXPECT_EQ(comparison.verdict, Verdict::different);
  const Level& blocks = level(comparison, Unit::block);
  EXPECT_EQ(blocks.different, 1);
  EXPECT_EQ(blocks.worst.front().window.x, 24);
  EXPECT_EQ(blocks.worst.front().window.y, 40);
}

TEST(Paired, TakesRoundingForTheSame) {
  for (uint64_t seed = 0; seed < 40; ++seed) {
    Random random(seed + 1000);
    Picture rounded = drawn(seed, render(seed, 16));
    for (float& value : rounded.image.values) {
      value *= 1.0F + float(std::uniform_int_distribution(-1, 1)(random)) * 1.2e-7F;
    }
    const Picture reference = drawn(seed, render(seed, 16));
    EXPECT_EQ(judge(rounded, reference, tolerating(1e-7)).verdict, Verdict::same);
  }
}

// Rounding sends one path in a hundred another way, in either version: the differences are rare and
// large, and as likely up as down. As with other seeds, a third alarm has a probability of 0.002.
TEST(Paired, PathsThatGoAnotherWayAreNoDifference) {
  int alarms = 0;
  for (uint64_t seed = 0; seed < 240; ++seed) {
    const Noise& noise = seed % 2 == 0 ? Noise(normal) : Noise(firefly);
    const int samples = seed % 3 == 0 ? 4 : seed % 3 == 1 ? 16 : 64;
    const auto version = [&](uint64_t number) {
      Random own(1000 * seed + number);
      return drawn(seed, render(seed, samples, uniform_truth, [&](Random& shared) {
                     const double value = noise(shared);
                     return std::bernoulli_distribution(0.01)(own) ? noise(own) : value;
                   }));
    };
    alarms += judge(version(1), version(2), tolerating(0)).verdict == Verdict::different;
  }
  EXPECT_LE(alarms, 2);
}

TEST(Paired, AreOnlyPicturesOfTheSameSamples) {
  const auto is_paired = [](auto change) {
    Picture test = drawn(1, render(1, 16));
    change(test.image.provenance);
    return judge(test, drawn(1, render(1, 16)), {}).is_paired;
  };
  EXPECT_TRUE(is_paired([](Provenance&) {}));
  EXPECT_TRUE(is_paired([](Provenance& made) { made.version = "another"; }));
  EXPECT_TRUE(is_paired([](Provenance& made) { made.precision = "double"; }));
  EXPECT_FALSE(is_paired([](Provenance& made) { made.seed = 2; }));
  EXPECT_FALSE(is_paired([](Provenance& made) { made.seed.reset(); }));
  EXPECT_FALSE(is_paired([](Provenance& made) { made.samples = "0:17"; }));
  EXPECT_FALSE(is_paired([](Provenance& made) { made.sampler = "sobol"; }));
  EXPECT_FALSE(is_paired([](Provenance& made) { made.method = "bsdf"; }));
}

// Places

TEST(Places, BrighterBlockIsFoundWhereItIs) {
  const auto comparison =
      judge(render(1, 64, [](int x, int y) { return x / 8 == 3 && y / 8 == 5 ? 1.2 : 1.0; }),
            render(2, 64));
  EXPECT_EQ(comparison.verdict, Verdict::different);
  const Level& blocks = level(comparison, Unit::block);
  EXPECT_EQ(blocks.different, 1);
  EXPECT_EQ(blocks.units, 64);
  EXPECT_EQ(blocks.worst.front().window.x, 24);
  EXPECT_EQ(blocks.worst.front().window.y, 40);
}

TEST(Places, SpotIsFoundWhereItIs) {
  const auto comparison =
      judge(render(1, 64, [](int x, int y) { return x / 3 == 7 && y / 3 == 5 ? 3.0 : 1.0; }),
            render(2, 64));
  EXPECT_EQ(comparison.verdict, Verdict::different);
  const Level& pixels = level(comparison, Unit::pixel);
  EXPECT_EQ(pixels.different, 9);
  EXPECT_EQ(pixels.worst.front().window.x / 3, 7);
  EXPECT_EQ(pixels.worst.front().window.y / 3, 5);
}

// A sun beside a landscape: nine pixels make almost all of the mean.
Truth beside_a_sun(const Truth& land) {
  return [=](int x, int y) { return x < 3 && y < 3 ? 50'000.0 : land(x, y); };
}

TEST(Tolerance, IsRelativeToEachPixelSoThatABrightThingHidesNothing) {
  const Picture sun = exact(beside_a_sun([](int x, int) { return 0.2 + 0.01 * x; }));
  const auto black = judge(exact(beside_a_sun([](int, int) { return 0.0; })), sun);
  EXPECT_EQ(black.verdict, Verdict::different);
  EXPECT_EQ(level(black, Unit::pixel).different, side * side - 9);
  EXPECT_EQ(level(black, Unit::image).different, 0);
  const auto darker = [](double factor) {
    return exact(beside_a_sun([=](int x, int) { return factor * (0.2 + 0.01 * x); }));
  };
  EXPECT_EQ(judge(darker(0.991), sun).verdict, Verdict::same);
  EXPECT_EQ(judge(darker(0.989), sun).verdict, Verdict::different);
  // The sun itself is off by 0.5 %, which is 500 times the landscape's mean.
  EXPECT_EQ(
      judge(exact([](int x, int y) { return x < 3 && y < 3 ? 50'250.0 : 0.2 + 0.01 * x; }), sun)
          .verdict,
      Verdict::same);
}

TEST(Tolerance, IsRelativeToEachBlock) {
  const auto comparison =
      judge(render(1, 1024, beside_a_sun([](int, int y) { return y >= 32 ? 1.1 : 1.0; })),
            render(2, 1024, beside_a_sun(uniform_truth)));
  EXPECT_EQ(level(comparison, Unit::image).different, 0);
  EXPECT_EQ(level(comparison, Unit::block).different, 32);
  // 1 % and the noise of 64 pixels, of a mean of 1.
  EXPECT_NEAR(level(comparison, Unit::block).visible, 0.04, 0.02);
}

// The typical value is 1: what is darker than a tenth of it is judged as if it had that.
TEST(Tolerance, HasAFloorInTheDark) {
  const auto dark = [](double value) {
    return exact([=](int x, int) { return x < 10 ? value : 1.0; });
  };
  EXPECT_EQ(judge(dark(0.0009), dark(0.0)).verdict, Verdict::same);
  EXPECT_EQ(judge(dark(0.0011), dark(0.0)).verdict, Verdict::different);
  EXPECT_EQ(judge(dark(0.0509), dark(0.05)).verdict, Verdict::same);
}

// Dark and 5 % too bright, beside a brighter region that is right.
TEST(Places, RegionsAreJudgedByTheirOwnMeans) {
  Regions regions{{"left", "right"}, {}};
  for (int i = 0; i < side * side; ++i) {
    const int x = i % side;
    regions.of_pixel.push_back(x < 10 ? 0 : x < 60 ? 1 : -1);
  }
  const auto comparison = judge(render(1, 1024, [](int x, int) { return x < 10 ? 0.21 : 1.0; }),
                                render(2, 1024, [](int x, int) { return x < 10 ? 0.2 : 1.0; }),
                                tolerating(0.02), regions);
  EXPECT_EQ(comparison.verdict, Verdict::different);
  EXPECT_EQ(level(comparison, Unit::image).different, 0);
  EXPECT_EQ(level(comparison, Unit::block).different, 0);
  ASSERT_EQ(comparison.regions.size(), 8U);  // R G B all
  for (const Finding& f : comparison.regions) {
    EXPECT_EQ(f.estimate.verdict, f.name == "left" ? Verdict::different : Verdict::same);
    EXPECT_NEAR(f.estimate.difference, f.name == "left" ? 0.01 : 0.0,
                4 * f.estimate.standard_error);
  }
}

TEST(Places, OnlyTheWindowCounts) {
  Picture test = exact([](int x, int) { return x < 32 ? 1.0 : 5.0; });
  Picture reference = exact(uniform_truth);
  const auto channels = match(test, reference, {}, false);
  EXPECT_EQ(compare(test, reference, channels, {3, 4, 29, 50}, {}, {}).verdict, Verdict::same);
  EXPECT_EQ(compare(test, reference, channels, {3, 4, 30, 50}, {}, {}).verdict, Verdict::different);
}

// Noise that is not in the file

TEST(UnknownNoise, MakesAPlainCheckOfEveryPixel) {
  const auto one_off = [](double by) {
    return exact([=](int x, int y) { return x == 5 && y == 6 ? 1.0 + by : 1.0; });
  };
  const auto near = judge(one_off(0.009), exact(uniform_truth));
  EXPECT_FALSE(near.knows_noise);
  EXPECT_EQ(near.verdict, Verdict::same);
  const auto far = judge(one_off(0.011), exact(uniform_truth));
  EXPECT_EQ(far.verdict, Verdict::different);
  EXPECT_EQ(level(far, Unit::pixel).worst.front().window.x, 5);
  EXPECT_EQ(judge(render(1, 64), exact(uniform_truth)).verdict, Verdict::different);
}

TEST(UnknownNoise, OutliersMayBeAllowed) {
  const Picture test = exact([](int x, int y) { return x == 5 && y < 3 ? 2.0 : 1.0; });
  Judgement judgement;
  judgement.max_outliers = {2, false};
  EXPECT_EQ(judge(test, exact(uniform_truth), judgement).verdict, Verdict::different);
  judgement.max_outliers = {3, false};
  EXPECT_EQ(judge(test, exact(uniform_truth), judgement).verdict, Verdict::same);
}

TEST(UnknownNoise, FloorStandsInForIt) {
  Judgement judgement = tolerating(0.02);
  judgement.floor = Amount{0.005, true};
  const auto verdict = [&](double mean) {
    return judge(render(1, 256, [=](int, int) { return mean; }), exact(uniform_truth), judgement)
        .verdict;
  };
  EXPECT_EQ(verdict(1.01), Verdict::same);
  EXPECT_EQ(verdict(1.022), Verdict::inconclusive);
  EXPECT_EQ(verdict(1.03), Verdict::different);
}

// Fireflies

TEST(Fireflies, AreCountedApartFromBias) {
  const Truth lit = [](int x, int y) {
    const bool is_firefly = (x == 5 && y == 6) || (x == 40 && y == 7) || (x == 41 && y == 60);
    return is_firefly ? 500.0 : 1.001;
  };
  for (const bool is_noisy : {false, true}) {
    const Picture reference = is_noisy ? render(2, 1024) : exact(uniform_truth);
    const auto result = judge(is_noisy ? render(1, 1024, lit) : exact(lit), reference);
    EXPECT_EQ(result.fireflies, 3);
    EXPECT_NEAR(result.image[3].estimate.difference, 0.001 + 3 * 499.0 / (side * side), 0.002);
    EXPECT_NEAR(result.without_fireflies.difference, 0.001, is_noisy ? 0.002 : 1e-6);
  }
}

// Of 3 x 3 pixels none stands out from the rest. Nor does noise.
TEST(Fireflies, AreNeitherSpotsNorNoise) {
  const Truth spot = [](int x, int y) { return x / 3 == 7 && y / 3 == 5 ? 3.0 : 1.0; };
  EXPECT_EQ(judge(exact(spot), exact(uniform_truth)).fireflies, 0);
  EXPECT_EQ(judge(render(1, 4), render(2, 4), tolerating(0)).fireflies, 0);
}

// Light that all samples miss

// One sample in 20,000 finds it.
double rare(Random& random) { return std::bernoulli_distribution(5e-5)(random) ? 1.0 : 0.0; }

Picture with_rare_light(uint64_t seed) {
  return render(seed, 64, [](int, int) { return 0.0; }, rare);
}

TEST(MissedLight, IsNoDifference) {
  const Picture reference = exact([](int, int) { return 5e-5; });
  Judgement judgement = tolerating(0);
  judgement.floor = Amount{0, true};  // the reference has no noise
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    const auto result = judge(with_rare_light(seed), reference, judgement);
    EXPECT_NE(result.verdict, Verdict::different) << seed;
  }
}

// A hole of black pixels among others that tell what a hit is worth.
TEST(MissedLight, ExcusesNoHole) {
  for (const int width : {1, 16}) {
    Picture picture = render(1, 64);
    for (int y = 20; y < 20 + width; ++y) {
      for (int x = 20; x < 20 + width; ++x) {
        auto* const values = &picture.image.values[picture.image.pixel(x, y) * 6];
        std::fill_n(values, 6, 0.0F);
      }
    }
    EXPECT_EQ(judge(picture, render(2, 64)).verdict, Verdict::different);
  }
}

TEST(MissedLight, DoesNotExcuseABlackPicture) {
  const auto black = render(1, 64, [](int, int) { return 0.0; }, [](Random&) { return 0.0; });
  EXPECT_EQ(judge(black, render(2, 64)).verdict, Verdict::different);
}

// Perceived difference

Picture coloured(const std::function<double(int x, int y, int channel)>& truth) {
  Picture picture = exact([](int, int) { return 0.0; });
  for (int i = 0; i < 3 * side * side; ++i) {
    picture.image.values[size_t(i)] = float(truth(i / 3 % side, i / 3 / side, i % 3));
  }
  return picture;
}

Flip flip_of(FlipKind kind, Picture test, Picture reference) {
  match(test, reference, {}, false);
  return flip(kind, test, reference, {0, 0, side, side});
}

// By the authors' package flip-evaluator 1.7 with inputsRGB=False, LDR's input clamped.
TEST(Flip, AgreesWithItsAuthorsProgram) {
  const auto wave = [](int x, int y, int c) {
    return std::exp(2 * std::sin(0.3 * x + c) * std::cos(0.2 * y - c));
  };
  const auto patch = [&](int x, int y, int c) {
    return wave(x, y, c) * (x >= 20 && x < 40 && y >= 10 && y < 30 ? 1.2 : 1.0);
  };
  const auto noise = [&](int x, int y, int c) {
    return wave(x, y, c) * (1 + 0.3 * std::sin(7.0 * x * y));
  };
  const auto scaled = [](double scale, const auto& truth) {
    return coloured([=](int x, int y, int c) { return scale * truth(x, y, c); });
  };
  for (const FlipKind kind : {FlipKind::ldr, FlipKind::hdr}) {
    const bool is_hdr = kind == FlipKind::hdr;
    const double scale = is_hdr ? 5.0 : 0.13;
    const Flip by_patch = flip_of(kind, scaled(scale, patch), scaled(scale, wave));
    EXPECT_NEAR(by_patch.mean, is_hdr ? 0.0264605 : 0.0309004, 2e-6);
    const Flip by_noise = flip_of(kind, scaled(scale, noise), scaled(scale, wave));
    EXPECT_NEAR(by_noise.mean, is_hdr ? 0.0911647 : 0.0841448, 2e-6);
    EXPECT_NEAR(by_patch.first_exposure, is_hdr ? -3.774065 : 0.0, 2e-4);
    EXPECT_NEAR(by_patch.last_exposure, is_hdr ? -1.474745 : 0.0, 2e-4);
  }
}

// The median luminance is 0, so that the paper's last exposure would be infinite.
TEST(Flip, MostlyBlackPicturesAreSeenAsTheirLitPixelsAre) {
  const auto lamp = [](double radiance) {
    return coloured([=](int x, int y, int) { return x < 8 && y < 8 ? radiance * (x + 1) : 0.0; });
  };
  const Flip seen = flip_of(FlipKind::hdr, lamp(2.0), lamp(1.0));
  EXPECT_NEAR(seen.first_exposure, std::log2(2.118873 / 8), 1e-3);
  EXPECT_NEAR(seen.last_exposure, std::log2(2.118873 / 5), 1e-3);
  EXPECT_GT(seen.mean, 0.001);
  EXPECT_EQ(flip_of(FlipKind::hdr, lamp(0.0), lamp(0.0)).mean, 0.0);
  EXPECT_GT(flip_of(FlipKind::hdr, lamp(1.0), lamp(0.0)).mean, 0.001);
}

// Unfit pictures

std::string refusal(Picture test, Picture reference,
                    const std::vector<std::string>& channels = {}) {
  try {
    match(test, reference, channels, false);
  } catch (const ImageError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Numbers, HaveNoExponentsWhereTheyAreLarge) {
  EXPECT_EQ(percent_with_error(-100.0, 0.0, 2), "-100 ± 0 %");
  EXPECT_EQ(percent_with_error(99.4, 0.0123, 2), "+99 ± 0.012 %");
  EXPECT_EQ(percent_with_error(1234.5, 120.4, 3), "+1234 ± 120 %");
  EXPECT_EQ(percent_with_error(0.1234, 3.21, 3), "+0.123 ± 3.2 %");
}

TEST(Numbers, AreNoPartOfNothing) {
  Estimate estimate{.test = 0.5, .reference = 2.0, .difference = -1.5};
  estimate.confidence = 0.01;
  EXPECT_EQ(relative_difference(estimate), "-75 ± 0.5 %");
  estimate.reference = -2.0;
  EXPECT_EQ(relative_difference(estimate), "-75 ± 0.5 %");
  estimate.reference = 0.0;
  EXPECT_EQ(relative_difference(estimate), "0.5 ± 0.01, not 0");
}

TEST(Tables, AreAlignedWhateverTheirLettersTakeInBytes) {
  EXPECT_EQ(table({"what", "how far"}, {{"12 µm", "±"}, {"x", "1"}}), R"(
| what  | how far |
|-------|---------|
| 12 µm | ±       |
| x     | 1       |
)");
}

TEST(Poison, OneBadValueAnywhereIsRefusedWithItsPlace) {
  const Picture clean = render(1, 4, [](int, int) { return 9.0; });
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), -1e-30F, std::numeric_limits<float>::infinity()}) {
    for (const size_t channel : {0U, 2U, 4U}) {
      Picture poisoned = clean;
      poisoned.image.values[poisoned.image.pixel(63, 5) * 6 + channel] = bad;
      EXPECT_NE(refusal(poisoned, clean).find("is at 63,5 in " + clean.image.channels[channel]),
                std::string::npos);
      EXPECT_NE(refusal(clean, poisoned), "accepted");
      EXPECT_NE(refusal(poisoned, poisoned), "accepted");
    }
  }
}

TEST(Poison, OtherSizesAndChannelsAreRefused) {
  const Picture clean = render(1, 4, [](int, int) { return 9.0; });
  Picture other = clean;
  other.image.width /= 2;
  other.image.height *= 2;
  EXPECT_NE(refusal(other, clean).find("32 x 128"), std::string::npos);
  other = clean;
  other.image.channels[1] = "A";
  EXPECT_NE(refusal(other, clean).find("only the test has A"), std::string::npos);
  EXPECT_EQ(refusal(other, clean, {"R", "B"}), "accepted");
  EXPECT_NE(refusal(other, clean, {"G"}).find("no channel G"), std::string::npos);
}

}  // namespace
}  // namespace plumb
