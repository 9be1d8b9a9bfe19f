// SPDX-License-Identifier: Apache-2.0

// What may be relied on about random numbers and about the maps from the unit square to directions.
//
// Tests of chance have fixed seeds; with another seed, each check fails one time in a million.
#include <Imath/ImathVec.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <set>
#include <vector>

#include "renderer/simd/lamps-inl.h"
#include "renderer/simd/sampler-inl.h"

HWY_BEFORE_NAMESPACE();
namespace plumb::HWY_NAMESPACE {
namespace {

using Exact = long double;
using Vec = Imath::Vec3<Exact>;
template <typename T>
using R = Real<hn::ScalableTag<T>>;
template <typename T>
using V = V3<hn::ScalableTag<T>>;
template <typename T>
using B = Bits<hn::ScalableTag<T>>;
template <typename T>
constexpr Exact epsilon = std::numeric_limits<T>::epsilon();
constexpr int samples = 1 << 17;
constexpr Exact pi = std::numbers::pi_v<Exact>;

void expect_near(Exact value, Exact expected, Exact tolerance) {
  EXPECT_LE(std::abs(value - expected), tolerance) << value << " instead of " << expected;
}

// ---- Statistics ----
// What normal variables (in size) and chi-square variables exceed with a probability of one in a
// million; the second by Wilson and Hilferty 1931.
constexpr double normal_limit = 4.8916;
double chi_square_limit(double degrees) {
  const double spread = 2.0 / (9.0 * degrees);
  return degrees * std::pow(1.0 - spread + 4.7534 * std::sqrt(spread), 3.0);
}

// Pearson's test of `samples` counts, of which `known_sums` sums are known beforehand.
void expect_equal_counts(const std::vector<int>& counts, int known_sums = 1) {
  const double expected = samples / double(counts.size());
  double statistic = 0.0;
  for (const int count : counts) statistic += std::pow(count - expected, 2.0) / expected;
  EXPECT_LT(statistic, chi_square_limit(double(counts.size()) - known_sums));
}

size_t bin(Exact fraction, int bins) {
  return size_t(std::clamp(int(std::floor(fraction * bins)), 0, bins - 1));
}

class Mean {
 public:
  void add(Exact value) { ++n_, sum_ += value, squares_ += value * value; }
  Exact value() const { return sum_ / n_; }
  Exact standard_error() const {
    return std::sqrt(std::max<Exact>(squares_ / n_ - value() * value(), 0) / n_);
  }

 private:
  Exact n_ = 0, sum_ = 0, squares_ = 0;
};

template <typename T>
class Random {
 public:
  T uniform() { return T(bits_() >> (64 - digits)) / T(uint64_t{1} << digits); }
  Exact uniform(Exact a, Exact b) { return a + (b - a) * Exact(uniform()); }
  Exact log_uniform(Exact a, Exact b) { return a * std::pow(b / a, Exact(uniform())); }
  uint32_t bits() { return uint32_t(bits_()); }

 private:
  static constexpr int digits = std::numeric_limits<T>::digits;
  std::mt19937_64 bits_{1};
};

// ---- Lanes, of which all hold the same ----
template <typename D>
Exact get(Real<D> a) {
  return Exact(hn::GetLane(a.v));
}
template <typename D>
Vec get(V3<D> a) {
  return {get(a.x), get(a.y), get(a.z)};
}
template <typename D>
uint32_t get(Bits<D> a) {
  return hn::GetLane(a.v);
}
template <typename T>
V<T> lanes(const Vec& a) {
  return {R<T>(T(a.x)), R<T>(T(a.y)), R<T>(T(a.z))};
}
template <typename T>
PackedVec3<T> pack(const Vec& a) {
  return {T(a.x), T(a.y), T(a.z)};
}

// ---- Geometry ----
Exact length(const Vec& a) { return std::sqrt(a.dot(a)); }
Vec unit(const Vec& a) { return a / length(a); }

// The solid angle of the triangle with a corner at `a` and sides `b` and `c` from there (van
// Oosterom and Strackee 1983). To `condition` is added what a relative error of 1 in each of the
// formula's terms would make of it.
Exact solid_angle(const Vec& a, const Vec& b, const Vec& c, Exact* condition = nullptr) {
  const Vec p = a + b, q = a + c;
  const Exact volume = std::abs(a.dot(b.cross(c)));
  const Exact size = length(a) * length(p) * length(q);
  const Exact sum = size + a.dot(p) * length(q) + a.dot(q) * length(p) + p.dot(q) * length(a);
  if (condition) *condition += 2 * volume * (volume + 4 * size) / (sum * sum + volume * volume);
  return 2 * std::atan2(volume, sum);
}

struct Parallelogram {
  Vec corner, x, y;

  Parallelogram seen_from(const Vec& p) const { return {corner - p, x, y}; }
  Exact solid_angle(Exact* condition = nullptr) const {
    return HWY_NAMESPACE::solid_angle(corner, x, x + y, condition) +
           HWY_NAMESPACE::solid_angle(corner, x + y, y, condition);
  }
  // Lambert's formula for the irradiance in the origin; all of the lamp is above the horizon.
  Exact irradiance(const Vec& normal) const {
    const Vec corners[] = {corner, corner + x, corner + x + y, corner + y};
    Exact sum = 0;
    for (size_t i = 0; i < 4; ++i) {
      const Vec cross = corners[i].cross(corners[(i + 1) % 4]);
      sum +=
          std::atan2(length(cross), corners[i].dot(corners[(i + 1) % 4])) * normal.dot(unit(cross));
    }
    return std::abs(sum) / 2;
  }
};

template <typename T>
PackedLamp<T> rectangle(const Parallelogram& p) {
  PackedLamp<T> lamp{};
  lamp.kind = PackedLamp<T>::Kind::rectangle;
  lamp.origin = pack<T>(p.corner);
  lamp.x = pack<T>(unit(p.x));
  lamp.y = pack<T>(unit(p.y));
  lamp.normal = pack<T>(unit(p.x.cross(p.y)));
  lamp.x_length = T(length(p.x));
  lamp.y_length = T(length(p.y));
  lamp.area = T(length(p.x.cross(p.y)));
  return lamp;
}

template <typename T>
PackedLamp<T> sphere(const Vec& center, Exact radius) {
  PackedLamp<T> lamp{};
  lamp.kind = PackedLamp<T>::Kind::sphere;
  lamp.origin = pack<T>(center);
  lamp.radius = T(radius);
  return lamp;
}

// A rectangle that lies askew, its bright side up, and points on that side.
const Parallelogram askew{{-0.3L, 0.2L, 0.1L}, {0.48L, 0.64L, 0}, {-0.32L, 0.24L, 0.3L}};
Vec beside_askew(Exact x, Exact y, Exact height) {
  return askew.corner + askew.x * x + askew.y * y + unit(askew.x.cross(askew.y)) * height;
}
const std::vector<Vec> points_about_askew = {
    beside_askew(0.5L, 0.5L, 0.2L), beside_askew(0.1L, 0.8L, 1),  beside_askew(-0.3L, 0.4L, 0.1L),
    beside_askew(1.5L, 3, 0.5L),    beside_askew(0.5L, -2, 0.3L), beside_askew(30, 50, 100)};

template <typename T>
LampSample<hn::ScalableTag<T>> sample(const PackedLamp<T>& lamp, const Vec& from, T u, T v) {
  return sample_lamp<hn::ScalableTag<T>>(lamp, lanes<T>(from), R<T>(u), R<T>(v));
}

// A density is one over the areas that its map makes of those of the unit square. Differences err
// by h^2, from the third derivative, and epsilon / h, from rounding.
template <typename T, class Direction>
void expect_density(const Direction& direction, Exact inverse_pdf, T u, T v) {
  const T h = std::cbrt(std::numeric_limits<T>::epsilon());
  const Vec du = direction(u + h, v) - direction(u - h, v);
  const Vec dv = direction(u, v + h) - direction(u, v - h);
  expect_near(length(du.cross(dv)) / (4 * h * h) / inverse_pdf, 1,
              200 * h * h + 4 * epsilon<T> / (h * std::sqrt(inverse_pdf)));
}

template <typename T>
class SamplingTest : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(SamplingTest, Precisions);

// ---- Random numbers ----
struct Numbers {
  uint32_t pixel = 0, replicate = 0, seed = 0, pair = 0;

  template <typename T>
  std::array<Exact, 3> draw(Sampler sampler, uint32_t index) const {
    const SampleIndex<hn::ScalableTag<T>> s{B<T>(pixel), B<T>(replicate), B<T>(index),
                                            mix(B<T>(seed))};
    const Sample<hn::ScalableTag<T>> point = HWY_NAMESPACE::draw(sampler, s, B<T>(pair));
    return {get(point.u), get(point.v), get(point.w)};
  }
};
const std::vector<Numbers> streams = {{0, 0, 0, 0}, {1, 0, 0, 0}, {262143, 3, 7, 11}};

TYPED_TEST(SamplingTest, IndependentNumbersAreUniformBelowOneOneByOneAndTogether) {
  EXPECT_EQ(get(to_unit_interval(B<TypeParam>(0u))), 0);
  EXPECT_LT(get(to_unit_interval(B<TypeParam>(0xffffffffu))), 1);
  for (const Numbers& stream : streams) {
    std::vector<std::vector<int>> ones(3, std::vector<int>(256)), pairs = ones;
    for (uint32_t i = 0; i < samples; ++i) {
      const auto p = stream.draw<TypeParam>(Sampler::independent, i);
      for (size_t k = 0; k < 3; ++k) {
        ++ones[k][bin(p[k], 256)];
        ++pairs[k][bin(p[k], 16) * 16 + bin(p[(k + 1) % 3], 16)];
      }
    }
    for (const auto& counts : ones) expect_equal_counts(counts);
    for (const auto& counts : pairs) expect_equal_counts(counts);
  }
}

TYPED_TEST(SamplingTest, PixelsReplicatesSeedsAndPairsHaveUnrelatedNumbers) {
  for (const Sampler sampler : {Sampler::independent, Sampler::sobol}) {
    // Against the next pixel, replicate, seed and pair, each coordinate with each.
    Exact correlations[36] = {};  // sums of variables with variance 1
    std::vector<int> cells(512);
    for (uint32_t pixel = 0; pixel < samples; ++pixel) {
      const auto a = Numbers{2 * pixel}.template draw<TypeParam>(sampler, 5);
      ++cells[(bin(a[0], 8) * 8 + bin(a[1], 8)) * 8 + bin(a[2], 8)];
      const Numbers others[] = {
          {2 * pixel + 1}, {2 * pixel, 1}, {2 * pixel, 0, 1}, {2 * pixel, 0, 0, 1}};
      for (size_t k = 0; k < 4; ++k) {
        const auto b = others[k].template draw<TypeParam>(sampler, 5);
        for (size_t i = 0; i < 9; ++i)
          correlations[9 * k + i] += 12 * (a[i / 3] - 0.5L) * (b[i % 3] - 0.5L);
      }
    }
    expect_equal_counts(cells);
    for (const Exact c : correlations) expect_near(c, 0, normal_limit * std::sqrt(Exact(samples)));
  }
}

TYPED_TEST(SamplingTest, EachElementaryIntervalHoldsOneOfTheSobolPointsWhateverTheThirdNumber) {
  for (const Numbers& stream : streams) {
    for (int k = 0; k <= 8; ++k) {
      for (int a = 0; a <= k; ++a) {
        std::vector<int> counts(size_t{1} << k);
        for (uint32_t i = 0; i < 3u << k; ++i) {  // three blocks of as many points as intervals
          const auto p = stream.draw<TypeParam>(Sampler::sobol, i);
          const int count = ++counts[(bin(p[0], 1 << a) << (k - a)) + bin(p[1], 1 << (k - a))];
          ASSERT_EQ(count, int(i >> k) + 1) << k << " " << a;
        }
      }
    }
    std::vector<int> cells(512);
    for (uint32_t i = 0; i < samples; ++i) {
      const auto p = stream.draw<TypeParam>(Sampler::sobol, i);
      ++cells[(bin(p[0], 8) * 8 + bin(p[1], 8)) * 8 + bin(p[2], 8)];
    }
    expect_equal_counts(cells, 64);  // the points spread evenly over the squares
  }
}

TYPED_TEST(SamplingTest, SobolIndicesAndBitsFollowTheirDefinitions) {
  Random<TypeParam> random;
  using Word = B<TypeParam>;
  for (int n = 0; n < 1000; ++n) {
    const uint32_t index = n < 32 ? 1u << n : random.bits();
    uint32_t reversed = 0, second = 0;
    uint32_t direction = 1u << 31;  // direction numbers: m_1 = 1, m_i = 2 m_{i-1} xor m_{i-1}
    for (int bit = 0; bit < 32; ++bit, direction ^= direction >> 1) {
      if ((index >> bit & 1u) == 0) continue;
      reversed |= 1u << (31 - bit);
      second ^= direction;
    }
    EXPECT_EQ(get(reverse_bits(Word(index))), reversed);
    EXPECT_EQ(get(reverse_bits(sobol_second_dimension(Word(index)))), second);
  }
}

TYPED_TEST(SamplingTest, ScramblingIsABijectionOfLowBitsInWhichNoneDependsOnHigherOnes) {
  Random<TypeParam> random;
  using Word = B<TypeParam>;
  for (int n = 0; n < 50; ++n) {
    const Word seed(random.bits());
    std::set<uint32_t> low_bits;
    for (uint32_t v = 0; v < 256; ++v) {
      const uint32_t scrambled = get(laine_karras_permutation(Word(v), seed));
      low_bits.insert(scrambled & 255u);
      const uint32_t higher = random.bits() << 8;
      EXPECT_EQ(get(laine_karras_permutation(Word(v | higher), seed)) & 255u, scrambled & 255u);
    }
    EXPECT_EQ(low_bits.size(), 256u);
  }
}

// ---- Directions ----
TYPED_TEST(SamplingTest, FramesAreOrthonormalAndRightHanded) {
  Random<TypeParam> random;
  for (int n = 0; n < 1000; ++n) {
    const Exact tilt = random.log_uniform(1e-9L, 1);
    Vec z{tilt * random.uniform(-1, 1), tilt * random.uniform(-1, 1), n % 2 ? 1.0L : -1.0L};
    if (n < 4) z = {0, 0, n % 2 ? 1.0L : -1.0L};
    if (n == 4) z = {1, 0, -0.0L};
    const auto frame = frame_around(normalize(lanes<TypeParam>(z)));
    const Vec a = get(frame.x), b = get(frame.y), c = get(frame.z);
    for (const Exact zero : {a.dot(b), b.dot(c), c.dot(a), a.dot(a) - 1, b.dot(b) - 1}) {
      expect_near(zero, 0, 4 * epsilon<TypeParam>);
    }
    EXPECT_GT(a.cross(b).dot(c), 0);
  }
}

TYPED_TEST(SamplingTest, CosineHemisphereHasItsDensityAndAnInverse) {
  using T = TypeParam;
  Random<T> random;
  for (const Vec& normal : {Vec(0, 0, 1), Vec(0, 0, -1), Vec(0.6L, 0, -0.8L), Vec(1, 0, 0)}) {
    const auto frame = frame_around(lanes<T>(normal));
    const auto direction = [&](T u, T v) {
      return get(sample_cosine_hemisphere(frame, R<T>(u), R<T>(v)));
    };
    for (int n = 0; n < 10000; ++n) {
      const T u = random.uniform(), v = random.uniform();
      const Vec d = direction(u, v);
      expect_near(length(d), 1, 4 * epsilon<T>);
      const Exact cosine = d.dot(get(frame.z));
      const Exact turn = std::atan2(d.dot(get(frame.y)), d.dot(get(frame.x))) / (2 * pi);
      const Exact v_back = turn - std::floor(turn);
      expect_near(1 - cosine * cosine, u, 4 * epsilon<T>);
      // Rounding of the direction moves it around the normal by that much, or by a full circle.
      const Exact off = std::abs(v_back - v);
      EXPECT_LT(std::min(off, 1 - off) * std::sqrt(std::max<Exact>(u, 0)), 4 * epsilon<T>);
    }
    expect_density<T>(direction, pi / std::sqrt(0.7L), T(0.3), T(0.6));
  }
}

// ---- Rectangles ----
// Places about lamps of length 1: near, far, above, beside, edge-on.
template <typename T, class Check>
void for_rectangles(const Check& check) {
  Random<T> random;
  for (int n = 0; n < 20000; ++n) {
    const Exact width = T(random.log_uniform(0.01L, 1)), away = random.log_uniform(1e-4L, 1e4L);
    const Parallelogram lamp{{0, 0, 0}, {1, 0, 0}, {0, width, 0}};
    const Vec p =
        get(lanes<T>({0.5L + away * random.uniform(-1, 1), width / 2 + away * random.uniform(-1, 1),
                      random.log_uniform(1e-6L, 1e4L)}));
    const auto s = see_rectangle<hn::ScalableTag<T>>(rectangle<T>(lamp), lanes<T>(p));
    const bool is_beside = std::max({-p.x, p.x - 1, -p.y, p.y - width, p.z}) > 1;
    check(lamp.seen_from(p), s, is_beside, random);
  }
}

TYPED_TEST(SamplingTest, SolidAnglesOfRectanglesLoseDigitsOnlyBesideCloseEdges) {
  for_rectangles<TypeParam>([](const Parallelogram& seen, const auto& s, bool is_beside, auto&) {
    Exact condition = 0;
    const Exact exact = seen.solid_angle(&condition), result = get(s.solid_angle);
    expect_near(result, exact, epsilon<TypeParam> * (8 * condition + 8 * exact));
    if (is_beside) expect_near(result / exact, 1, 100 * epsilon<TypeParam>);
  });
}

// That a point of a rectangle, seen from the origin, is where a map that is uniform in solid angle
// leads from (u, v): u of the solid angle is at smaller x, and y / distance goes evenly.
void expect_mapped(const Parallelogram& seen, const Vec& point, Exact u, Exact v, Exact tolerance) {
  const Exact x = (point - seen.corner).dot(seen.x) / seen.x.dot(seen.x);
  const Exact y = (point - seen.corner).dot(seen.y) / seen.y.dot(seen.y);
  expect_near(std::max(std::abs(x - 0.5L), std::abs(y - 0.5L)), 0.25L, 0.25L + tolerance);
  expect_near(length(point - seen.corner - seen.x * x - seen.y * y) / length(seen.y), 0, tolerance);
  const auto sine = [&](Exact at) {
    return (seen.corner + seen.x * x + seen.y * at).normalized().dot(unit(seen.y));
  };
  const Exact sines = sine(1) - sine(0);
  expect_near((sine(y) - sine(0)) / sines, v, tolerance + 8 * epsilon<Exact> / sines);
  Exact condition = 0;
  const Parallelogram part{seen.corner, seen.x * x, seen.y};
  const Exact share = part.solid_angle(&condition) / seen.solid_angle(&condition);
  expect_near(share, u, tolerance + 8 * epsilon<Exact> * condition / seen.solid_angle());
}

// The map loses no more than the coordinates of the lamp's points, however small it is seen.
TYPED_TEST(SamplingTest, RectanglesAreMappedUniformlyHoweverSmallTheyAreSeen) {
  using T = TypeParam;
  for_rectangles<T>([](const Parallelogram&, const auto& s, bool is_beside, auto& random) {
    if (!is_beside || s.is_sampled_by_area().any()) return;
    const T u = random.uniform(), v = random.uniform();
    R<T> x, y;
    sample_solid_angle<hn::ScalableTag<T>>(s, u, v, x, y);
    const Vec corner{get(s.x0), get(s.y0), -get(s.z)}, point{get(x), get(y), -get(s.z)};
    const Vec opposite{get(s.x1), get(s.y1), -get(s.z)}, size = opposite - corner;
    expect_mapped({corner, {size.x, 0, 0}, {0, size.y, 0}}, point, u, v,
                  epsilon<T> * (100 + 4 * length(point) / size.y));
  });
}

// Beside a close edge, or just under it, no more is lost than the solid angle's digits, whichever
// of the four it is.
TYPED_TEST(SamplingTest, RectanglesAreMappedUniformlyHoweverCloseAnEdgeIs) {
  using T = TypeParam;
  Random<T> random;
  for (int n = 0; n < 20000; ++n) {
    const Exact width = T(random.log_uniform(0.1L, 1)), away = random.log_uniform(1e-5L, 0.1L);
    const Exact side = n % 2 == 0 ? -away : away, along = random.uniform(0, 1);
    const Exact height = random.log_uniform(1e-4L, 0.1L);
    const Vec places[] = {{side, along * width, height},
                          {1 + side, along * width, height},
                          {along, side, height},
                          {along, width + side, height}};
    const PackedLamp<T> lamp = rectangle<T>({{0, 0, 0}, {1, 0, 0}, {0, width, 0}});
    const auto s = see_rectangle<hn::ScalableTag<T>>(lamp, lanes<T>(places[n / 2 % 4]));
    const T u = random.uniform(), v = random.uniform();
    R<T> x, y;
    sample_solid_angle<hn::ScalableTag<T>>(s, u, v, x, y);
    const Vec corner{get(s.x0), get(s.y0), -get(s.z)}, point{get(x), get(y), -get(s.z)};
    const Parallelogram seen{corner, {get(s.x1) - corner.x, 0, 0}, {0, get(s.y1) - corner.y, 0}};
    Exact condition = 0;
    const Exact exact = seen.solid_angle(&condition);
    expect_mapped(seen, point, u, v, epsilon<T> * (100 + 8 * condition / exact));
  }
}

TYPED_TEST(SamplingTest, RectanglesThatLieAskewAreMappedUniformlyAndVisibleFromOneSide) {
  using T = TypeParam;
  Random<T> random;
  const PackedLamp<T> lamp = rectangle<T>(askew);
  for (const Vec& p : points_about_askew) {
    const Parallelogram seen = askew.seen_from(get(lanes<T>(p)));
    for (int n = 0; n < 1000; ++n) {
      const T u = random.uniform(), v = random.uniform();
      const auto s = sample(lamp, p, u, v);
      expect_mapped(seen, get(s.direction) * get(s.distance), u, v,
                    32 * epsilon<T> * (1 + length(p)));
      expect_near(get(s.inverse_pdf) / seen.solid_angle(), 1, 100 * epsilon<T>);
      EXPECT_EQ(get(s.inverse_pdf), get(inverse_lamp_pdf(lamp, lanes<T>(p), s.distance)));
      EXPECT_TRUE(s.visible.any());
    }
  }
  const Vec behind = beside_askew(0.4L, 0.4L, -0.1L);
  EXPECT_FALSE(sample(lamp, behind, T(0.5), T(0.5)).visible.any());
}

// The last rows are sampled by area.
TYPED_TEST(SamplingTest, IrradianceFromRectanglesIsLamberts) {
  using T = TypeParam;
  Random<T> random;
  const Parallelogram flat{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const PackedLamp<T> lamp = rectangle<T>(flat);
  const Vec wall{1, 0, 0};
  for (const Exact away : {0.2L, 1.0L, 5.0L, 100.0L}) {
    for (const Exact height : {1.0L, 0.1L, 0.01L, 1e-3L, 1e-4L}) {
      const Vec p = get(lanes<T>({-away, 0.25L, height}));
      Mean mean;
      for (int n = 0; n < samples / 8; ++n) {
        const auto s = sample(lamp, p, random.uniform(), random.uniform());
        mean.add(get(s.inverse_pdf) * get(s.direction).dot(wall));
        EXPECT_EQ(get(s.inverse_pdf), get(inverse_lamp_pdf(lamp, lanes<T>(p), s.distance)));
      }
      const Exact exact = flat.seen_from(p).irradiance(wall);
      const Exact tolerance = normal_limit * mean.standard_error() + 100 * epsilon<T> * exact;
      expect_near(mean.value(), exact, tolerance);
    }
  }
}

TYPED_TEST(SamplingTest, RectanglesAreSeenFromTouchingAndFromWherePowersOfDistancesOverflow) {
  using T = TypeParam;
  const PackedLamp<T> lamp = rectangle<T>({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  for (const Exact height : {1e-5L, 1e-7L, 1e-9L, 1e-12L}) {
    expect_near(get(sample(lamp, {0.4L, 0.3L, height}, T(0.3), T(0.6)).inverse_pdf), 2 * pi, 1e-3L);
  }
  const Exact touching = get(sample(lamp, {0.4L, 0.3L, 0}, T(0.3), T(0.6)).inverse_pdf);
  EXPECT_TRUE(std::isfinite(touching));
  const Exact far = 1e8L;
  const auto s = sample(lamp, {far, 0, far}, T(0.3), T(0.6));
  expect_near(get(s.inverse_pdf) * far * far * std::sqrt(8.0L), 1, 1e-6L);
  expect_near(get(s.distance) / far, std::sqrt(2.0L), 1e-6L);
}

TYPED_TEST(SamplingTest, DensitiesOfLampsAreThoseOfTheirMaps) {
  using T = TypeParam;
  for (const auto& lamp : {rectangle<T>(askew), sphere<T>({0, 0, -3}, 2)}) {
    for (const Vec& p : points_about_askew) {
      const T u = T(0.3), v = T(0.6);
      expect_density<T>([&](T x, T y) { return get(sample(lamp, p, x, y).direction); },
                        get(sample(lamp, p, u, v).inverse_pdf), u, v);
    }
  }
}

// ---- Triangles ----
template <typename T>
PackedLamp<T> triangle(const Vec& corner, const Vec& x, const Vec& y) {
  PackedLamp<T> lamp{};
  lamp.kind = PackedLamp<T>::Kind::triangle;
  lamp.origin = pack<T>(corner);
  lamp.x = pack<T>(x);
  lamp.y = pack<T>(y);
  lamp.normal = pack<T>(unit(x.cross(y)));
  lamp.area = T(length(x.cross(y)) / 2);
  return lamp;
}

// Triangles of any shape but needles, seen from 0.03 to 30 sizes away, above and aside. Where they
// are mapped by solid angle, u of it lies on the side of the corners a and b, and the cosine to b
// goes evenly with v.
TYPED_TEST(SamplingTest, TrianglesAreMappedUniformly) {
  using T = TypeParam;
  Random<T> random;
  Mean error;
  Exact largest = 0;
  for (int n = 0; n < 20000; ++n) {
    const Vec x{1, 0, 0}, y{random.uniform(-0.5L, 1.5L), random.uniform(0.2L, 1.5L), 0};
    const Vec p = get(lanes<T>({random.uniform(-1, 2) * random.log_uniform(1, 10),
                                random.uniform(-1, 2) * random.log_uniform(1, 10),
                                random.log_uniform(0.03L, 30)}));
    const PackedLamp<T> lamp = triangle<T>({0, 0, 0}, x, y);
    const Vec a = -p, b = get(lanes<T>(x)) - p, c = get(lanes<T>(y)) - p;
    const Exact whole = solid_angle(a, b - a, c - a);
    const auto seen = see_triangle<hn::ScalableTag<T>>(lamp, lanes<T>(p));
    const T u = random.uniform(), v = random.uniform();
    const auto s = sample(lamp, p, u, v);
    EXPECT_EQ(get(s.inverse_pdf), get(inverse_lamp_pdf(lamp, lanes<T>(p), s.distance)));
    expect_near(length(get(s.direction)), 1, 8 * epsilon<T>);
    if (seen.is_sampled_by_area().any()) continue;
    expect_near(get(s.inverse_pdf) / whole, 1, 2000 * epsilon<T>);
    const Vec d = get(s.direction);
    // Where the plane through b and d meets the edge from a to c.
    const Vec plane = b.cross(d);
    const Exact t = a.dot(plane) / (a - c).dot(plane);
    const Vec cut = a + (c - a) * t;
    const Exact share = solid_angle(a, b - a, cut - a) / whole;
    const Exact even = (1 - unit(b).dot(unit(d))) / (1 - unit(b).dot(unit(cut)));
    const Exact off = std::max(std::abs(share - u), std::abs(even - v) * std::sqrt(share));
    error.add(off);
    largest = std::max(largest, off);
  }
  EXPECT_LT(error.value(), 40 * epsilon<T>);
  EXPECT_LT(largest, 20000 * epsilon<T>);
}

TYPED_TEST(SamplingTest, IrradianceFromTrianglesIsLamberts) {
  using T = TypeParam;
  Random<T> random;
  const PackedLamp<T> lamp = triangle<T>({0, 0, 0}, {1, 0, 0}, {0.3L, 1, 0});
  const Vec wall{1, 0, 0};
  for (const Exact away : {0.2L, 1.0L, 5.0L, 100.0L}) {
    for (const Exact height : {1.0L, 0.1L, 0.01L, 1e-3L, 1e-4L}) {
      const Vec p = get(lanes<T>({-away, 0.25L, height}));
      Mean mean;
      for (int n = 0; n < samples / 8; ++n) {
        const auto s = sample(lamp, p, random.uniform(), random.uniform());
        mean.add(get(s.inverse_pdf) * get(s.direction).dot(wall));
      }
      const Vec corners[] = {-p, Vec(1, 0, 0) - p, Vec(0.3L, 1, 0) - p};
      Exact exact = 0;
      for (size_t i = 0; i < 3; ++i) {
        const Vec& e = corners[i];
        const Vec& f = corners[(i + 1) % 3];
        exact += std::atan2(length(e.cross(f)), e.dot(f)) * wall.dot(unit(e.cross(f))) / 2;
      }
      const Exact tolerance =
          normal_limit * mean.standard_error() + 1000 * epsilon<T> * std::abs(exact);
      expect_near(mean.value(), std::abs(exact), tolerance);
    }
  }
}

// ---- Spheres ----
// 1 - cos(theta) of a unit sphere.
Exact sphere_opening(Exact d) { return 1 / (d * d) / (1 + std::sqrt((d - 1) * (d + 1)) / d); }

TYPED_TEST(SamplingTest, SolidAnglesOfSpheresKeepTheirDigitsFromFarAndTouching) {
  using T = TypeParam;
  for (const Exact distance : {1e5L, 1e3L, 2.0L, 1.1L, 1.001L, 1.000001L}) {
    const Exact d = T(distance);
    const auto s = see_sphere<hn::ScalableTag<T>>(sphere<T>({0, 0, 0}, 1), lanes<T>({0, 0, d}));
    expect_near(get(s.solid_angle()) / (2 * pi * sphere_opening(d)), 1, 8 * epsilon<T>);
  }
}

TYPED_TEST(SamplingTest, SpheresAreSampledUniformlyInSolidAngle) {
  using T = TypeParam;
  Random<T> random;
  const Vec center{1, -2, 3};
  for (const Exact distance : {30.0L, 2.0L, 1.01L}) {
    const PackedLamp<T> lamp = sphere<T>(center, 1);
    const Vec p = get(lanes<T>(center + unit(Vec(2, 3, -1)) * distance));
    const Vec axis = unit(center - p);
    const Exact d = length(center - p);
    const Exact opening = sphere_opening(d);
    const auto frame = frame_around(lanes<T>(axis));
    std::vector<int> counts(256);
    for (int n = 0; n < samples; ++n) {
      const auto s = sample(lamp, p, random.uniform(), random.uniform());
      const Vec direction = get(s.direction), aside = direction - axis;
      expect_near(length(direction), 1, 4 * epsilon<T>);
      expect_near(length(p + direction * get(s.distance) - center), 1, 16 * epsilon<T> * d);
      const Exact turn = std::atan2(aside.dot(get(frame.y)), aside.dot(get(frame.x))) / (2 * pi);
      ++counts[bin(aside.dot(aside) / 2 / opening, 16) * 16 + bin(turn - std::floor(turn), 16)];
      EXPECT_EQ(get(s.inverse_pdf), get(inverse_lamp_pdf(lamp, lanes<T>(p), s.distance)));
      EXPECT_TRUE(s.visible.any());
    }
    expect_equal_counts(counts);
  }
}

}  // namespace
}  // namespace plumb::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
