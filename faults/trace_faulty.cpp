// SPDX-License-Identifier: Apache-2.0

#include "faults/trace_faulty.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <type_traits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "faults/trace_faulty.cpp"
#include <hwy/foreach_target.h>

#include "faults/faulty_estimator-inl.h"

HWY_BEFORE_NAMESPACE();
namespace plumb::HWY_NAMESPACE {

int64_t trace_with_fault(const TraceJob<PackedScene<float>>& job) {
  return trace_paths<FaultyEstimator<hn::ScalableTag<float>>>(job);
}

}  // namespace plumb::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace plumb {

HWY_EXPORT(trace_with_fault);

namespace {

// The plane that the camera's axes reach to, through which it looks as through a wall's back.
Plane<float> near_plane(const PackedCamera<float>& camera) {
  const auto half_width = static_cast<float>(camera.width) / 2.0F;
  const auto half_height = static_cast<float>(camera.height) / 2.0F;
  PackedVec3<float> axis = camera.corner;
  axis.x += half_width * camera.x_pixel.x + half_height * camera.y_pixel.x;
  axis.y += half_width * camera.x_pixel.y + half_height * camera.y_pixel.y;
  axis.z += half_width * camera.x_pixel.z + half_height * camera.y_pixel.z;
  const auto& o = camera.origin;
  return {axis, -(axis.x * (o.x + axis.x) + axis.y * (o.y + axis.y) + axis.z * (o.z + axis.z))};
}

}  // namespace

int64_t trace_faulty(const TraceJob<PackedScene<float>>& job) {
  if (job.settings.fault != Fault::near_clipped) return HWY_DYNAMIC_DISPATCH(trace_with_fault)(job);
  PackedScene<float> scene = job.scene;
  scene.camera.backs.push_back(near_plane(scene.camera));
  return HWY_DYNAMIC_DISPATCH(trace_with_fault)(
      {scene, job.settings, job.samples, job.film, job.next_pixel, job.is_abandoned, job.shares});
}

}  // namespace plumb
#endif
