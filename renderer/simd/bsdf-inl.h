// SPDX-License-Identifier: Apache-2.0

// How surfaces scatter light: Lambert's BSDF, mirrors and metals, glass.
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

// A direction and its density with respect to solid angle, and what weight() lacks there.
template <class D>
struct BsdfSample {
  V3<D> direction;
  Real<D> pdf;
  V3<D> factor;
};

// What Fresnel's equations say is reflected of unpolarised light that meets, at that cosine, a
// smooth border, and the cosine of what goes through; 1 and 0 where nothing does (total
// reflection).
template <class D>
struct Fresnel {
  Real<D> reflectance, cosine_beyond;
};

// Of glass, whose refractive index beyond the border is n times that on this side.
template <class D>
HWY_INLINE Fresnel<D> fresnel_of_glass(Real<D> cosine, Real<D> n) {
  using R = Real<D>;
  // n^2 - sine^2, which keeps its digits where n is close to 1.
  const R rest = fma(cosine, cosine, (n - R(1)) * (n + R(1)));
  const R beyond = sqrt(max(rest, R(0)));  // n times the cosine there
  const R nn_cosine = n * n * cosine;
  const R across = (cosine - beyond) / (cosine + beyond);
  const R in_plane = (nn_cosine - beyond) / (nn_cosine + beyond);
  return {R(0.5f) * fma(across, across, in_plane * in_plane), beyond / n};
}

// Of a metal with the refractive index eta + i k (Born and Wolf, Principles of Optics,
// section 14.2, where a and b are n and kappa of equation 14.2(11) times the metal's cosine).
template <class D>
HWY_INLINE Real<D> fresnel_of_metal(Real<D> cosine, Real<D> eta, Real<D> k) {
  using R = Real<D>;
  const R cc = cosine * cosine, ss = max(R(1) - cc, R(0));
  const R p = fma(eta, eta, -fma(k, k, ss)), q = (eta + eta) * k;
  const R sum = sqrt(fma(p, p, q * q));  // a^2 + b^2, and p is a^2 - b^2
  // The one of both sums that does not cancel.
  const R larger = sum + abs(p), other = select(larger > R(0), q * q / larger, R(0));
  const R a = sqrt(R(0.5f) * select(p > R(0), larger, other));
  const R twice = (a + a) * cosine;
  const R across = ((sum + cc) - twice) / ((sum + cc) + twice);
  const R even = fma(sum, cc, ss * ss);
  const R in_plane = (even - twice * ss) / (even + twice * ss);
  return R(0.5f) * fma(across, in_plane, across);
}

template <class D>
HWY_INLINE V3<D> fresnel_of_metal(Real<D> cosine, V3<D> eta, V3<D> k) {
  return {fresnel_of_metal(cosine, eta.x, k.x), fresnel_of_metal(cosine, eta.y, k.y),
          fresnel_of_metal(cosine, eta.z, k.z)};
}

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
//   glass     f = fresnel * reflectance * (the same), and for the other side
//             (1 - fresnel) * transmittance / n^2 * (a delta at the refracted direction) / cosine
template <class D>
struct BsdfLanes {
  V3<D> normal;       // on the side from which the path came
  V3<D> reflectance;  // of metals what they show at the path's angle; of glass 1
  Bool<D> is_mirror;
  Bool<D> is_glass;
  bool has_mirrors, has_glass;  // whether any lane may see them
  Real<D> n;                    // of glass: the refractive index beyond, in that on this side
  V3<D> gloss, transmittance;   // of glass: what multiplies the light that each way brings

  // Whether light is scattered in single directions alone.
  HWY_INLINE Bool<D> is_specular() const { return is_mirror | is_glass; }

  // f * cosine / reflectance, the cosine being that of `direction`. Not for specular surfaces.
  HWY_INLINE Real<D> eval(V3<D> direction) const {
    return dot(normal, direction) * Real<D>::inverse_pi();
  }

  // The density of `direction` in sample(). Not for specular surfaces.
  HWY_INLINE Real<D> pdf(V3<D> direction) const {
    return dot(normal, direction) * Real<D>::inverse_pi();
  }

  // A direction in proportion to f * cosine, from u and v in the unit square.
  HWY_INLINE BsdfSample<D> sample(V3<D> incident, Real<D> u, Real<D> v) const {
    return specular_or(incident, u, sample_cosine_hemisphere(frame_around(normal), u, v));
  }

  // f * cosine / pdf of the directions that sample() takes, but for the sample's factor. A diffuse
  // surface's is (reflectance / pi) * cosine / (cosine / pi), a mirror's the same by the delta.
  HWY_INLINE V3<D> weight() const { return reflectance; }

  // A specular surface's sample; where it is diffuse, that of the direction `scattered`.
  HWY_INLINE BsdfSample<D> specular_or(V3<D> incident, Real<D> u, V3<D> scattered) const {
    using R = Real<D>;
    BsdfSample<D> sample{scattered, pdf(scattered), V3<D>(R(1))};
    if (!has_mirrors && !has_glass) return sample;
    const R twice = R(-2) * dot(normal, incident);
    sample.direction =
        select(is_specular(), normalize(fma(normal, twice, incident)), sample.direction);
    sample.pdf = select(is_specular(), R(delta<hn::TFromD<D>>), sample.pdf);
    if (has_glass && is_glass.any()) go_through(incident, u, sample);
    return sample;
  }

  // Takes Fresnel's reflectance as the chance of reflection; Snell's law says where the rest goes.
  HWY_INLINE void go_through(V3<D> incident, Real<D> u, BsdfSample<D>& sample) const {
    using R = Real<D>;
    const R cosine = max(-dot(normal, incident), R(1e-10f));
    const Fresnel<D> fresnel = fresnel_of_glass(cosine, n);
    const R inverse = R(1) / n;
    const R along_normal = cosine * inverse - fresnel.cosine_beyond;
    const Bool<D> through = is_glass & (u >= fresnel.reflectance);
    sample.direction =
        select(through, normalize(fma(incident, inverse, normal * along_normal)), sample.direction);
    sample.factor = select(is_glass, gloss, sample.factor);
    sample.factor = select(through, transmittance * (inverse * inverse), sample.factor);
  }
};

}  // namespace plumb::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
