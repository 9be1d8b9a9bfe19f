// SPDX-License-Identifier: Apache-2.0

// Light that goes from a lamp to a surface by way of one mirror: where the mirror reflects it, and
// how the beam spreads.
#include "renderer/simd/real-inl.h"

#if defined(PLUMB_SIMD_MIRRORS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PLUMB_SIMD_MIRRORS_INL_H
#undef PLUMB_SIMD_MIRRORS_INL_H
#else
#define PLUMB_SIMD_MIRRORS_INL_H
#endif

HWY_BEFORE_NAMESPACE();
namespace plumb::HWY_NAMESPACE {

// A thin beam from a point to a mirror and onwards. Of the solid angle dw at the point it has, at
// the distance b behind the mirror, the cross-section dw * squared_distance(b).
//
// With a the distance to the mirror, t the angle of incidence and R the radius of a convex sphere,
// infinite for a plane, that is (a + b + 2ab / (R cos t)) * (a + b + 2ab cos t / R): the two
// curvatures of the reflected wave front (Mitchell and Hanrahan, "Illumination from Curved
// Reflectors", SIGGRAPH 1992).
template <class D>
struct Beam {
  Real<D> to_mirror;
  Real<D> in_plane, across;  // how much faster it spreads, in the plane of incidence and across

  Beam() = default;
  HWY_INLINE Beam(Real<D> distance, Real<D> cosine, Real<D> curvature) : to_mirror(distance) {
    const Real<D> bend = (distance + distance) * curvature;
    in_plane = Real<D>(1) + bend / cosine;
    across = fma(bend, cosine, Real<D>(1));
  }

  HWY_INLINE Real<D> squared_distance(Real<D> b) const {
    return fma(b, in_plane, to_mirror) * fma(b, across, to_mirror);
  }
};

// The way from x to the mirror's point p and on to y. Directions are of unit length.
template <class D>
struct Reflection {
  V3<D> direction;  // from x to p
  V3<D> point;      // p
  V3<D> onward;     // from p to y
  Real<D> to_lamp;  // from p to y
  Beam<D> beam;
  Bool<D> exists;
};

// The image of y in the plane, seen from x through the face. The face's edges are at right angles
// to the plane, so the point of the face lies, between x's and y's distances from an edge, where it
// lies between their heights.
template <class D, typename T>
HWY_INLINE Reflection<D> reflect_in_plane(const PackedMirror<T>& mirror, Bool<D> receives, V3<D> x,
                                          V3<D> y) {
  using R = Real<D>;
  const V3<D> normal(mirror.face.plane.normal);
  const auto height = [](const Plane<T>& plane, V3<D> p) {
    return dot(V3<D>(plane.normal), p) + R(plane.offset);
  };
  const R at_x = height(mirror.face.plane, x), at_y = height(mirror.face.plane, y);
  R outside = -at_x * at_y;
  for (const Plane<T>& edge : mirror.face.edges) {
    outside = max(outside, fma(height(edge, x), abs(at_y), height(edge, y) * abs(at_x)));
  }
  Reflection<D> way;
  way.exists = receives & (outside < R(0));
  if (!mirror.two_sided) way.exists = way.exists & (at_x > R(0));
  if (!way.exists.any()) return way;
  const V3<D> to_image = fma(normal, R(-2) * at_y, y) - x;
  const R distance = sqrt(dot(to_image, to_image));
  const R to_mirror = distance * (at_x / (at_x + at_y));
  way.direction = to_image * (R(1) / distance);
  way.point = fma(way.direction, to_mirror, x);
  way.onward = fma(normal, R(-2) * dot(normal, way.direction), way.direction);
  way.to_lamp = distance - to_mirror;
  way.beam = Beam<D>(to_mirror, R(1), R(0));
  return way;
}

// The point of a sphere that reflects y to x (Alhazen's problem), where both are outside and
// nothing of the sphere is between them. Seen from the centre let x and y be at the distances 1 / a
// and 1 / b, in radii, and at an angle; the point is in between, at the angle f from x and g from
// y, where
//
//   sin(f - g) - b sin f + a sin g = 0.
//
// That is solved by Newton's method on unit vectors in the plane of the three, x the first axis. A
// step that would leave what is known to contain the root halves that instead. Lanes stop by
// themselves, so that none depends on the others.
template <class D, typename T>
HWY_INLINE Reflection<D> reflect_in_sphere(const PackedMirror<T>& mirror, Bool<D> receives, V3<D> x,
                                           V3<D> y) {
  using R = Real<D>;
  const V3<D> center(mirror.sphere.center);
  const R radius(mirror.sphere.radius);
  const V3<D> from_x = x - center, from_y = y - center;
  const R far_x = R(1) / sqrt(dot(from_x, from_x)), far_y = R(1) / sqrt(dot(from_y, from_y));
  const R a = radius * far_x, b = radius * far_y;
  const V3<D> first = from_x * far_x;
  const R y_cos = dot(first, from_y) * far_y;
  const V3<D> aside = fma(first, -y_cos, from_y * far_y);
  const R y_sin = sqrt(dot(aside, aside));
  const V3<D> second = aside * (R(1) / max(y_sin, R(T{1e-30f})));
  Reflection<D> way;
  // The angle between x and y is less than both horizons'.
  const R horizons = sqrt(max((R(1) - a * a) * (R(1) - b * b), R(0)));
  way.exists = receives & (a < R(1)) & (b < R(1)) & (y_cos > a * b - horizons);
  if (!way.exists.any()) return way;

  R c = (R(1) - b) + y_cos * (R(1) - a), s = y_sin * (R(1) - a);
  R inverse = R(1) / sqrt(fma(c, c, s * s));
  c = c * inverse;
  s = s * inverse;
  R low_c(1), low_s(0), high_c = y_cos, high_s = y_sin;
  Bool<D> searches = way.exists;
  constexpr T enough =
      sizeof(T) == sizeof(float) ? T{1e-3f} : T{1e-8f};  // the error is about its square
  for (int step = 0; step < 12 && searches.any(); ++step) {
    const R sin_g = y_sin * c - y_cos * s, cos_g = fma(y_cos, c, y_sin * s);
    const R value = fma(s, cos_g - b, -(sin_g * (c - a)));
    const R slope = R(2) * fma(c, cos_g, s * sin_g) - fma(b, c, a * cos_g);
    const Bool<D> above = value > R(0);
    low_c = select(above, low_c, c);
    low_s = select(above, low_s, s);
    high_c = select(above, c, high_c);
    high_s = select(above, s, high_s);
    const R angle = -value / slope;
    R next_c = c - angle * s, next_s = fma(angle, c, s);
    const Bool<D> between =
        (low_c * next_s >= low_s * next_c) & (next_c * high_s >= next_s * high_c);
    next_c = select(between, next_c, low_c + high_c);
    next_s = select(between, next_s, low_s + high_s);
    inverse = R(1) / sqrt(fma(next_c, next_c, next_s * next_s));
    c = select(searches, next_c * inverse, c);
    s = select(searches, next_s * inverse, s);
    searches = searches & !(between & (abs(angle) < R(enough)));
  }
  const V3<D> normal = fma(first, c, second * s);
  way.point = fma(normal, radius, center);
  const V3<D> to_point = way.point - x, to_y = y - way.point;
  const R to_mirror = sqrt(dot(to_point, to_point));
  way.to_lamp = sqrt(dot(to_y, to_y));
  way.direction = to_point * (R(1) / to_mirror);
  way.onward = to_y * (R(1) / way.to_lamp);
  const R cosine = -dot(normal, way.direction);
  way.exists = way.exists & (cosine > R(0));
  way.beam = Beam<D>(to_mirror, cosine, R(1) / radius);
  return way;
}

template <class D, typename T>
HWY_INLINE Reflection<D> reflect(const PackedMirror<T>& mirror, Bool<D> receives, V3<D> x,
                                 V3<D> y) {
  return mirror.is_sphere ? reflect_in_sphere(mirror, receives, x, y)
                          : reflect_in_plane(mirror, receives, x, y);
}

}  // namespace plumb::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
