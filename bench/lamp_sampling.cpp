// SPDX-License-Identifier: Apache-2.0

// How far rounding moves the points that a rectangular lamp is sampled at, and what that means for
// irradiance. Prints the tables of docs/lamp-sampling.md.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "renderer/simd/lamps-inl.h"

HWY_BEFORE_NAMESPACE();
namespace plumb::HWY_NAMESPACE {

using Exact = long double;

// The rectangle [x0, x1] by [y0, y1] at height z, seen from the origin: two triangles, each by van
// Oosterom and Strackee 1983.
Exact exact_solid_angle(Exact x0, Exact x1, Exact y0, Exact y1, Exact z) {
  const auto r = [z](Exact x, Exact y) { return std::sqrt(x * x + y * y + z * z); };
  const Exact a = r(x0, y0), c = r(x1, y1), ac = x0 * x1 + y0 * y1 + z * z;
  const auto half = [=](Exact x, Exact y) {
    const Exact b = r(x, y), ab = x0 * x + y0 * y + z * z, bc = x * x1 + y * y1 + z * z;
    return std::atan2(z * (x1 - x0) * (y1 - y0), a * b * c + ab * c + ac * b + bc * a);
  };
  return 2 * (half(x1, y0) + half(x0, y1));
}

// A lamp of length 1 along x with a corner in the origin, shining upwards.
template <typename T>
PackedLamp<T> lamp_of_width(T width) {
  PackedLamp<T> lamp{};
  lamp.x.x = lamp.y.y = lamp.normal.z = lamp.x_length = 1;
  lamp.y_length = lamp.area = width;
  return lamp;
}

struct Errors {
  Exact largest = 0, sum = 0;
  int count = 0;
  void add(Exact error) { largest = std::max(largest, error), sum += error, ++count; }
  void print() const {
    fmt::print("{}|", count ? fmt::format(" {:.0e} ({:.0e}) ", largest, sum / count) : " ");
  }
};

// Draws points around lamps, samples the lamps by solid angle and inverts the map exactly.
template <typename T>
void measure_errors(const char* name) {
  using D = hn::ScalableTag<T>;
  std::mt19937_64 random(1);
  const auto uniform = [&](double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random);
  };
  // By decades of solid angle and of height / reach; the last row is the solid angle's own.
  std::map<int, std::map<int, Errors>> errors;
  for (int i = 0; i < 1000000; ++i) {
    const double width = std::pow(10, uniform(-1, 0)), height = std::pow(10, uniform(-6, 3));
    const double away = std::pow(10, uniform(-3, 3)), turn = uniform(0, 2 * std::numbers::pi);
    const double place = uniform(0, 1), edge = std::pow(10, uniform(-5, -1));
    const bool above = place < 0.3;
    const bool close = place >= 0.8;
    const double beside = uniform(0, 1) < 0.5 ? -edge : edge;
    const double x = close ? beside : above ? uniform(0, 1) : 0.5 + away * std::cos(turn);
    const double y = close || above ? uniform(0, width) : 0.5 * width + away * std::sin(turn);
    const PackedLamp<T> lamp = lamp_of_width(T(width));
    const SeenRectangle<D> s = see_rectangle<D>(lamp, {T(x), T(y), T(height)});
    const T u = T(uniform(0, 1)), v = T(uniform(0, 1));
    Real<D> lamp_x, lamp_y;
    sample_solid_angle<D>(s, u, v, lamp_x, lamp_y);
    const auto exact = [](Real<D> a) { return Exact(hn::GetLane(a.v)); };
    const Exact x0 = exact(s.x0), x1 = exact(s.x1), y0 = exact(s.y0), y1 = exact(s.y1);
    const Exact z = exact(s.z), at_x = exact(lamp_x), at_y = exact(lamp_y);
    const Exact unrounded = exact_solid_angle(x0, x0 + 1, y0, y0 + lamp.y_length, z);
    const Exact solid_angle = exact_solid_angle(x0, x1, y0, y1, z);
    const auto sine = [=](Exact b) { return b / std::sqrt(at_x * at_x + b * b + z * z); };
    const Exact du = exact_solid_angle(x0, at_x, y0, y1, z) / solid_angle - u;
    const Exact dv = (sine(at_y) - sine(y0)) / (sine(y1) - sine(y0)) - v;
    const auto decade = [](Exact a) { return int(std::floor(std::log10(a))); };
    const int slope = decade(z / (std::max(x1, -x0) + std::max(y1, -y0) + z));
    errors[std::max(decade(solid_angle), -10)][slope].add(std::max(std::abs(du), std::abs(dv)));
    errors[-99][slope].add(std::abs(exact(s.solid_angle) / unrounded - 1));
  }
  fmt::print("\n{}\n\n| Solid angle | 1e-1 | 1e-2 | 1e-3 | 1e-4 | 1e-5 | 1e-6 | 1e-7 |\n{}", name,
             "|---|---|---|---|---|---|---|---|\n");
  for (const int size : {0, -1, -2, -3, -4, -5, -6, -7, -8, -9, -99}) {
    fmt::print("| {} |", size < -9 ? "*its error*" : fmt::format("1e{}", size));
    for (int slope = -1; slope >= -7; --slope) errors[size][slope].print();
    fmt::print("\n");
  }
}

// Irradiance on a wall that stands `away` from the lamp's edge, by a million points of the square.
void measure_irradiance(float away, float height) {
  using D = hn::ScalableTag<float>;
  constexpr int n = 1024;
  double sum = 0, squares = 0;
  for (int i = 0; i < n * n; ++i) {
    const int column = i % n, row = i / n;
    const Real<D> u = (float(column) + 0.5f) / n, v = (float(row) + 0.5f) / n;
    const auto s = sample_rectangle<D>(lamp_of_width(1.0f), V3<D>(-away, 0.25f, height), u, v);
    const double light = hn::GetLane((s.inverse_pdf * s.direction.x).v);
    sum += light / n / n, squares += light * light / n / n;
  }
  // Lambert's formula: the two edges that are parallel to the wall, at distances h.
  const auto edge = [](double h) { return (std::atan(0.75 / h) + std::atan(0.25 / h)) / h; };
  const double exact =
      height * (edge(std::hypot(away, height)) - edge(std::hypot(away + 1.0, height))) / 2;
  fmt::print("| {} | {} | {:.3e} | {:+.4f} % | {:.2f} |\n", away, height, exact,
             100 * (sum / exact - 1), std::sqrt(squares / sum / sum - 1));
}

void measure() {
  measure_errors<float>("float"), measure_errors<double>("double");
  fmt::print("\nfloat\n\n| Away | Height | Lambert | Error | Noise |\n|---|---|---|---|---|\n");
  for (const float away : {0.05f, 1.0f, 5.0f}) {
    for (const float height : {0.3f, 0.003f, 3e-5f}) measure_irradiance(away, height);
  }
}

}  // namespace plumb::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
int main() { plumb::HWY_NAMESPACE::measure(); }
