// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <type_traits>

#include "renderer/trace.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer/trace_double.cpp"
#include <hwy/foreach_target.h>

#include "renderer/simd/path-inl.h"

HWY_BEFORE_NAMESPACE();
namespace plumb::HWY_NAMESPACE {

int64_t trace_double(const TraceJob<PackedScene<double>>& job) {
  using D = hn::ScalableTag<double>;
  return job.scene.has_all_materials ? trace_paths<Estimator<D, true>>(job)
                                     : trace_paths<Estimator<D, false>>(job);
}

}  // namespace plumb::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace plumb {

HWY_EXPORT(trace_double);

int64_t trace(const TraceJob<PackedScene<double>>& job) {
  return HWY_DYNAMIC_DISPATCH(trace_double)(job);
}

}  // namespace plumb
#endif
