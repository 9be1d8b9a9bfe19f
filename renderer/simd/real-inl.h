// SPDX-License-Identifier: Apache-2.0

// Numbers, truth values and three-vectors in SIMD lanes, with the notation of formulas.
//
// a * b + c rounds twice; fma(a, b, c) once. No other operation is fused (see CMakeLists.txt), so
// all instruction sets with fused multiply-add give the same bits.
#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include "renderer/packed_scene.h"

#if defined(PLUMB_SIMD_REAL_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PLUMB_SIMD_REAL_INL_H
#undef PLUMB_SIMD_REAL_INL_H
#else
#define PLUMB_SIMD_REAL_INL_H
#endif

HWY_BEFORE_NAMESPACE();
namespace plumb::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
struct Bool {
  hn::Mask<D> m;

  static HWY_INLINE Bool none() { return {hn::MaskFromVec(hn::Zero(D()))}; }
  HWY_INLINE bool any() const { return !hn::AllFalse(D(), m); }
  HWY_INLINE int64_t count() const { return static_cast<int64_t>(hn::CountTrue(D(), m)); }

  friend HWY_INLINE Bool operator&(Bool a, Bool b) { return {hn::And(a.m, b.m)}; }
  friend HWY_INLINE Bool operator|(Bool a, Bool b) { return {hn::Or(a.m, b.m)}; }
  friend HWY_INLINE Bool operator!(Bool a) { return {hn::Not(a.m)}; }
};

template <class D>
struct Real {
  using T = hn::TFromD<D>;
  hn::Vec<D> v;

  Real() = default;
  HWY_INLINE Real(hn::Vec<D> lanes) : v(lanes) {}
  HWY_INLINE Real(T value) : v(hn::Set(D(), value)) {}

  friend HWY_INLINE Real operator+(Real a, Real b) { return hn::Add(a.v, b.v); }
  friend HWY_INLINE Real operator-(Real a, Real b) { return hn::Sub(a.v, b.v); }
  friend HWY_INLINE Real operator*(Real a, Real b) { return hn::Mul(a.v, b.v); }
  friend HWY_INLINE Real operator/(Real a, Real b) { return hn::Div(a.v, b.v); }
  friend HWY_INLINE Real operator-(Real a) { return hn::Neg(a.v); }
  friend HWY_INLINE Bool<D> operator<(Real a, Real b) { return {hn::Lt(a.v, b.v)}; }
  friend HWY_INLINE Bool<D> operator>(Real a, Real b) { return {hn::Gt(a.v, b.v)}; }
  friend HWY_INLINE Bool<D> operator<=(Real a, Real b) { return {hn::Le(a.v, b.v)}; }
  friend HWY_INLINE Bool<D> operator>=(Real a, Real b) { return {hn::Ge(a.v, b.v)}; }
  friend HWY_INLINE Bool<D> operator==(Real a, Real b) { return {hn::Eq(a.v, b.v)}; }
  friend HWY_INLINE Bool<D> operator!=(Real a, Real b) { return {hn::Ne(a.v, b.v)}; }

  friend HWY_INLINE Real fma(Real a, Real b, Real c) { return hn::MulAdd(a.v, b.v, c.v); }
  // c - a * b and -(a * b) - c, rounded once.
  friend HWY_INLINE Real fnma(Real a, Real b, Real c) { return hn::NegMulAdd(a.v, b.v, c.v); }
  friend HWY_INLINE Real fnms(Real a, Real b, Real c) { return hn::NegMulSub(a.v, b.v, c.v); }
  friend HWY_INLINE Real sqrt(Real a) { return hn::Sqrt(a.v); }
  friend HWY_INLINE Real abs(Real a) { return hn::Abs(a.v); }
  friend HWY_INLINE Real min(Real a, Real b) { return hn::Min(a.v, b.v); }
  friend HWY_INLINE Real max(Real a, Real b) { return hn::Max(a.v, b.v); }
  friend HWY_INLINE Real sin(Real a) { return hn::Sin(D(), a.v); }
  friend HWY_INLINE Real cos(Real a) { return hn::Cos(D(), a.v); }
  // a, with its sign changed where b's sign bit is set.
  friend HWY_INLINE Real flip(Real a, Real b) {
    return hn::Xor(a.v, hn::And(b.v, hn::SignBit(D())));
  }
  friend HWY_INLINE Bool<D> sign_bit(Real a) {
    const hn::RebindToSigned<D> di;
    return {hn::RebindMask(D(), hn::Lt(hn::BitCast(di, a.v), hn::Zero(di)))};
  }
  friend HWY_INLINE Real select(Bool<D> mask, Real yes, Real no) {
    return hn::IfThenElse(mask.m, yes.v, no.v);
  }
  // The angle of the point (x, y) seen from the x axis, from 0 to pi. Where y is not above 0, it is
  // the axis' own: pi for x < 0, else 0, at the origin too.
  friend HWY_INLINE Real upper_atan2(Real y, Real x) {
    const Real angle = Real(hn::Atan(D(), (y / x).v)) + select(x < Real(0), pi(), Real(0));
    return select(y > Real(0), angle, select(x < Real(0), pi(), Real(0)));
  }
  static HWY_INLINE Real pi() { return Real(static_cast<T>(3.14159265358979323846)); }
  static HWY_INLINE Real inverse_pi() { return Real(static_cast<T>(0.31830988618379067154)); }
};

template <class D>
struct V3 {
  using R = Real<D>;
  R x, y, z;

  V3() = default;
  HWY_INLINE V3(R a, R b, R c) : x(a), y(b), z(c) {}
  HWY_INLINE explicit V3(R a) : x(a), y(a), z(a) {}
  HWY_INLINE V3(const PackedVec3<typename R::T>& v) : x(v.x), y(v.y), z(v.z) {}

  friend HWY_INLINE V3 operator+(V3 a, V3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend HWY_INLINE V3 operator-(V3 a, V3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend HWY_INLINE V3 operator*(V3 a, V3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
  friend HWY_INLINE V3 operator*(V3 a, R s) { return {a.x * s, a.y * s, a.z * s}; }
  friend HWY_INLINE V3 operator-(V3 a) { return {-a.x, -a.y, -a.z}; }
  friend HWY_INLINE V3 fma(V3 a, R s, V3 b) {
    return {fma(a.x, s, b.x), fma(a.y, s, b.y), fma(a.z, s, b.z)};
  }
  friend HWY_INLINE R dot(V3 a, V3 b) { return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z)); }
  friend HWY_INLINE V3 normalize(V3 a) { return a * (R(1) / sqrt(dot(a, a))); }
  friend HWY_INLINE V3 select(Bool<D> mask, V3 yes, V3 no) {
    return {select(mask, yes.x, no.x), select(mask, yes.y, no.y), select(mask, yes.z, no.z)};
  }
};

}  // namespace plumb::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
