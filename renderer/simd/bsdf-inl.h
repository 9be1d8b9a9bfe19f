// SPDX-License-Identifier: Apache-2.0

// How surfaces scatter light: Lambert's BSDF, mirrors and metals, smooth or rough, and
// glass.
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
// smooth border, beyond which the refractive index is n times that on this side; and the cosine of
// what goes through. They are 1 and 0 where nothing does (total reflection).
template <class D>
HWY_INLINE Real<D> fresnel_of_glass(Real<D> cosine, Real<D> n, Real<D>& cosine_beyond) {
  using R = Real<D>;
  // n^2 - sine^2, which keeps its digits where n is close to 1.
  const R rest = fma(cosine, cosine, (n - R(1)) * (n + R(1)));
  const R beyond = sqrt(max(rest, R(0)));  // n times the cosine there
  const R nn_cosine = n * n * cosine;
  const R across = (cosine - beyond) / (cosine + beyond);
  const R in_plane = (nn_cosine - beyond) / (nn_cosine + beyond);
  cosine_beyond = beyond / n;
  return R(0.5f) * fma(across, across, in_plane * in_plane);
}

// Of a metal with the refractive index eta + i k; 1 where both are 0 (Born and Wolf, Principles of
// Optics, section 14.2, where a and b are n and kappa of equation 14.2(11) times the metal's
// cosine).
template <class D>
HWY_INLINE Real<D> fresnel_of_metal(Real<D> cosine, Real<D> eta, Real<D> k) {
  using R = Real<D>;
  const R cc = cosine * cosine, ss = max(R(1) - cc, R(0));
  const R p = fma(eta, eta, -fma(k, k, ss)), q = (eta + eta) * k;
  // a^2 + b^2, and p is a^2 - b^2. Not 0, for what has no index.
  const R sum = max(sqrt(fma(p, p, q * q)), R(1e-20f));
  // The one of both sums that does not cancel.
  const R larger = sum + abs(p), other = q * q / larger;
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

// A metal that consists of tiny mirrors, the directions of whose normals have the GGX distribution
// (Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007); what of
// them hides others is Smith's, for both directions by itself. Cosines are to the surface's normal.
template <class D>
struct Microfacets {
  Real<D> alpha;

  // The share of the mirrors that is seen at that cosine.
  HWY_INLINE Real<D> visible(Real<D> cosine) const {
    using R = Real<D>;
    const R aa = alpha * alpha;
    return (cosine + cosine) / (cosine + sqrt(fma(fma(-aa, cosine, cosine), cosine, aa)));
  }

  // Their density, with respect to solid angle, at that half vector.
  HWY_INLINE Real<D> distribution(V3<D> normal, V3<D> half) const {
    using R = Real<D>;
    const R cosine = dot(normal, half), aa = alpha * alpha;
    const V3<D> aside = fma(normal, -cosine, half);  // keeps the digits of a small sine
    const R spread = fma(aa, cosine * cosine, dot(aside, aside));
    return aa * R::inverse_pi() / (spread * spread);
  }

  // A half vector of those that are seen from `view` (Dupuy and Benyoub, "Sampling Visible GGX
  // Normals with Spherical Caps", HPG 2023).
  HWY_INLINE V3<D> sample(V3<D> normal, V3<D> view, Real<D> u, Real<D> v) const {
    using R = Real<D>;
    const Frame<D> axes = frame_around(normal);
    const V3<D> stretched =
        normalize(V3<D>(dot(axes.x, view) * alpha, dot(axes.y, view) * alpha, dot(normal, view)));
    const R z = fma(R(1) - v, R(1) + stretched.z, -stretched.z);
    const R sine = sqrt(max(fma(-z, z, R(1)), R(0))), angle = u * (R::pi() + R::pi());
    const V3<D> half = V3<D>(sine * cos(angle), sine * sin(angle), z) + stretched;
    return normalize(fma(axes.x, half.x * alpha, fma(axes.y, half.y * alpha, normal * half.z)));
  }
};

// The BSDF at the point of a surface that each lane is at. All directions are of unit length and
// lead away from the point, but `incident`, which is the path's and leads to it from the camera.
// The other side of the surface gets nothing: eval() and pdf() are not above 0 there, and callers
// leave such directions out.
//
// A BSDF's value f is in 1 / sr. Each f here is a colour times a number:
//
//   diffuse   f = reflectance / pi
//   mirror    f = reflectance * (a Dirac delta at the reflected direction) / cosine
//   glass     f = fresnel * reflectance * (the same), and for the other side
//             (1 - fresnel) * transmittance / n^2 * (a delta at the refracted direction) / cosine
//   rough     f = fresnel * reflectance * distribution * visible * visible / (4 * cosine * cosine)
template <class D, bool AllMaterials>
struct BsdfLanes {
  using R = Real<D>;

  // What glass and metals with an index need, which a kernel without them does not hold.
  struct More {
    V3<D> incident;
    Bool<D> is_glass, is_rough;
    R n;                         // of glass: the index beyond, in that on this side
    V3<D> gloss, transmittance;  // of glass: what multiplies the light that each way brings
    Microfacets<D> facets;       // of rough metals, as these two
    V3<D> eta, k;
  };
  struct Nothing {};

  V3<D> normal;       // on the side from which the path came
  V3<D> reflectance;  // of smooth metals what they show at the path's angle; of glass 1
  Bool<D> is_mirror;
  Bool<D> is_specular;  // light is scattered in single directions: not for the next three
  std::conditional_t<AllMaterials, More, Nothing> more;

  // What multiplies the number that makes f.
  HWY_INLINE V3<D> colour(V3<D> direction) const {
    if constexpr (AllMaterials) {
      const R cosine = max(dot(half(direction), direction), R(0));
      const V3<D> rough = reflectance * fresnel_of_metal(cosine, more.eta, more.k);
      return select(more.is_rough, rough, reflectance);
    }
    return reflectance;
  }

  // f * cosine / colour, the cosine being that of `direction`.
  HWY_INLINE R eval(V3<D> direction) const {
    const R density = pdf(direction);
    if constexpr (AllMaterials) {
      const R visible = more.facets.visible(max(dot(normal, direction), R(0)));
      return select(more.is_rough, density * visible, density);
    }
    return density;
  }

  // The density of `direction` in sample().
  HWY_INLINE R pdf(V3<D> direction) const {
    const R cosine = dot(normal, direction), diffuse = cosine * R::inverse_pi();
    if constexpr (AllMaterials) {
      const R seen = max(-dot(normal, more.incident), R(1e-10f));
      const R rough = more.facets.distribution(normal, half(direction)) *
                      more.facets.visible(seen) / (R(4) * seen);
      return select(more.is_rough, select(cosine > R(0), rough, R(0)), diffuse);
    }
    return diffuse;
  }

  // A direction in proportion to f * cosine, of rough metals nearly, from u and v in the unit
  // square.
  HWY_INLINE BsdfSample<D> sample(V3<D> incident, R u, R v) const {
    return other_or(incident, u, v, sample_cosine_hemisphere(frame_around(normal), u, v));
  }

  // f * cosine / pdf of the directions that sample() takes, but for the sample's factor. A diffuse
  // surface's is (reflectance / pi) * cosine / (cosine / pi), a mirror's the same by the delta.
  HWY_INLINE V3<D> weight() const { return reflectance; }

  // The sample; where the surface is diffuse, that of the direction `scattered`.
  HWY_INLINE BsdfSample<D> other_or(V3<D> incident, R u, R v, V3<D> scattered) const {
    BsdfSample<D> sample{scattered, R(0), V3<D>(R(1))};
    if constexpr (AllMaterials) {
      if (more.is_rough.any()) reflect_roughly(u, v, sample);
    }
    sample.pdf = pdf(sample.direction);
    if (!is_specular.any()) return sample;
    const R twice = R(-2) * dot(normal, incident);
    sample.direction =
        select(is_specular, normalize(fma(normal, twice, incident)), sample.direction);
    sample.pdf = select(is_specular, R(delta<hn::TFromD<D>>), sample.pdf);
    if constexpr (AllMaterials) go_through(u, sample);
    return sample;
  }

  HWY_INLINE V3<D> half(V3<D> direction) const { return normalize(direction - more.incident); }

  HWY_INLINE void reflect_roughly(R u, R v, BsdfSample<D>& sample) const {
    const V3<D> mirror = more.facets.sample(normal, -more.incident, u, v);
    const R twice = R(-2) * dot(mirror, more.incident);
    const V3<D> direction = normalize(fma(mirror, twice, more.incident));
    const R cosine = max(dot(normal, direction), R(0));
    const R facing = max(dot(mirror, direction), R(0));
    const V3<D> factor = fresnel_of_metal(facing, more.eta, more.k) * more.facets.visible(cosine);
    sample.direction = select(more.is_rough, direction, sample.direction);
    sample.factor = select(more.is_rough, factor, sample.factor);
  }

  // Takes Fresnel's reflectance as the chance of reflection; Snell's law says where the rest goes.
  HWY_INLINE void go_through(R u, BsdfSample<D>& sample) const {
    const R cosine = max(-dot(normal, more.incident), R(1e-10f));
    const R inverse = R(1) / more.n;
    R beyond;
    const Bool<D> through = more.is_glass & (u >= fresnel_of_glass(cosine, more.n, beyond));
    const V3<D> onward = fma(more.incident, inverse, normal * (cosine * inverse - beyond));
    sample.direction = select(through, normalize(onward), sample.direction);
    const V3<D> factor = select(through, more.transmittance * (inverse * inverse), more.gloss);
    sample.factor = select(more.is_glass, factor, sample.factor);
  }
};

}  // namespace plumb::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
