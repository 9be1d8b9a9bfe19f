// SPDX-License-Identifier: Apache-2.0

#include "compare/baseline_tests.h"

#include <OpenImageIO/color.h>

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <vector>

#include "compare/sums.h"

namespace plumb {
namespace {

double display_value(double radiance) {
  return double{OIIO::linear_to_sRGB(static_cast<float>(std::min(radiance, 1.0)))};
}

}  // namespace

BaselineTests test_by_baselines(const Picture& test, const Picture& reference, double samples) {
  constexpr double threshold = 0.05, level = 0.01, failures_allowed = 0.0025, least = 1e-4;
  const Window whole{0, 0, test.image.width, test.image.height};
  const double alpha = -std::expm1(std::log1p(-level) / double(whole.width * whole.height));
  const double critical = boost::math::quantile(boost::math::normal(), 1.0 - alpha / 2.0);
  const Sums sums = add_up(test, reference, whole, {});
  double squares = 0.0, failures = 0.0;
  for (size_t c = 0; c < test.channel_count(); ++c) {
    for (int block = 0; const Pool& pool : sums.blocks_of(c)) {
      const double noise = (pool.test_variance + pool.reference_variance) / pool.pixels;
      const double most = critical * std::sqrt(std::max(noise, least / samples));
      for_each_pixel(block_window(whole, block++), [&](int x, int y) {
        const size_t pixel = test.image.pixel(x, y);
        const double t = test.value(pixel, c), r = reference.value(pixel, c);
        squares += std::pow(display_value(t) - display_value(r), 2);
        failures += std::abs(t - r) > most;
      });
    }
  }
  const double values = sums.image.front().pixels * static_cast<double>(test.channel_count());
  return {std::sqrt(squares / values) > threshold, failures / values > failures_allowed};
}

}  // namespace plumb
