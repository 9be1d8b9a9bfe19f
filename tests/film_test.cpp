#include "renderer/film.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace plumb {
namespace {

void add(Film& film, int64_t sample, float value) {
  const float rgb[3] = {value, 2.0f * value, 0.0f};
  film.add(0, static_cast<size_t>(sample % Film::replicates), rgb, 1);
}

TEST(Film, StartsBlack) {
  const Film film(2, 1);
  EXPECT_EQ(film.mean(), std::vector<float>(6, 0.0f));
  EXPECT_EQ(film.samples_per_pixel(), 0);
  EXPECT_EQ(film.relative_error(), std::numeric_limits<double>::infinity());
}

TEST(Film, GivesTheMeanOfItsSamples) {
  Film film(1, 1);
  for (int s = 0; s < 6; ++s) add(film, s, static_cast<float>(s));
  film.count({0, 6});
  EXPECT_EQ(film.mean(), (std::vector<float>{2.5f, 5.0f, 0.0f}));
}

TEST(Film, CountsTheSamplesOfEachReplicate) {
  EXPECT_EQ(samples_per_replicate({0, 8}), (Film::Counts{2, 2, 2, 2}));
  EXPECT_EQ(samples_per_replicate({0, 1}), (Film::Counts{1, 0, 0, 0}));
  EXPECT_EQ(samples_per_replicate({3, 6}), (Film::Counts{1, 1, 0, 1}));
}

TEST(Film, KnowsNoVarianceFromOneReplicate) {
  Film film(1, 1);
  add(film, 0, 1.0f);
  film.count({0, 1});
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
      Film film(1, 1);
      for (int s = 0; s < samples; ++s) add(film, s, uniform(random));
      film.count({0, samples});
      sum += double{film.variance()[0]};
    }
    EXPECT_NEAR(sum / films * samples * 12.0, 1.0, 0.05) << samples;
  }
}

TEST(Film, EstimatesTheRelativeErrorByTheFormulaInItsHeader) {
  Film film(1, 1);
  for (int s = 0; s < 8; ++s) add(film, s, s % 2 == 0 ? 1.0f : 3.0f);
  film.count({0, 8});
  const std::vector<float> mean = film.mean();
  const std::vector<float> variance = film.variance();
  double sum = 0.0;
  for (size_t c = 0; c < 3; ++c) sum += double{variance[c]} / (double{mean[c]} * mean[c] + 0.01);
  EXPECT_NEAR(film.relative_error(), std::sqrt(sum / 3.0), 1e-6);
}

TEST(Film, TakesMeansForSamples) {
  Film whole(1, 1);
  Film parts(1, 1);
  for (int s = 0; s < 16; ++s) add(whole, s, static_cast<float>(s * s));
  whole.count({0, 16});
  for (int r = 0; r < Film::replicates; ++r) {
    parts.add_mean(r, 4, whole.replicate_mean(r));
  }
  EXPECT_EQ(parts.mean(), whole.mean());
  EXPECT_EQ(parts.variance(), whole.variance());
  EXPECT_EQ(parts.samples_per_replicate(), whole.samples_per_replicate());
}

}  // namespace
}  // namespace plumb
