// SPDX-License-Identifier: Apache-2.0

// The path tracer once more, written to be read: one path at a time, in double precision. It has
// the estimator of simd/path-inl.h but shares no code with it except the scene model, so that each
// of the two checks the other one. It is many times slower.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "renderer/settings.h"
#include "scene/surfaces.h"

namespace plumb {

// What the plain path tracer knows of a scene, which has to outlive it.
struct PlainScene {
  explicit PlainScene(const Scene& scene);

  const Scene& model;
  std::vector<Surface> surfaces;
  std::vector<double> choice;  // for each surface, the chance of being the lamp: its share of power
  double margin;  // minimum distance of what a ray meets from its ends: far above double's rounding
};

// The radiance of one sample of a pixel; pixels are numbered along rows from the top left corner.
// Adds the rays that it took to `rays`. Of the settings, seed and bounces count. Every thousand
// bounces `is_abandoned` is asked, with their number, whether to leave the path unfinished.
Vec3 trace_path(const PlainScene& scene, const Settings& settings, int64_t pixel, int64_t sample,
                const std::function<bool(int64_t)>& is_abandoned, int64_t& rays);

}  // namespace plumb
