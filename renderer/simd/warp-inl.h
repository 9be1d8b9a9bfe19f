// SPDX-License-Identifier: Apache-2.0

// Maps from the unit square to directions around an axis, which are of unit length. Their densities
// are with respect to solid angle.
#include "renderer/simd/real-inl.h"

#if defined(PLUMB_SIMD_WARP_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PLUMB_SIMD_WARP_INL_H
#undef PLUMB_SIMD_WARP_INL_H
#else
#define PLUMB_SIMD_WARP_INL_H
#endif

HWY_BEFORE_NAMESPACE();
namespace plumb::HWY_NAMESPACE {

template <class D>
struct Frame {
  V3<D> x, y, z;
};

// Two unit vectors orthogonal to the unit vector n and to each other (Duff et al., "Building an
// Orthonormal Basis, Revisited", JCGT 6(1), 2017).
template <class D>
HWY_INLINE Frame<D> frame_around(V3<D> n) {
  using R = Real<D>;
  const R sign = flip(R(1), n.z);
  const R a = R(-1) / (sign + n.z);
  const R b = n.x * n.y * a;
  return {{fma(sign * n.x * n.x, a, R(1)), sign * b, -(sign * n.x)},
          {b, fma(n.y * n.y, a, sign), -n.y},
          n};
}

// The direction at the cosine and sine from frame.z, turned around it by v of a full circle.
template <class D>
HWY_INLINE V3<D> spherical_direction(const Frame<D>& frame, Real<D> cosine, Real<D> sine,
                                     Real<D> v) {
  const Real<D> angle = v * (Real<D>::pi() + Real<D>::pi());
  return fma(frame.x, sine * cos(angle), fma(frame.y, sine * sin(angle), frame.z * cosine));
}

// Cosine-weighted around frame.z (Malley's method). Density: cosine / pi.
template <class D>
HWY_INLINE V3<D> sample_cosine_hemisphere(const Frame<D>& frame, Real<D> u, Real<D> v) {
  return spherical_direction(frame, sqrt(Real<D>(1) - u), sqrt(u), v);
}

}  // namespace plumb::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
