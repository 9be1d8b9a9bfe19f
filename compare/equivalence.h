// SPDX-License-Identifier: Apache-2.0

// Tells whether two noisy averages are the same up to a tolerance.
#pragma once

#include "compare/sums.h"
namespace plumb {

// With the exit codes of diff(1), and one more. Trouble stands for what could not be compared: no
// estimate has this verdict.
enum class Verdict { same = 0, different = 1, trouble = 2, inconclusive = 3 };
const char* to_string(Verdict verdict);

// The difference of two averages, in radiance, and how surely it is known.
struct Estimate {
  double test = 0, reference = 0;
  double difference = 0;      // test - reference
  double standard_error = 0;  // of the difference, by the variances that the pictures claim; if
                              // they are paired, by how the pixels' differences scatter
  double confidence = 0;      // half the width of the difference's 95 % confidence interval
  double margin = 0;          // the same for all tests of the comparison at once
  double visible = 0;         // a bias of this size is found with a probability of 95 %
  double excess = 0;          // above 1 if it differs, and the larger the more clearly
  Verdict verdict = Verdict::same;
};

// How the averages of one channel are judged.
struct Criterion {
  double tolerance = 0;      // radiance
  double floor = 0;          // radiance by which the pictures may be wrong beside their noise
  bool knows_noise = false;  // if not, all margins are 0
  double noise_ratio = 1;    // the typical variance of the test over that of the reference
  bool is_paired = false;    // both have the same samples: the differences alone tell their noise

  // Estimates and judges a difference; leaves only the confidence at 0. `critical` is the
  // critical_value() of the test. Where all pixels are equal the verdict is `same`.
  Estimate estimate(const Pool& pool, double critical) const;

  // Sets the verdict and the excess by difference and margin: same if the interval difference +-
  // (margin + floor) lies inside +-tolerance, different if it lies outside.
  void judge(Estimate& estimate) const;

  // This many times the samples would lead to a decision; infinite if no number of samples would.
  double samples_factor(const Estimate& estimate) const;
};

// The c for which noise alone makes |sum d_i| exceed c sqrt(sum d_i^2) in any of `tests` tests with
// a probability of at most `false_alarm`, for independent d_i with any symmetric distributions.
// This is the bound by Bentkus and Dzindzalieta ("A tight Gaussian bound for weighted sums of
// Rademacher random variables", Bernoulli 21(2), 2015): P < 2 k P(Z > c) with k = 1 / (4 P(Z > sqrt
// 2)) and normal Z. It holds in spite of heavy tails (fireflies) and of variances that are noisy
// themselves.
//
// Its conditions, for d_i that are the differences of two pictures' pixels: pixels are independent
// (no filter wider than a pixel, no denoiser, no blue noise); and without a true difference d_i is
// symmetric, which is certain only where the two pixels are interchangeable, that is drawn in the
// same way with as many samples. A mean of few skewed samples is not symmetric against one of many:
// therefore the claimed variances count, too (cautious_variance()), and from 16 samples on only,
// which is experience and no theorem. With a true difference b_i, d_i - b_i is symmetric, and b_i
// adds to sum d_i^2, so that the margin is rather too wide.
double critical_value(double false_alarm, double tests);

// Half the width of the interval that contains the true difference of the averages, except with the
// probability `false_alarm`: by the claimed variances, which are noisy themselves, so by Student's
// t with the degrees of freedom of Welch and Satterthwaite.
double confidence(const Pool& pool, double false_alarm = 0.05);

// The same for pictures with the same samples, whose noise is not the sum of two: by Student's t
// for the pixels' differences.
double paired_confidence(const Pool& pool, double false_alarm = 0.05);

// How far a mean of `samples` samples may lie below its expectation, except with the probability
// `false_alarm`, because none of them was one of the rare bright ones; their variance does not
// tell. This is the second term of the empirical Bernstein bound for samples from 0 to `brightest`
// (Maurer and Pontil, "Empirical Bernstein Bounds and Sample Variance Penalization", 2009, theorem
// 4), with n for n - 1.
//
// The theorem is about independent samples of one distribution whose largest value is known. Here
// they are those of several pixels, may be Sobol' samples, and `brightest` is an estimate; and its
// first term is left to confidence(), which is not a bound. So the whole is a margin of the right
// size, and no theorem holds for it.
double unseen_margin(double brightest, double samples, double false_alarm);

// The variance of a difference where one picture may have missed rare events that the other one has
// met: each picture is taken to be at least as noisy as the other one tells.
double cautious_variance(double test, double reference, double noise_ratio);

}  // namespace plumb
