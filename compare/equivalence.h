// Tells whether two noisy averages are the same up to a tolerance.
#pragma once

#include "compare/sums.h"
namespace plumb {

// With the exit codes of diff(1), and one more. Trouble stands for what could not be compared: no
// estimate has this verdict.
enum class Verdict { same = 0, different = 1, trouble = 2, inconclusive = 3 };
const char* to_string(Verdict verdict);

// The difference of two averages, in radiance.
struct Estimate {
  double test = 0, reference = 0;
  double difference = 0;      // test - reference
  double standard_error = 0;  // by the variances that are claimed
  double confidence = 0;      // difference +- this holds with 95 %
  double margin = 0;          // and +- this in all tests of the comparison at once
  double visible = 0;         // a bias of this size would be found, with 95 %
  double excess = 0;          // above 1: how clearly it differs
  Verdict verdict = Verdict::same;
};

// How one channel's averages are judged.
struct Criterion {
  double tolerance = 0;      // radiance
  double floor = 0;          // radiance by which the pictures may be wrong beside their noise
  bool knows_noise = false;  // else there are no margins
  double noise_ratio = 1;    // typical variance of the test / that of the reference

  // All but the confidence.
  Estimate estimate(const Pool& pool, double critical) const;

  // From difference and margin: same if difference +- (margin + floor) lies within +-tolerance,
  // different if it lies outside.
  void judge(Estimate& estimate) const;

  // How many times the samples would decide this estimate; infinite if no number would.
  double samples_factor(const Estimate& estimate) const;
};

// The c such that noise alone makes |sum d_i| exceed c sqrt(sum d_i^2) in one of `tests` with the
// probability `false_alarm` at most, for independent d_i of any symmetric distributions. By the
// bound of Bentkus and Dzindzalieta (Bernoulli 21(2), 2015): P < 2 k P(Z > c), k = 1 / (4 P(Z >
// sqrt 2)), Z normal. So heavy tails (fireflies) and variances that are themselves noisy do no
// harm.
double critical_value(double false_alarm, double tests);

// Half the width of the interval that holds the difference of the averages but for that chance, by
// the claimed variances, which are noisy themselves: Student's t with Welch's and Satterthwaite's
// degrees of freedom.
double confidence(const Pool& pool, double false_alarm = 0.05);

// How far below its expectation a mean of `samples` samples may lie, but for that chance, because
// none of them was one of the rare bright ones, of which their variance does not tell: the second
// term of the empirical Bernstein bound for samples from 0 to `brightest` (Maurer and Pontil,
// "Empirical Bernstein Bounds and Sample Variance Penalization", 2009, theorem 4).
double unseen_margin(double brightest, double samples, double false_alarm);

// Variance of a difference, where one picture has missed rare events that the other one has met:
// each is taken to be at least as noisy as the other one tells.
double cautious_variance(double test, double reference, double noise_ratio);

}  // namespace plumb
