// SPDX-License-Identifier: Apache-2.0

#include "renderer/film.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <random>
#include <span>
#include <vector>

namespace plumb {
namespace {

using Values = std::function<float(int64_t)>;

void take(Film& film, const SampleRange& samples, const Values& value) {
  film.begin_pass();
  film.open_pixel(0);
  for (int64_t s = samples.first; s < samples.last; ++s) {
    const float rgb[3] = {value(s), 2.0f * value(s), 0.0f};
    film.add(0, static_cast<size_t>(s % Film::replicates), rgb, 1);
  }
}

Film film_of(int64_t samples, const Values& value) {
  Film film(1, 1);
  take(film, {0, samples}, value);
  film.end_pass({0, samples});
  return film;
}

TEST(Film, StartsBlack) {
  const Film film(2, 1);
  EXPECT_EQ(film.mean(), std::vector<float>(6, 0.0f));
  EXPECT_EQ(film.samples_per_pixel(), 0);
  EXPECT_EQ(film.relative_error(), std::numeric_limits<double>::infinity());
}

TEST(Film, GivesTheMeanOfItsSamples) {
  const Film film = film_of(6, [](int64_t s) { return static_cast<float>(s); });
  EXPECT_EQ(film.mean(), (std::vector<float>{2.5f, 5.0f, 0.0f}));
}

TEST(Film, CountsTheSamplesOfEachReplicate) {
  EXPECT_EQ(samples_per_replicate({0, 8}), (Film::Counts{2, 2, 2, 2}));
  EXPECT_EQ(samples_per_replicate({0, 1}), (Film::Counts{1, 0, 0, 0}));
  EXPECT_EQ(samples_per_replicate({3, 6}), (Film::Counts{1, 1, 0, 1}));
}

TEST(Film, KnowsNoVarianceFromOneReplicate) {
  const Film film = film_of(1, [](int64_t) { return 1.0f; });
  EXPECT_EQ(film.relative_error(), std::numeric_limits<double>::infinity());
  EXPECT_EQ(film.variance(), std::vector<float>(3, 0.0f));
}

// Uniform samples have variance 1/12. The mean of 20,000 estimates from N samples with few degrees
// of freedom scatters by less than 1 %: five times that is allowed.
TEST(Film, EstimatesTheVarianceOfTheMeanWithoutBias) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform;
  for (const int samples : {2, 3, 4, 5, 7, 16}) {
    double sum = 0.0;
    constexpr int films = 20000;
    for (int i = 0; i < films; ++i) {
      const Film film = film_of(samples, [&](int64_t) { return uniform(random); });
      sum += double{film.variance()[0]};
    }
    EXPECT_NEAR(sum / films * samples * 12.0, 1.0, 0.05) << samples;
  }
}

TEST(Film, EstimatesTheRelativeErrorByTheFormulaInItsHeader) {
  const Film film = film_of(8, [](int64_t s) { return s % 2 == 0 ? 1.0f : 3.0f; });
  const std::vector<float> mean = film.mean();
  const std::vector<float> variance = film.variance();
  double sum = 0.0;
  for (size_t c = 0; c < 3; ++c) sum += double{variance[c]} / (double{mean[c]} * mean[c] + 0.01);
  EXPECT_NEAR(film.relative_error(), std::sqrt(sum / 3.0), 1e-6);
}

TEST(Film, ForgetsAPassThatIsNotEnded) {
  Film film = film_of(4, [](int64_t) { return 1.0f; });
  take(film, {4, 8}, [](int64_t) { return 100.0f; });
  EXPECT_EQ(film.mean()[0], 1.0f);
  EXPECT_EQ(film.samples_per_pixel(), 4);
  take(film, {4, 8}, [](int64_t) { return 3.0f; });
  film.end_pass({4, 8});
  EXPECT_EQ(film.mean()[0], 2.0f);
}

TEST(Film, TakesSumsForSamples) {
  const Film whole = film_of(16, [](int64_t s) { return static_cast<float>(s * s); });
  Film parts(1, 1);
  for (int r = 0; r < Film::replicates; ++r) parts.add_sums(r, 4, whole.replicate_mean(r), 4.0);
  EXPECT_EQ(parts.mean(), whole.mean());
  EXPECT_EQ(parts.variance(), whole.variance());
  EXPECT_EQ(parts.samples_per_replicate(), whole.samples_per_replicate());
}

// Numbers over twelve orders of magnitude, whose sum in double depends on their order.
class Sums : public testing::TestWithParam<double> {
 protected:
  Sums() {
    std::lognormal_distribution<double> samples(-4.0, 4.0);
    for (float& x : numbers) x = static_cast<float>(GetParam() * std::min(samples(random), 1e4));
  }

  ExactSum sum_of(std::span<const float> some) const {
    ExactSum sum;
    for (const float x : some) sum.add(double{x}, grid);
    return sum;
  }

  std::mt19937 random{1};
  std::vector<float> numbers = std::vector<float>(100000);
  SumGrid grid{GetParam()};
};

TEST_P(Sums, DoNotDependOnTheOrder) {
  const auto terms = sum_of(numbers).terms();
  const double naive = std::accumulate(numbers.begin(), numbers.end(), 0.0);
  bool differs = false;
  for (int i = 0; i < 10; ++i) {
    std::ranges::shuffle(numbers, random);
    EXPECT_EQ(sum_of(numbers).terms(), terms);
    differs |= std::accumulate(numbers.begin(), numbers.end(), 0.0) != naive;
  }
  EXPECT_TRUE(differs);
  EXPECT_NEAR(sum_of(numbers).value() / naive, 1.0, 1e-12);
}

TEST_P(Sums, DoNotDependOnTheParts) {
  const ExactSum whole = sum_of(numbers);
  for (const size_t cut : {1, 10, 77777}) {
    const std::span all(numbers);
    ExactSum merged;
    for (const auto& part : {sum_of(all.subspan(cut)), sum_of(all.first(cut))}) {
      for (const float term : part.terms()) merged.add(double{term}, grid);
    }
    EXPECT_EQ(merged.value(), whole.value());
    EXPECT_EQ(merged.terms(), whole.terms());
  }
}

TEST(ExactSum, OfNothingIsNothing) {
  ExactSum sum;
  sum.add(0.0, SumGrid(0.0));
  EXPECT_EQ(sum.value(), 0.0);
}

INSTANTIATE_TEST_SUITE_P(OfAnyBrightness, Sums, testing::Values(1.0, 0.3, 1e-12, 1e9));

}  // namespace
}  // namespace plumb
