// SPDX-License-Identifier: Apache-2.0

#include "scene_files/spectrum.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>

namespace plumb {
namespace {

// The colour matching functions of the CIE's standard observer of 1931 (2 degrees) and its standard
// illuminant D65, both of CIE 15, as published by the Colour & Vision Research Laboratory.
struct CieRow {
  double wavelength, x, y, z, d65;
};
constexpr CieRow cie_1931[] = {
#include "scene_files/cie_1931.inc"
};
constexpr int points = std::size(cie_1931);
constexpr double shortest = cie_1931[0].wavelength;
constexpr double longest = cie_1931[points - 1].wavelength;
constexpr double cie_y_integral = 106.7502593994140625;
constexpr double d65_luminance = 98.99741751876255;

// One of the columns, a pointer to a member of CieRow.
double tabulated(auto column, double wavelength) {
  const double position = (wavelength - shortest) / (longest - shortest) * (points - 1);
  const int i = std::clamp(static_cast<int>(position), 0, points - 2);
  const double below = cie_1931[i].*column, above = cie_1931[i + 1].*column;
  return below + (position - i) * (above - below);
}

double at(const Spectrum& spectrum, double wavelength) {
  if (wavelength < spectrum.front().first || wavelength > spectrum.back().first) return 0.0;
  const auto above = std::ranges::upper_bound(spectrum.begin() + 1, spectrum.end() - 1, wavelength,
                                              {}, &Spectrum::value_type::first);
  const auto& [w1, v1] = *above;
  const auto& [w0, v0] = above[-1];
  return v0 + (wavelength - w0) / (w1 - w0) * (v1 - v0);
}

Rgb to_rgb(const Vec3& xyz) {
  return {Vec3(3.240479, -1.537150, -0.498535).dot(xyz),
          Vec3(-0.969256, 1.875991, 0.041556).dot(xyz),
          Vec3(0.055648, -0.204043, 1.057311).dot(xyz)};
}

// Mitsuba's own sum, so that its error is ours, too.
Rgb integrate(const std::function<double(double)>& spectrum) {
  constexpr int steps = 1000;
  Vec3 xyz(0.0);
  for (int i = 0; i < steps; ++i) {
    const double w = shortest + i * (longest - shortest) / (steps - 1);
    xyz += Vec3(tabulated(&CieRow::x, w), tabulated(&CieRow::y, w), tabulated(&CieRow::z, w)) *
           spectrum(w);
  }
  return to_rgb(xyz * ((longest - shortest) / steps / cie_y_integral));
}

}  // namespace

Rgb reflectance_of(const Spectrum& spectrum, double highest) {
  Rgb rgb = integrate(
      [&](double w) { return at(spectrum, w) * tabulated(&CieRow::d65, w) / d65_luminance; });
  for (int c = 0; c < 3; ++c) rgb[c] = std::clamp(rgb[c], 0.0, highest);
  return rgb;
}

Rgb emission_of(const Spectrum& spectrum) {
  Rgb rgb = integrate([&](double w) { return at(spectrum, w); });
  for (int c = 0; c < 3; ++c) rgb[c] = std::max(rgb[c], 0.0);
  return rgb;
}

Rgb even_emission(double value) { return to_rgb(Vec3(value)); }

Spectrum black_body(double temperature) {
  constexpr double c = 2.99792458e8, h = 6.62607015e-34, k = 1.380649e-23;
  Spectrum spectrum;
  for (double nm = shortest; nm <= longest; nm += 1.0) {
    const double w = nm * 1e-9;
    const double power =
        2.0 * h * c * c / std::pow(w, 5) / std::expm1(h * c / (w * k * temperature));
    spectrum.emplace_back(nm, power * 1e-9);
  }
  return spectrum;
}

}  // namespace plumb
