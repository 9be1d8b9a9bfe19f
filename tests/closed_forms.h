// SPDX-License-Identifier: Apache-2.0

// Radiance that is known exactly, and every way to render it, as parameters of tests.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <tuple>

#include "renderer/settings.h"
#include "tests/test_scenes.h"

namespace plumb::test {

struct Case {
  std::string name;
  Scene scene;
  double radiance;  // expected in every pixel's mean, all channels
  BounceRange bounces{};
  double patience = 1.0;  // by how much its standard error may be larger than the others'
};

using Combination = std::tuple<Method, Sampler, Precision>;

inline std::string name_of(const Combination& combination) {
  const auto& [method, sampler, precision] = combination;
  const char* methods[] = {"bsdf", "nee", "mis", "plain"};
  return std::string(methods[int(method)]) +
         (sampler == Sampler::sobol ? "_sobol" : "_independent") +
         (precision == Precision::float32 ? "_float_" : "_double_");
}

// The mean of all pixels and channels is the case's radiance, within four standard errors of at
// most `wanted` times its patience and what rounding makes of it.
inline void expect_met(const Case& c, const Combination& combination, double wanted,
                       double rounding) {
  const auto& [method, sampler, precision] = combination;
  const Settings settings{.method = method,
                          .sampler = sampler,
                          .precision = precision,
                          .seed = 1,
                          .bounces = c.bounces};
  const Measurement m = measure_until(c.scene, settings, wanted * c.patience);
  EXPECT_LE(m.standard_error, wanted * c.patience * m.mean) << c.name;
  EXPECT_NEAR(m.mean, c.radiance, 4.0 * m.standard_error + rounding * c.radiance)
      << c.name << ": " << (m.mean / c.radiance - 1.0) * 100.0 << " % off, standard error "
      << m.standard_error / c.radiance * 100.0 << " %";
}

inline const auto all_combinations =
    testing::Combine(testing::Values(Method::bsdf, Method::nee, Method::mis),
                     testing::Values(Sampler::independent, Sampler::sobol),
                     testing::Values(Precision::float32, Precision::float64));
inline const auto plain_combination =
    testing::Values(Combination(Method::plain, Sampler::independent, Precision::float64));

}  // namespace plumb::test
