// SPDX-License-Identifier: Apache-2.0

// Maps from the unit square to directions towards a lamp. All densities are with respect to solid
// angle, given that this lamp was chosen. `inverse_` means one over, here and everywhere.
#include "renderer/simd/warp-inl.h"

#if defined(PLUMB_SIMD_LAMPS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PLUMB_SIMD_LAMPS_INL_H
#undef PLUMB_SIMD_LAMPS_INL_H
#else
#define PLUMB_SIMD_LAMPS_INL_H
#endif

HWY_BEFORE_NAMESPACE();
namespace plumb::HWY_NAMESPACE {

// A direction from a shading point to a lamp.
template <class D>
struct LampSample {
  V3<D> direction;
  Real<D> distance;     // of the lamp's point
  Real<D> inverse_pdf;  // one over the direction's density
  Bool<D> visible;      // the shading point is on the lamp's bright side
};

// A rectangle seen from a point: the point is the origin, the rectangle is at height -z < 0 and
// spans [x0, x1] by [y0, y1].
template <class D>
struct SeenRectangle {
  Real<D> x0, x1, y0, y1, z;
  Real<D> zz, xx0;             // z^2, x0^2 + z^2
  Real<D> r00, r01, r10, r11;  // distances of the corners (x0, y0), (x0, y1), ...
  Real<D> solid_angle;

  // A rectangle seen this small is sampled by area: it is far and almost evenly bright, or seen
  // edge-on with next to no light. In float, so is one at distances above a million, where powers
  // leave the range of numbers: NaN counts as small. See docs/lamp-sampling.md.
  HWY_INLINE Bool<D> is_sampled_by_area() const { return !(solid_angle >= Real<D>(1e-8f)); }
};

// The solid angle is the sum of two triangles', each by van Oosterom and Strackee 1983:
// tan(omega / 2) = volume / denominator. The denominators cancel only beside a close edge or just
// under one: in float the relative error is up to 3e-4 where z is 1e-3 to 1e-2 of the distance to
// the far side, and 1e-2 where it is 1e-5 to 1e-4; 3e-6 in the mean. The other diagonal would not
// help; formulas that keep all digits take more divisions and square roots.
template <class D>
HWY_INLINE SeenRectangle<D> see_rectangle(const PackedLamp<hn::TFromD<D>>& lamp, V3<D> p) {
  using R = Real<D>;
  SeenRectangle<D> s;
  const V3<D> from_p = V3<D>(lamp.origin) - p;
  s.x0 = dot(from_p, V3<D>(lamp.x));
  s.y0 = dot(from_p, V3<D>(lamp.y));
  s.z = -dot(from_p, V3<D>(lamp.normal));
  s.x1 = s.x0 + lamp.x_length;
  s.y1 = s.y0 + lamp.y_length;
  s.zz = s.z * s.z;
  s.xx0 = fma(s.x0, s.x0, s.zz);
  const R yy0 = fma(s.y0, s.y0, s.zz);
  const R yy1 = fma(s.y1, s.y1, s.zz);
  s.r00 = sqrt(fma(s.x0, s.x0, yy0));
  s.r01 = sqrt(fma(s.x0, s.x0, yy1));
  s.r10 = sqrt(fma(s.x1, s.x1, yy0));
  s.r11 = sqrt(fma(s.x1, s.x1, yy1));

  // Triangles 00-10-11 and 00-11-01 share the diagonal; the dot products of their corners.
  const R d_00_10 = fma(s.x0, s.x1, yy0);
  const R d_00_01 = fma(s.y0, s.y1, s.xx0);
  const R d_00_11 = fma(s.x0, s.x1, fma(s.y0, s.y1, s.zz));
  const R d_10_11 = fma(s.y0, s.y1, fma(s.x1, s.x1, s.zz));
  const R d_01_11 = fma(s.x0, s.x1, yy1);
  const R volume = s.z * lamp.area;
  const R denominator1 =
      fma(fma(s.r00, s.r10, d_00_10), s.r11, fma(d_00_11, s.r10, d_10_11 * s.r00));
  const R denominator2 =
      fma(fma(s.r00, s.r01, d_00_01), s.r11, fma(d_00_11, s.r01, d_01_11 * s.r00));
  // Both half angles at once: the argument of a product of complex numbers.
  const R sine = volume * (denominator1 + denominator2);
  const R cosine = fma(denominator1, denominator2, -(volume * volume));
  s.solid_angle = R(2) * upper_atan2(sine, cosine);
  return s;
}

// sinh(asinh(y1 / rho) - asinh(y0 / rho)) = (y1 r0 - y0 r1) / rho^2 of an edge from y0 to y1 with
// ends at distances r0 and r1, on a line at distance rho. Where y0 and y1 have one sign, that
// difference cancels; expanding by the sum turns it into rho^2 (y1^2 - y0^2).
template <class D>
HWY_INLINE Real<D> edge_sinh(const SeenRectangle<D>& s, Real<D> r0, Real<D> r1, Real<D> rho2) {
  const Bool<D> one_sign = s.y0 * s.y1 > Real<D>(0);
  const Real<D> a = s.y1 * r0, b = s.y0 * r1;
  return select(one_sign, (s.y1 - s.y0) * (s.y1 + s.y0), a - b) / select(one_sign, a + b, rho2);
}

// A point of the rectangle, uniform in solid angle (the map of Ureña, Fajardo and King, "An
// Area-Preserving Parametrization for Spherical Rectangles", EGSR 2013, in other formulas).
//
// Let C be the solid angle of the strip from 0 to x, negative for x < 0, and q the edge_sinh() of
// its end. Up to a factor that does not depend on x,
//
//   sin C = x z q,  cos C = z^2 sqrt(1 + q^2) + y0 y1.
//
// So C is turned by a part of the solid angle; then the cosine tells q and the sine x. Both are
// those of x0 plus a change: small rectangles differ from a point by the change alone. But if q is
// far larger at x0 than at x, the changes cancel: where x0 is the close edge, C starts at x1, of
// the mirror image.
//
// In the paper's names: S is solid_angle, z0 is -z, phi_u is C + pi, cu is x / sqrt(xx), d is
// sqrt(xx); h0, h1 and hv are y0 / r0, y1 / r1 and y / r, of which h0 and h below are multiples.
template <class D>
HWY_INLINE void sample_solid_angle(const SeenRectangle<D>& s, Real<D> u, Real<D> v, Real<D>& x,
                                   Real<D>& y) {
  using R = Real<D>;
  const Bool<D> turned = s.x1 * s.x1 > R(16) * s.xx0;
  const R start = select(turned, -s.x1, s.x0);
  const R q0 = edge_sinh(s, select(turned, s.r10, s.r00), select(turned, s.r11, s.r01),
                         fma(start, start, s.zz));
  const R zz_cosh0 = s.zz * sqrt(fma(q0, q0, R(1)));
  const R sin0 = start * s.z * q0;
  const R cos0 = fma(s.y0, s.y1, zz_cosh0);
  const R half = select(turned, R(1) - u, u) * s.solid_angle * R(0.5f);
  const R sin_half = sin(half), cos_half = cos(half), twice = sin_half + sin_half;
  const R sin_c = fma(twice, fma(cos0, cos_half, -(sin0 * sin_half)), sin0);
  const R cos_change = -(twice * fma(sin0, cos_half, cos0 * sin_half));
  // (z^2 q)^2 = (z^2 sqrt(1 + q^2))^2 - z^4, from that at x0.
  const R zz_q0 = s.zz * q0;
  const R square = fma(cos_change, zz_cosh0 + zz_cosh0 + cos_change, zz_q0 * zz_q0);
  x = s.z * sin_c / sqrt(max(square, R(0)));
  x = min(max(select(turned, -x, x), s.x0), s.x1);

  // The sine y / r goes evenly from y0 / r0 to y1 / r1. Times r0 r1 it is h, its change q xx.
  const R xx = fma(x, x, s.zz);
  const R rr1 = fma(s.y1, s.y1, xx);
  const R r0 = sqrt(fma(s.y0, s.y0, xx)), r1 = sqrt(rr1);
  const R step = v * edge_sinh(s, r0, r1, xx);
  const R h0 = s.y0 * r1;
  const R h = fma(step, xx, h0);
  // y = h sqrt(xx) / sqrt((r0 r1)^2 - h^2), and (r0 r1)^2 - h0^2 = r1^2 xx.
  y = h / sqrt(max(fma(-step, h0 + h, rr1), R(0)));
  y = min(max(y, s.y0), s.y1);
}

// One over the density with respect to solid angle of points that are uniform over the lamp's area,
// for a point at that distance from a shading point at that height over the lamp's plane.
template <class D>
HWY_INLINE Real<D> inverse_area_pdf(const PackedLamp<hn::TFromD<D>>& lamp, Real<D> height,
                                    Real<D> inverse_distance) {
  return height * Real<D>(lamp.area) * (inverse_distance * inverse_distance * inverse_distance);
}

template <class D>
HWY_INLINE Real<D> inverse_rectangle_pdf(const PackedLamp<hn::TFromD<D>>& lamp,
                                         const SeenRectangle<D>& s, Real<D> inverse_distance) {
  return select(s.is_sampled_by_area(), inverse_area_pdf(lamp, s.z, inverse_distance),
                s.solid_angle);
}

template <class D>
HWY_INLINE LampSample<D> sample_rectangle(const PackedLamp<hn::TFromD<D>>& lamp, V3<D> p, Real<D> u,
                                          Real<D> v) {
  const SeenRectangle<D> s = see_rectangle<D>(lamp, p);
  Real<D> x, y;
  sample_solid_angle(s, u, v, x, y);
  x = select(s.is_sampled_by_area(), fma(u, Real<D>(lamp.x_length), s.x0), x);
  y = select(s.is_sampled_by_area(), fma(v, Real<D>(lamp.y_length), s.y0), y);
  const Real<D> distance = sqrt(fma(x, x, fma(y, y, s.zz)));
  const Real<D> inverse = Real<D>(1) / distance;
  const V3<D> to_lamp = fma(V3<D>(lamp.x), x, fma(V3<D>(lamp.y), y, V3<D>(lamp.normal) * -s.z));
  return {to_lamp * inverse, distance, inverse_rectangle_pdf(lamp, s, inverse), s.z > Real<D>(0)};
}

// A triangle seen from a point: unit vectors to its corners, and its height above the point's
// horizon of the lamp, as `z` of a rectangle.
template <class D>
struct SeenTriangle {
  V3<D> a, b, c;
  Real<D> volume;      // dot(a, cross(b, c)), from the triangle's own area: no digits cancel
  Real<D> complement;  // 1 + dot(a, b) + dot(b, c) + dot(c, a)
  Real<D> solid_angle;
  Real<D> z;

  // As for rectangles; the map below also needs the digits that float has left.
  HWY_INLINE Bool<D> is_sampled_by_area() const {
    const bool is_float = sizeof(hn::TFromD<D>) == sizeof(float);
    return !(solid_angle >= Real<D>(is_float ? 1e-3f : 1e-8f));
  }
};

// By van Oosterom and Strackee 1983, as see_rectangle().
template <class D>
HWY_INLINE SeenTriangle<D> see_triangle(const PackedLamp<hn::TFromD<D>>& lamp, V3<D> p) {
  using R = Real<D>;
  SeenTriangle<D> s;
  const V3<D> a = V3<D>(lamp.origin) - p, b = a + V3<D>(lamp.x), c = a + V3<D>(lamp.y);
  const R ra = R(1) / sqrt(dot(a, a)), rb = R(1) / sqrt(dot(b, b)), rc = R(1) / sqrt(dot(c, c));
  s.a = a * ra;
  s.b = b * rb;
  s.c = c * rc;
  s.z = -dot(a, V3<D>(lamp.normal));
  s.volume = s.z * R(2 * lamp.area) * (ra * rb * rc);
  s.complement = R(1) + dot(s.a, s.b) + dot(s.b, s.c) + dot(s.c, s.a);
  s.solid_angle = R(2) * upper_atan2(s.volume, s.complement);
  return s;
}

// A direction to the triangle, uniform in solid angle (Arvo, "Stratified Sampling of Spherical
// Triangles", SIGGRAPH 1995, in the formulas of Peters, "BRDF Importance Sampling for Polygonal
// Lights", SIGGRAPH 2021): the triangle a, b, c' with c' on the edge from a to c has the share u of
// the solid angle, and the direction lies on the arc from b to c'.
template <class D>
HWY_INLINE V3<D> sample_solid_angle(const SeenTriangle<D>& s, Real<D> u, Real<D> v) {
  using R = Real<D>;
  const R half = u * s.solid_angle * R(0.5f);
  const R sine = sin(half), cosine = cos(half);
  const R ac_bc = dot(s.a, s.c) + dot(s.b, s.c);
  const R along_a = fma(s.volume, cosine, -(ac_bc * sine));
  const V3<D> toward = fma(s.a, along_a, s.c * ((R(1) + dot(s.a, s.b)) * sine));
  const V3<D> c = fma(toward, R(2) * dot(s.a, toward) / dot(toward, toward), -s.a);
  // The cosine to b goes evenly from 1 to that of c'.
  const R cosine_c = dot(s.b, c);
  const R away = v * (R(1) - cosine_c);
  const R ratio = away * (R(2) - away) / max((R(1) - cosine_c) * (R(1) + cosine_c), R(1e-30f));
  const R part = sqrt(max(ratio, R(0)));
  return normalize(fma(s.b, (R(1) - away) - part * cosine_c, c * part));
}

template <class D>
HWY_INLINE Real<D> inverse_triangle_pdf(const PackedLamp<hn::TFromD<D>>& lamp,
                                        const SeenTriangle<D>& s, Real<D> inverse_distance) {
  return select(s.is_sampled_by_area(), inverse_area_pdf(lamp, s.z, inverse_distance),
                s.solid_angle);
}

template <class D>
HWY_INLINE LampSample<D> sample_triangle(const PackedLamp<hn::TFromD<D>>& lamp, V3<D> p, Real<D> u,
                                         Real<D> v) {
  using R = Real<D>;
  const SeenTriangle<D> s = see_triangle<D>(lamp, p);
  const V3<D> direction = sample_solid_angle(s, u, v);
  const R root = sqrt(u);
  const V3<D> on_lamp = fma(V3<D>(lamp.x), R(1) - root, V3<D>(lamp.y) * (v * root));
  const V3<D> to_lamp = V3<D>(lamp.origin) + on_lamp - p;
  const R to_plane = s.z / -dot(direction, V3<D>(lamp.normal));
  const Bool<D> by_area = s.is_sampled_by_area() | !(to_plane > R(0));
  const R distance = select(by_area, sqrt(dot(to_lamp, to_lamp)), to_plane);
  const R inverse = R(1) / distance;
  return {select(by_area, to_lamp * inverse, direction), distance,
          inverse_triangle_pdf(lamp, s, inverse), s.z > R(0)};
}

// The cone of directions in which a sphere is seen, sampled uniformly (Shirley, Wang and Zimmerman,
// "Monte Carlo Techniques for Direct Lighting Calculations", ACM TOG 15(1), 1996). Its opening,
// 1 - cos(theta), keeps all its digits for tiny or far spheres.
template <class D>
struct SeenSphere {
  V3<D> axis;
  Real<D> distance;  // of the centre
  Real<D> opening;

  HWY_INLINE Real<D> solid_angle() const { return (Real<D>::pi() + Real<D>::pi()) * opening; }
};

template <class D>
HWY_INLINE SeenSphere<D> see_sphere(const PackedLamp<hn::TFromD<D>>& lamp, V3<D> p) {
  using R = Real<D>;
  const R radius(lamp.radius);
  const V3<D> to_center = V3<D>(lamp.origin) - p;
  const R distance = sqrt(dot(to_center, to_center));
  const R inverse = R(1) / distance;
  const R sine = radius * inverse;
  const R cosine = sqrt(max((distance - radius) * (distance + radius), R(0))) * inverse;
  return {to_center * inverse, distance, sine * sine / (R(1) + cosine)};
}

template <class D>
HWY_INLINE LampSample<D> sample_sphere(const PackedLamp<hn::TFromD<D>>& lamp, V3<D> p, Real<D> u,
                                       Real<D> v) {
  using R = Real<D>;
  const SeenSphere<D> s = see_sphere<D>(lamp, p);
  const R opening = u * s.opening;
  const R cosine = R(1) - opening;
  const R squared_sine = opening * (R(1) + cosine);
  const R radius(lamp.radius);
  const R half_chord =
      sqrt(max(fma(radius, radius, -(s.distance * s.distance * squared_sine)), R(0)));
  return {spherical_direction(frame_around(s.axis), cosine, sqrt(squared_sine), v),
          fma(s.distance, cosine, -half_chord), s.solid_angle(), s.distance > radius};
}

// One over the squared distance is what its intensity is multiplied by: no density's inverse, but
// in its place.
template <class D>
HWY_INLINE LampSample<D> sample_point(const PackedLamp<hn::TFromD<D>>& lamp, V3<D> p) {
  using R = Real<D>;
  const V3<D> to_lamp = V3<D>(lamp.origin) - p;
  const R distance = sqrt(dot(to_lamp, to_lamp)), inverse = R(1) / distance;
  return {to_lamp * inverse, distance, inverse * inverse, distance > R(0)};
}

// The sky above a surface, by the cosine to its normal.
template <class D>
HWY_INLINE LampSample<D> sample_sky(V3<D> normal, Real<D> u, Real<D> v) {
  using R = Real<D>;
  const V3<D> direction = sample_cosine_hemisphere(frame_around(normal), u, v);
  return {direction, R(hwy::HighestValue<hn::TFromD<D>>()), R::pi() / dot(normal, direction),
          !Bool<D>::none()};
}

template <class D>
HWY_INLINE LampSample<D> sample_lamp(const PackedLamp<hn::TFromD<D>>& lamp, V3<D> p, Real<D> u,
                                     Real<D> v) {
  using Kind = typename PackedLamp<hn::TFromD<D>>::Kind;
  if (lamp.kind == Kind::sphere) return sample_sphere(lamp, p, u, v);
  if (lamp.kind == Kind::point) return sample_point(lamp, p);
  return lamp.kind == Kind::triangle ? sample_triangle(lamp, p, u, v)
                                     : sample_rectangle(lamp, p, u, v);
}

// A point of a lamp, uniform by area, and the direction to which it shines.
template <class D>
struct LampPoint {
  V3<D> point, normal;
};

template <class D>
HWY_INLINE LampPoint<D> sample_area(const PackedLamp<hn::TFromD<D>>& lamp, Real<D> u, Real<D> v) {
  using R = Real<D>;
  using Kind = typename PackedLamp<hn::TFromD<D>>::Kind;
  const V3<D> origin(lamp.origin), normal(lamp.normal);
  if (lamp.kind == Kind::rectangle) {
    const R x = u * R(lamp.x_length), y = v * R(lamp.y_length);
    return {fma(V3<D>(lamp.x), x, fma(V3<D>(lamp.y), y, origin)), normal};
  }
  if (lamp.kind == Kind::triangle) {
    const R root = sqrt(u);
    return {origin + fma(V3<D>(lamp.x), R(1) - root, V3<D>(lamp.y) * (v * root)), normal};
  }
  const R cosine = R(1) - (u + u);
  const Frame<D> axes = frame_around(V3<D>(R(0), R(0), R(1)));
  const R sine = sqrt(max(fma(-cosine, cosine, R(1)), R(0)));
  const V3<D> outward = spherical_direction(axes, cosine, sine, v);
  return {fma(outward, R(lamp.radius), origin), outward};
}

// In proportion to this a lamp is chosen at p: about the light that it sends there if nothing is in
// the way, strength * cosine / distance^2. Never 0 where it sends light; bounded near the lamp,
// whose middle tells little there.
template <class D>
HWY_INLINE Real<D> choice_weight(const PackedLamp<hn::TFromD<D>>& lamp, V3<D> p) {
  using R = Real<D>;
  using Kind = typename PackedLamp<hn::TFromD<D>>::Kind;
  if (lamp.kind == Kind::sky) return R(lamp.strength);
  const V3<D> from_middle = p - V3<D>(lamp.middle);
  const R squared = dot(from_middle, from_middle), reach(lamp.squared_reach);
  if (lamp.kind == Kind::sphere || lamp.kind == Kind::point) {
    return select(squared > reach, R(lamp.strength) / squared, R(0));
  }
  const R height = dot(from_middle, V3<D>(lamp.normal));
  const R cosine = height / sqrt(squared);
  const R weight = R(lamp.strength) * (R(0.1f) + cosine) / (squared + reach);
  return select(height > R(0), weight, R(0));
}

// One over the density with which sample_lamp() from p, on the lamp's bright side, yields the
// lamp's point at that distance.
template <class D>
HWY_INLINE Real<D> inverse_lamp_pdf(const PackedLamp<hn::TFromD<D>>& lamp, V3<D> p,
                                    Real<D> distance) {
  using Kind = typename PackedLamp<hn::TFromD<D>>::Kind;
  const Real<D> inverse = Real<D>(1) / distance;
  if (lamp.kind == Kind::sphere) return see_sphere(lamp, p).solid_angle();
  return lamp.kind == Kind::triangle
             ? inverse_triangle_pdf(lamp, see_triangle<D>(lamp, p), inverse)
             : inverse_rectangle_pdf(lamp, see_rectangle<D>(lamp, p), inverse);
}

}  // namespace plumb::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
