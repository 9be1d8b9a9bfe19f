// SPDX-License-Identifier: Apache-2.0

// The estimator that counts the light of a LightOrigin alone. Paths are the same as without it, so
// that pictures of disjoint parts add up to the whole picture.
#include "renderer/simd/path-inl.h"
#include "scene/light_origin.h"

#if defined(PLUMB_SELECTIVE_ESTIMATOR_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PLUMB_SELECTIVE_ESTIMATOR_INL_H
#undef PLUMB_SELECTIVE_ESTIMATOR_INL_H
#else
#define PLUMB_SELECTIVE_ESTIMATOR_INL_H
#endif

HWY_BEFORE_NAMESPACE();
namespace plumb::HWY_NAMESPACE {

template <class Lanes, bool AllMaterials>
struct SelectiveEstimator : Estimator<Lanes, AllMaterials> {
  using Base = Estimator<Lanes, AllMaterials>;
  using typename Base::D;
  using typename Base::R;
  using typename Base::T;

  explicit SelectiveEstimator(const TraceJob<PackedScene<T>>& job)
      : Base(job), is_last(job.settings.origin->way == LightOrigin::Way::last) {
    // Before them the sky's, and the void's.
    selected.assign(1, T{0});
    for (const uint8_t is_one : job.settings.origin->has_surface) selected.push_back(T(is_one));
  }

  void meet(R id, R bounces) {
    const Bool<D> is_way = bounces > R(1);
    touched = is_way & (touched | met);
    met = is_selected(id);
    last = (is_way & last) | ((!is_way) & met);
    depth = bounces;
  }

  V3<D> contribution(V3<D> light, R bounces, R at, R from) const {
    const Bool<D> is_seen = at < R(0.5f);  // where the light arrives, or it is the light
    const Bool<D> is_first_selected = is_seen & is_selected(from);
    if (is_last) return select(is_first_selected | (last & !is_seen), light, V3<D>(R(0)));
    const Bool<D> here = met & (at > R(0.5f)) & (at == depth);
    const Bool<D> by_mirror = is_selected(from) & (bounces > at + R(1.5f));
    return select(touched | here | by_mirror, light, V3<D>(R(0)));
  }

 private:
  Bool<D> is_selected(R id) const {
    const D d;
    const hn::RebindToSigned<D> di;
    const auto row = hn::ConvertTo(di, (max(id, R(-1)) + R(1)).v);
    return R(hn::GatherIndex(d, selected.data(), row)) > R(0);
  }

  bool is_last;
  std::vector<T> selected;  // 1 for each surface that is one of them
  // The surface that the path met last, and after how many bounces; the one that it met second, or
  // first if it met no other; and any but the first and the one that it met last.
  Bool<D> met = Bool<D>::none(), last = Bool<D>::none(), touched = Bool<D>::none();
  R depth = R(0);
};

}  // namespace plumb::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
