// SPDX-License-Identifier: Apache-2.0

#include "light_origins/trace_selected.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <type_traits>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "light_origins/trace_selected.cpp"
#include <hwy/foreach_target.h>

#include "light_origins/selective_estimator-inl.h"

HWY_BEFORE_NAMESPACE();
namespace plumb::HWY_NAMESPACE {

template <typename T>
int64_t trace_selected(const TraceJob<PackedScene<T>>& job) {
  using D = hn::ScalableTag<T>;
  return job.scene.has_all_materials ? trace_paths<SelectiveEstimator<D, true>>(job)
                                     : trace_paths<SelectiveEstimator<D, false>>(job);
}

int64_t trace_selected_float(const TraceJob<PackedScene<float>>& job) {
  return trace_selected<float>(job);
}
#if HWY_HAVE_FLOAT64  // not in WebAssembly's vectors
int64_t trace_selected_double(const TraceJob<PackedScene<double>>& job) {
  return trace_selected<double>(job);
}
#endif

}  // namespace plumb::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace plumb {

HWY_EXPORT(trace_selected_float);
#if HWY_HAVE_FLOAT64
HWY_EXPORT(trace_selected_double);
#endif

void select_light(const LightOrigin& origin, Settings& settings) {
  static constexpr Tracer selective{.in_float =
                                        [](const TraceJob<PackedScene<float>>& job) {
                                          return HWY_DYNAMIC_DISPATCH(trace_selected_float)(job);
                                        },
#if HWY_HAVE_FLOAT64
                                    .in_double =
                                        [](const TraceJob<PackedScene<double>>& job) {
                                          return HWY_DYNAMIC_DISPATCH(trace_selected_double)(job);
                                        }
#endif
  };
  settings.tracer = &selective;
  settings.origin = &origin;
}

}  // namespace plumb
#endif
