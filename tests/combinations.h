// SPDX-License-Identifier: Apache-2.0

// Every way to render a picture, as parameters of tests.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <tuple>

#include "renderer/settings.h"

namespace plumb::test {

using Combination = std::tuple<Method, Sampler, Precision>;

inline std::string name_of(const Combination& combination) {
  const auto& [method, sampler, precision] = combination;
  const char* methods[] = {"bsdf", "nee", "mis", "plain"};
  return std::string(methods[int(method)]) +
         (sampler == Sampler::sobol ? "_sobol" : "_independent") +
         (precision == Precision::float32 ? "_float_" : "_double_");
}

inline const auto all_combinations =
    testing::Combine(testing::Values(Method::bsdf, Method::nee, Method::mis),
                     testing::Values(Sampler::independent, Sampler::sobol),
                     testing::Values(Precision::float32, Precision::float64));
inline const auto plain_combination =
    testing::Values(Combination(Method::plain, Sampler::independent, Precision::float64));

}  // namespace plumb::test
