// SPDX-License-Identifier: Apache-2.0

#include "renderer/trace.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <type_traits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer/trace.cpp"
#include <hwy/foreach_target.h>

#include "renderer/simd/path-inl.h"

HWY_BEFORE_NAMESPACE();
namespace plumb::HWY_NAMESPACE {

int64_t trace_float(const TraceJob<PackedScene<float>>& job) {
  using D = hn::ScalableTag<float>;
  return job.scene.has_all_materials ? trace_paths<Estimator<D, true>>(job)
                                     : trace_paths<Estimator<D, false>>(job);
}

const char* target() { return hwy::TargetName(HWY_TARGET); }

}  // namespace plumb::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace plumb {

HWY_EXPORT(trace_float);
HWY_EXPORT(target);

int64_t trace(const TraceJob<PackedScene<float>>& job) {
  return HWY_DYNAMIC_DISPATCH(trace_float)(job);
}
const char* trace_target() { return HWY_DYNAMIC_DISPATCH(target)(); }

}  // namespace plumb
#endif
