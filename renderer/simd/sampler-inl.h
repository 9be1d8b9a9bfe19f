// SPDX-License-Identifier: Apache-2.0

// Random numbers from counters: a number depends on pixel, sample, dimension and seed, and on
// nothing that happened before.
#include "renderer/film.h"
#include "renderer/settings.h"
#include "renderer/simd/real-inl.h"

#if defined(PLUMB_SIMD_SAMPLER_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PLUMB_SIMD_SAMPLER_INL_H
#undef PLUMB_SIMD_SAMPLER_INL_H
#else
#define PLUMB_SIMD_SAMPLER_INL_H
#endif

HWY_BEFORE_NAMESPACE();
namespace plumb::HWY_NAMESPACE {

// 32-bit integers modulo 2^32, as many lanes as D has.
template <class D>
struct Bits {
  using DU = hn::Rebind<uint32_t, D>;
  hn::Vec<DU> v;

  Bits() = default;
  HWY_INLINE Bits(hn::Vec<DU> lanes) : v(lanes) {}
  HWY_INLINE Bits(uint32_t value) : v(hn::Set(DU(), value)) {}

  friend HWY_INLINE Bits operator+(Bits a, Bits b) { return hn::Add(a.v, b.v); }
  friend HWY_INLINE Bits operator*(Bits a, Bits b) { return hn::Mul(a.v, b.v); }
  friend HWY_INLINE Bits operator^(Bits a, Bits b) { return hn::Xor(a.v, b.v); }
  friend HWY_INLINE Bits operator&(Bits a, Bits b) { return hn::And(a.v, b.v); }
  friend HWY_INLINE Bits operator|(Bits a, Bits b) { return hn::Or(a.v, b.v); }
  template <int bits>
  HWY_INLINE Bits right() const {
    return hn::ShiftRight<bits>(v);
  }
  template <int bits>
  HWY_INLINE Bits left() const {
    return hn::ShiftLeft<bits>(v);
  }
};

template <class D>
struct Hash3 {
  Bits<D> x, y, z;
};

// pcg3d of Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 9(3), 2020: a bijection of
// 96 bits.
template <class D>
HWY_INLINE Hash3<D> pcg3d(Bits<D> x, Bits<D> y, Bits<D> z) {
  x = x * 1664525u + 1013904223u;
  y = y * 1664525u + 1013904223u;
  z = z * 1664525u + 1013904223u;
  x = x + y * z;
  y = y + z * x;
  z = z + x * y;
  x = x ^ x.template right<16>();
  y = y ^ y.template right<16>();
  z = z ^ z.template right<16>();
  x = x + y * z;
  y = y + z * x;
  z = z + x * y;
  return {x, y, z};
}

// A bijection of 32 bits: lowbias32 of Wellons, "Prospecting for Hash Functions", 2018.
template <class D>
HWY_INLINE Bits<D> mix(Bits<D> v) {
  v = (v ^ v.template right<16>()) * 0x7feb352du;
  v = (v ^ v.template right<15>()) * 0x846ca68bu;
  return v ^ v.template right<16>();
}

template <class D>
HWY_INLINE Bits<D> reverse_bits(Bits<D> v) {
  using DU = typename Bits<D>::DU;
  const hn::Repartition<uint8_t, DU> bytes;
  alignas(16) static constexpr uint8_t reversed_nibble[16] = {0, 8, 4, 12, 2, 10, 6, 14,
                                                              1, 9, 5, 13, 3, 11, 7, 15};
  alignas(16) static constexpr uint8_t reversed_bytes[16] = {3,  2,  1, 0, 7,  6,  5,  4,
                                                             11, 10, 9, 8, 15, 14, 13, 12};
  // A table as long as its block, also for vectors that are shorter.
  const hn::FixedTag<uint8_t, HWY_MAX(16, hn::MaxLanes(bytes))> blocks;
  const auto table = hn::LoadDup128(blocks, reversed_nibble);
  const auto low = hn::BitCast(bytes, (v & 0x0f0f0f0fu).v);
  const auto high = hn::BitCast(bytes, (v.template right<4>() & 0x0f0f0f0fu).v);
  const Bits<D> from_low = hn::BitCast(DU(), hn::TableLookupBytes(table, low));
  const Bits<D> from_high = hn::BitCast(DU(), hn::TableLookupBytes(table, high));
  const auto swapped = hn::BitCast(bytes, (from_low.template left<4>() | from_high).v);
  return hn::BitCast(DU(), hn::TableLookupBytes(swapped, hn::LoadDup128(bytes, reversed_bytes)));
}

// A random tree of digit flips, from the lowest bit up: bit i of the result depends on bits 0 to i.
// Between two reversals of the bits this is Owen's scramble (Laine and Karras 2011; Burley,
// "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020; the constants are Vegdahl's, "Building a
// Better LK Hash", 2021).
template <class D>
HWY_INLINE Bits<D> laine_karras_permutation(Bits<D> v, Bits<D> seed) {
  v = v ^ v * 0x3d20adeau;
  v = v + seed;
  v = v * (seed.template right<16>() | 1u);
  v = v ^ v * 0x05526c56u;
  return v ^ v * 0x53a22864u;
}

// The second dimension of Sobol's sequence at index v, as bits in reverse order. Its generator
// matrix is Pascal's triangle modulo 2 (Sobol' 1967; direction numbers of Joe and Kuo 2008): bit k
// is the sum of those bits j for which k's binary digits are a subset of j's.
template <class D>
HWY_INLINE Bits<D> sobol_second_dimension(Bits<D> v) {
  v = v ^ (v.template right<1>() & 0x55555555u);
  v = v ^ (v.template right<2>() & 0x33333333u);
  v = v ^ (v.template right<4>() & 0x0f0f0f0fu);
  v = v ^ (v.template right<8>() & 0x00ff00ffu);
  return v ^ v.template right<16>();
}

// Templates, so that double need not be there where it isn't used: some targets lack it.
template <class D>
HWY_INLINE Real<D> to_unit_interval(Bits<D> bits) {
  using T = hn::TFromD<D>;
  const D d;
  if constexpr (sizeof(T) == sizeof(float)) {
    const auto whole = hn::BitCast(hn::RebindToSigned<D>(), bits.template right<8>().v);
    return hn::Mul(hn::ConvertTo(d, whole), hn::Set(d, unit_interval_step<T>));
  } else {
    const auto whole = hn::BitCast(hn::Rebind<int32_t, D>(), bits.template right<1>().v);
    return hn::Mul(hn::PromoteTo(d, whole), hn::Set(d, unit_interval_step<T>));
  }
}

// Small whole numbers as bits.
template <class D>
HWY_INLINE Bits<D> to_bits(Real<D> a) {
  const typename Bits<D>::DU du;
  if constexpr (sizeof(hn::TFromD<D>) == sizeof(float)) {
    return hn::BitCast(du, hn::ConvertTo(hn::RebindToSigned<D>(), a.v));
  } else {
    return hn::BitCast(du, hn::DemoteTo(hn::Rebind<int32_t, D>(), a.v));
  }
}

// A point in the unit square, [0, 1) each, and a third number, independent of both.
template <class D>
struct Sample {
  Real<D> u, v, w;
};

// The samples that the lanes are at.
template <class D>
struct SampleIndex {
  Bits<D> pixel;
  Bits<D> replicate;
  Bits<D> index;  // within the replicate
  Bits<D> seed;   // of the render, mixed: those of two renders must not be neighbours
};

// Sobol pairs are padded: pair after pair uses the first two dimensions in an order (a shuffle of
// the index) and with a scramble of its own (Burley 2020).
template <class D>
HWY_INLINE Sample<D> draw_sobol(const SampleIndex<D>& s, Bits<D> pair) {
  const Hash3<D> hash = pcg3d(s.pixel, s.replicate, s.seed + pair);
  const Bits<D> index = reverse_bits(laine_karras_permutation(reverse_bits(s.index), hash.x));
  const Bits<D> u = reverse_bits(laine_karras_permutation(index, hash.y));
  const Bits<D> v = reverse_bits(laine_karras_permutation(sobol_second_dimension(index), hash.z));
  const Bits<D> w = mix(s.index * 0x9e3779b9u + hash.x);
  return {to_unit_interval(u), to_unit_interval(v), to_unit_interval(w)};
}

template <class D>
HWY_INLINE Sample<D> draw_independent(const SampleIndex<D>& s, Bits<D> pair) {
  const Bits<D> sample = s.index * uint32_t{Film::replicates} + s.replicate;
  const Hash3<D> hash = pcg3d(s.pixel, sample, s.seed + pair);
  return {to_unit_interval(hash.x), to_unit_interval(hash.y), to_unit_interval(hash.z)};
}

template <class D>
HWY_INLINE Sample<D> draw(Sampler sampler, const SampleIndex<D>& s, Bits<D> pair) {
  return sampler == Sampler::sobol ? draw_sobol(s, pair) : draw_independent(s, pair);
}

}  // namespace plumb::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
