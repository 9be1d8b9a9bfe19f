// SPDX-License-Identifier: Apache-2.0

// What tests in common use say of two pictures: the project's own comparison is measured against
// them.
#pragma once

#include "compare/picture.h"

namespace plumb {

// Whether the pictures are different, by each test.
struct BaselineTests {
  bool rmse = false, z = false;
};

// The root mean square error of sRGB display values, which may be 5 % of white; and the z-test of
// Mitsuba 3's tests: pixel by pixel and channel by channel, with Sidak's correction for the number
// of pixels, at the level 0.01, of which 0.25 % may fail. There the variance of a sample is at
// least 1e-4; `samples` is the test's number of them in each pixel. The variance of a pixel is the
// mean of its block's, because its own is known too roughly. Both pictures are matched already.
BaselineTests test_by_baselines(const Picture& test, const Picture& reference, double samples);

}  // namespace plumb
