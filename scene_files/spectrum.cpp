#include "scene_files/spectrum.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace plumb {
namespace {

// The colour matching functions of the CIE's standard observer of 1931 (2 degrees) and its standard
// illuminant D65, both of CIE 15, as published by the Colour & Vision Research Laboratory.
constexpr int points = 95;  // from 360 to 830 nm, 5 nm apart
constexpr double cie_x[points] = {
    .0001299,      .0002321,      .0004149,      .0007416,      .001368,      .002236,
    .004243,       .00765,        .01431,        .02319,        .04351,       .07763,
    .13438,        .21477,        .2839,         .3285,         .34828,       .34806,
    .3362,         .3187,         .2908,         .2511,         .19536,       .1421,
    .09564,        .05795001,     .03201,        .0147,         .0049,        .0024,
    .0093,         .0291,         .06327,        .1096,         .1655,        .2257499,
    .2904,         .3597,         .4334499,      .5120501,      .5945,        .6784,
    .7621,         .8425,         .9163,         .9786,         1.0263,       1.0567,
    1.0622,        1.0456,        1.0026,        .9384,         .8544499,     .7514,
    .6424,         .5419,         .4479,         .3608,         .2835,        .2187,
    .1649,         .1212,         .0874,         .0636,         .04677,       .0329,
    .0227,         .01584,        .01135916,     .008110916,    .005790346,   .004109457,
    .002899327,    .00204919,     .001439971,    .0009999493,   .0006900786,  .0004760213,
    .0003323011,   .0002348261,   .0001661505,   .000117413,    .00008307527, .00005870652,
    .00004150994,  .00002935326,  .00002067383,  .00001455977,  .00001025398, .000007221456,
    .000005085868, .000003581652, .000002522525, .000001776509, .000001251141};
constexpr double cie_y[points] = {
    .000003917,  .000006965,   .00001239,    .00002202,   .000039,     .000064,     .00012,
    .000217,     .000396,      .00064,       .00121,      .00218,      .004,        .0073,
    .0116,       .01684,       .023,         .0298,       .038,        .048,        .06,
    .0739,       .09098,       .1126,        .13902,      .1693,       .20802,      .2586,
    .323,        .4073,        .503,         .6082,       .71,         .7932,       .862,
    .9148501,    .954,         .9803,        .9949501,    1,           .995,        .9786,
    .952,        .9154,        .87,          .8163,       .757,        .6949,       .631,
    .5668,       .503,         .4412,        .381,        .321,        .265,        .217,
    .175,        .1382,        .107,         .0816,       .061,        .04458,      .032,
    .0232,       .017,         .01192,       .00821,      .005723,     .004102,     .002929,
    .002091,     .001484,      .001047,      .00074,      .00052,      .0003611,    .0002492,
    .0001719,    .00012,       .0000848,     .00006,      .0000424,    .00003,      .0000212,
    .00001499,   .0000106,     .0000074657,  .0000052578, .0000037029, .0000026078, .0000018366,
    .0000012934, .00000091093, .00000064153, .00000045181};
constexpr double cie_z[points] = {.0006061,  .001086,    .001946,   .003486,    .006450001,
                                  .01054999, .02005001,  .03621,    .06785001,  .1102,
                                  .2074,     .3713,      .6456,     1.0390501,  1.3856,
                                  1.62296,   1.74706,    1.7826,    1.77211,    1.7441,
                                  1.6692,    1.5281,     1.28764,   1.0419,     .8129501,
                                  .6162,     .46518,     .3533,     .272,       .2123,
                                  .1582,     .1117,      .07824999, .05725001,  .04216,
                                  .02984,    .0203,      .0134,     .008749999, .005749999,
                                  .0039,     .002749999, .0021,     .0018,      .001650001,
                                  .0014,     .0011,      .001,      .0008,      .0006,
                                  .00034,    .00024,     .00019,    .0001,      .00004999999,
                                  .00003,    .00002,     .00001,    0,          0,
                                  0,         0,          0,         0,          0,
                                  0,         0,          0,         0,          0,
                                  0,         0,          0,         0,          0,
                                  0,         0,          0,         0,          0,
                                  0,         0,          0,         0,          0,
                                  0,         0,          0,         0,          0,
                                  0,         0,          0,         0,          0};
constexpr double d65[points] = {
    46.6383, 49.3637, 52.0891, 51.0323, 49.9755, 52.3118, 54.6482, 68.7015, 82.7549, 87.1204,
    91.486,  92.4589, 93.4318, 90.057,  86.6823, 95.7736, 104.865, 110.936, 117.008, 117.41,
    117.812, 116.336, 114.861, 115.392, 115.923, 112.367, 108.811, 109.082, 109.354, 108.578,
    107.802, 106.296, 104.79,  106.239, 107.689, 106.047, 104.405, 104.225, 104.046, 102.023,
    100,     98.1671, 96.3342, 96.0611, 95.788,  92.2368, 88.6856, 89.3459, 90.0062, 89.8026,
    89.5991, 88.6489, 87.6987, 85.4936, 83.2886, 83.4939, 83.6992, 81.863,  80.0268, 80.1207,
    80.2146, 81.2462, 82.2778, 80.281,  78.2842, 74.0027, 69.7213, 70.6652, 71.6091, 72.979,
    74.349,  67.9765, 61.604,  65.7448, 69.8856, 72.4863, 75.087,  69.3398, 63.5927, 55.0054,
    46.4182, 56.6118, 66.8054, 65.0941, 63.3828, 63.8434, 64.304,  61.8779, 59.4519, 55.7054,
    51.959,  54.6998, 57.4406, 58.8765, 60.3125};
constexpr double shortest = 360.0;
constexpr double longest = 830.0;
constexpr double cie_y_integral = 106.7502593994140625;
constexpr double d65_luminance = 98.99741751876255;

double at(const double (&table)[points], double wavelength) {
  const double position = (wavelength - shortest) / (longest - shortest) * (points - 1);
  const int i = std::clamp(static_cast<int>(position), 0, points - 2);
  return table[i] + (position - i) * (table[i + 1] - table[i]);
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
    xyz += Vec3(at(cie_x, w), at(cie_y, w), at(cie_z, w)) * spectrum(w);
  }
  return to_rgb(xyz * ((longest - shortest) / steps / cie_y_integral));
}

}  // namespace

Rgb reflectance_of(const Spectrum& spectrum) {
  Rgb rgb = integrate([&](double w) { return at(spectrum, w) * at(d65, w) / d65_luminance; });
  for (int c = 0; c < 3; ++c) rgb[c] = std::clamp(rgb[c], 0.0, 1.0);
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
