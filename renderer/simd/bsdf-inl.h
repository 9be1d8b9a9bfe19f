// SPDX-License-Identifier: Apache-2.0

// How surfaces scatter light: Lambert's BSDF and the perfect mirror.
#include "renderer/simd/warp-inl.h"

#if defined(PLUMB_SIMD_BSDF_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PLUMB_SIMD_BSDF_INL_H
#undef PLUMB_SIMD_BSDF_INL_H
#else
#define PLUMB_SIMD_BSDF_INL_H
#endif

HWY_BEFORE_NAMESPACE();
namespace plumb::HWY_NAMESPACE {

// The density of a direction that could not have been another one: a mirror's or the camera's.
template <typename T>
constexpr T delta = std::numeric_limits<T>::infinity();

// A direction and its density with respect to solid angle.
template <class D>
struct BsdfSample {
  V3<D> direction;
  Real<D> pdf;
};

// The BSDF at the point of a surface that each lane is at. All directions are of unit length and
// lead away from the point, but `incident`, which is the path's and leads to it from the camera.
// The other side of the surface gets nothing: eval() and pdf() are negative there, and callers
// leave such directions out.
//
// A BSDF's value f is in 1 / sr. Each f here is the reflectance, which has a colour, times a
// number:
//
//   diffuse   f = reflectance / pi
//   mirror    f = reflectance * (a Dirac delta at the reflected direction) / cosine
template <class D>
struct BsdfLanes {
  V3<D> normal;  // on the side from which the path came
  V3<D> reflectance;
  Bool<D> is_mirror;
  bool has_mirrors;  // whether any lane may see one

  // f * cosine / reflectance, the cosine being that of `direction`. Not for mirrors.
  HWY_INLINE Real<D> eval(V3<D> direction) const {
    return dot(normal, direction) * Real<D>::inverse_pi();
  }

  // The density of `direction` in sample(). Not for mirrors.
  HWY_INLINE Real<D> pdf(V3<D> direction) const {
    return dot(normal, direction) * Real<D>::inverse_pi();
  }

  // A direction in proportion to f * cosine, from u and v in the unit square.
  HWY_INLINE BsdfSample<D> sample(V3<D> incident, Real<D> u, Real<D> v) const {
    return mirror_or(incident, sample_cosine_hemisphere(frame_around(normal), u, v));
  }

  // f * cosine / pdf of the directions that sample() takes. A diffuse surface's is
  // (reflectance / pi) * cosine / (cosine / pi), a mirror's the same by the delta.
  HWY_INLINE V3<D> weight() const { return reflectance; }

  // A mirror's sample; where the surface is diffuse, that of the direction `scattered`.
  HWY_INLINE BsdfSample<D> mirror_or(V3<D> incident, V3<D> scattered) const {
    using R = Real<D>;
    if (!has_mirrors) return {scattered, pdf(scattered)};
    const V3<D> reflected = normalize(fma(normal, R(-2) * dot(normal, incident), incident));
    return {select(is_mirror, reflected, scattered),
            select(is_mirror, R(delta<hn::TFromD<D>>), pdf(scattered))};
  }
};

}  // namespace plumb::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
