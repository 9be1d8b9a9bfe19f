// SPDX-License-Identifier: Apache-2.0

// Where mirrors reflect one point to another, and how beams spread behind them.
#include <Imath/ImathVec.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <type_traits>

#include "renderer/simd/mirrors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace plumb::HWY_NAMESPACE {
namespace {

using Vec = Imath::V3d;
template <typename T>
using Lanes = hn::ScalableTag<T>;

class Random {
 public:
  double uniform(double a, double b) { return std::uniform_real_distribution(a, b)(bits_); }
  double log_uniform(double a, double b) { return std::exp(uniform(std::log(a), std::log(b))); }
  Vec direction() {
    std::normal_distribution normal;
    return Vec(normal(bits_), normal(bits_), normal(bits_)).normalized();
  }

 private:
  std::mt19937_64 bits_{1};
};

template <typename D>
double get(Real<D> a) {
  return double(hn::GetLane(a.v));
}
template <typename D>
Vec get(V3<D> a) {
  return {get(a.x), get(a.y), get(a.z)};
}
template <typename T>
PackedVec3<T> pack(const Vec& a) {
  return {T(a.x), T(a.y), T(a.z)};
}
// As the lanes hold it.
template <typename T>
Vec rounded(const Vec& a) {
  return {T(a.x), T(a.y), T(a.z)};
}

template <typename T>
Reflection<Lanes<T>> reflect(const PackedMirror<T>& mirror, const Vec& x, const Vec& y) {
  const Bool<Lanes<T>> all = !Bool<Lanes<T>>::none();
  return HWY_NAMESPACE::reflect(mirror, all, V3<Lanes<T>>(pack<T>(x)), V3<Lanes<T>>(pack<T>(y)));
}

template <typename T>
PackedMirror<T> ball(double radius) {
  PackedMirror<T> mirror{};
  mirror.is_sphere = true;
  mirror.sphere = {{0, 0, 0}, T(radius), 0};
  return mirror;
}

// The square from -1 to 1 at z = 0, which faces up.
template <typename T>
PackedMirror<T> square(bool two_sided) {
  PackedMirror<T> mirror{};
  mirror.two_sided = two_sided;
  mirror.face.plane = {{0, 0, 1}, 0};
  mirror.face.edges[0] = {{1, 0, 0}, -1};
  mirror.face.edges[1] = {{-1, 0, 0}, -1};
  mirror.face.edges[2] = {{0, 1, 0}, -1};
  mirror.face.edges[3] = {{0, -1, 0}, -1};
  return mirror;
}

template <typename T>
class ReflectionTest : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(ReflectionTest, Precisions);

TYPED_TEST(ReflectionTest, OfAPlaneIsOnTheWayToTheImage) {
  using T = TypeParam;
  constexpr double eps = std::numeric_limits<T>::epsilon();
  Random random;
  for (int i = 0; i < 20000; ++i) {
    const auto point = [&] {
      return rounded<T>({random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-1, 1)});
    };
    const Vec x = point(), y = point(), image(y.x, y.y, -y.z);
    const Vec p = x + (image - x) * (x.z / (x.z - image.z));
    const double inside = std::min(1 - std::abs(p.x), 1 - std::abs(p.y));
    if (std::abs(inside) < 1e-4) continue;  // the edge
    for (const bool two_sided : {false, true}) {
      const bool exists = inside > 0 && x.z * y.z > 0 && (two_sided || x.z > 0);
      const auto way = reflect(square<T>(two_sided), x, y);
      ASSERT_EQ(way.exists.any(), exists) << x << y;
      if (!exists) continue;
      const double tolerance = 16 * eps * (image - x).length();
      EXPECT_LE((get(way.point) - p).length(), tolerance / std::min(std::abs(x.z + y.z), 1.0));
      EXPECT_NEAR(get(way.beam.to_mirror) + get(way.to_lamp), (image - x).length(), tolerance);
      EXPECT_LE((get(way.direction) - (image - x).normalized()).length(), 16 * eps);
      EXPECT_LE((get(way.onward) - (y - p).normalized()).length(), 1e2 * eps / std::abs(y.z));
      EXPECT_NEAR(get(way.beam.squared_distance(way.to_lamp)) / (image - x).length2(), 1, 16 * eps);
    }
  }
}

// Points a ten-thousandth to thirty radii above the ball, at all angles.
TYPED_TEST(ReflectionTest, OfABallHasEqualAnglesWhereverItIsNotHidden) {
  using T = TypeParam;
  // What Newton's method leaves where it ends, in radians; rounding adds to it near the ball.
  const double tolerance = std::is_same_v<T, float> ? 1e-4 : 1e-10;
  Random random;
  int met = 0;
  for (int i = 0; i < 50000; ++i) {
    const double radius = T(random.log_uniform(0.01, 1));
    const auto point = [&] {
      return rounded<T>(random.direction() * (radius * (1 + random.log_uniform(1e-4, 30))));
    };
    const Vec x = point(), y = point();
    const double to_nearest = std::clamp(x.dot(x - y) / (y - x).length2(), 0.0, 1.0);
    const double height = (x + (y - x) * to_nearest).length() / radius - 1;  // of the segment
    if (std::abs(height) < 1e-5) continue;
    const auto way = reflect(ball<T>(radius), x, y);
    ASSERT_EQ(way.exists.any(), height > 0) << x << y << radius;
    if (height < 0) continue;
    ++met;
    const Vec p = get(way.point), normal = p.normalized();
    EXPECT_NEAR(p.length() / radius, 1, 1e-6);
    EXPECT_LE(std::abs(normal.dot(x.cross(y).normalized())), 1e-3);  // in their plane
    const auto angle = [&](const Vec& to) {
      return std::atan2(normal.cross(to - p).length(), normal.dot(to - p));
    };
    // The angles change with p by up to one over the distance in radii.
    const double change = 2 + radius / (x - p).length() + radius / (y - p).length();
    EXPECT_NEAR(angle(x), angle(y), tolerance * change) << x << y << radius;
  }
  EXPECT_GT(met, 15000);
}

// Shoots rays around the one that is reflected, and measures what they span behind the ball.
TEST(Beam, SpreadsAsRaysDo) {
  Random random;
  for (int i = 0; i < 2000; ++i) {
    const double radius = 1.0, step = 1e-5;
    const Vec x = random.direction() * random.uniform(1.2, 8);
    const Vec y = random.direction() * random.uniform(1.2, 8);
    const auto way = reflect(ball<double>(radius), x, y);
    if (!way.exists.any()) continue;
    const Vec direction = get(way.direction), onward = get(way.onward);
    if (-direction.dot(get(way.point)) < 0.1) continue;  // grazing: the step is too long
    // Where the ray meets the plane through y that faces it.
    const auto arrive = [&](const Vec& to) {
      const Vec d = to.normalized();
      const double middle = -x.dot(d);
      const Vec p = x + d * (middle - std::sqrt(middle * middle - x.length2() + radius * radius));
      const Vec reflected = d - p * (2 * p.dot(d));
      return p + reflected * ((y - p).dot(onward) / reflected.dot(onward));
    };
    const Vec u =
        direction.cross(std::abs(direction.x) < 0.5 ? Vec(1, 0, 0) : Vec(0, 1, 0)).normalized();
    const Vec v = direction.cross(u);
    const auto change = [&](const Vec& side) {
      return (arrive(direction + side * step) - arrive(direction - side * step)) / (2 * step);
    };
    EXPECT_NEAR(change(u).cross(change(v)).length() / get(way.beam.squared_distance(way.to_lamp)),
                1, 1e-4);
  }
}

}  // namespace
}  // namespace plumb::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
