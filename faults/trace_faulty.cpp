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

int64_t trace_faulty(const TraceJob<PackedScene<float>>& job) {
  return HWY_DYNAMIC_DISPATCH(trace_with_fault)(job);
}

}  // namespace plumb
#endif
