// SPDX-License-Identifier: Apache-2.0

#include "compare/flip.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <tuple>

namespace plumb {
namespace {

using Channel = std::vector<float>;  // a value per pixel
using Kernel = std::vector<float>;   // weights, the middle one for the pixel itself
using Colour = std::array<float, 3>;
using Colours = std::vector<Colour>;
using Matrix = std::array<Colour, 3>;

// Linear RGB to X Y Z over those of white, by rows, and back.
constexpr Matrix to_xyz{{{0.4338954F, 0.3762424F, 0.1898622F},
                         {0.2126368F, 0.7151830F, 0.0721802F},
                         {0.0177524F, 0.1094656F, 0.8727819F}}};
constexpr Matrix to_rgb{{{3.0803420F, -1.5373990F, -0.5429430F},
                         {-0.9211784F, 1.8759300F, 0.0452484F},
                         {0.0528813F, -0.2040112F, 1.1511299F}}};

Colour operator*(const Matrix& rows, const Colour& c) {
  const auto dot = [&](const Colour& r) { return r[0] * c[0] + r[1] * c[1] + r[2] * c[2]; };
  return {dot(rows[0]), dot(rows[1]), dot(rows[2])};
}

// Weights from -3 to 3 deviations: the positive ones add up to 1, the negative ones to -1.
template <typename Weight>
Kernel kernel(double deviation, Weight weight) {
  const int radius = static_cast<int>(std::ceil(3.0 * deviation));
  std::array<double, 2> sums{};
  for (int x = -radius; x <= radius; ++x) sums[weight(x) < 0.0] += std::abs(weight(x));
  Kernel weights;
  for (int x = -radius; x <= radius; ++x) {
    weights.push_back(static_cast<float>(weight(x) / sums[weight(x) < 0.0]));
  }
  return weights;
}

// Beyond the edge is as at the edge.
Channel convolve(const Channel& channel, int width, const Kernel& across, const Kernel& down) {
  const int height = static_cast<int>(channel.size()) / width;
  const auto pass = [&](const Channel& from, const Kernel& weights, int dx, int dy) {
    const int radius = static_cast<int>(weights.size() / 2);
    const float* const weight = &weights[weights.size() / 2];
    Channel to(from.size());
    tbb::parallel_for(0, height * width, [&](int i) {
      for (int k = -radius; k <= radius; ++k) {
        const int x = std::clamp(i % width + k * dx, 0, width - 1);
        const int y = std::clamp(i / width + k * dy, 0, height - 1);
        to[size_t(i)] += weight[k] * from[size_t(y) * size_t(width) + size_t(x)];
      }
    });
    return to;
  };
  return pass(pass(channel, across, 1, 0), down, 0, 1);
}

// CIELAB with Hunt's effect: colours look paler in the dark.
Colour hunt_lab(const Colour& rgb) {
  Colour f = to_xyz * rgb;
  for (float& t : f) t = t > 216.0F / 24389.0F ? std::cbrt(t) : t * 841.0F / 108.0F + 4.0F / 29.0F;
  const float L = 116.0F * f[1] - 16.0F;
  return {L, 5.0F * L * (f[0] - f[1]), 2.0F * L * (f[1] - f[2])};
}

// HyAB distance (Abasi et al. 2020), compressed.
float distance(const Colour& a, const Colour& b) {
  return std::pow(std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]), 0.7F);
}

// What the eye makes of a picture: colours, and how strong edges and points are.
struct Sight {
  Colours lab;
  Channel edges, points;
};

Sight see(const Colours& rgb, int width, double pixels_per_degree) {
  Channel Y, Cx, Cz;  // but for scale and offset
  for (const Colour& colour : rgb) {
    const Colour xyz = to_xyz * colour;
    Y.push_back(xyz[1]);
    Cx.push_back(xyz[0] - xyz[1]);
    Cz.push_back(xyz[1] - xyz[2]);
  }
  const double s = 0.5 * 0.082 * pixels_per_degree;
  const auto gaussian = [=](double x) { return std::exp(-x * x / (2.0 * s * s)); };
  const auto strength = [&](const auto& shape) {
    const Kernel weights = kernel(s, [&](double x) { return shape(x) * gaussian(x); });
    const Kernel blur = kernel(s, gaussian);
    Channel across = convolve(Y, width, weights, blur);
    const Channel down = convolve(Y, width, blur, weights);
    for (size_t i = 0; i < across.size(); ++i) across[i] = std::hypot(across[i], down[i]);
    return across;
  };
  Sight sight;
  sight.edges = strength([](double x) { return -x; });
  sight.points = strength([=](double x) { return x * x / (s * s) - 1.0; });
  // By the contrast sensitivity: sums of a sqrt(pi / b) exp(-pi^2 x^2 / b), with x in degrees.
  const auto blurred = [&](const Channel& channel, double b) {
    const double x = std::numbers::pi / pixels_per_degree;  // a pixel's, times pi
    const Kernel k =
        kernel(std::sqrt(0.02) / x, [=](double n) { return std::exp(-n * n * x * x / b); });
    return convolve(channel, width, k, k);
  };
  // What the narrow one of the two Gaussians in Cz has of their integral, a sqrt(b) each.
  const float part =
      13.5F * std::sqrt(0.025F) / (13.5F * std::sqrt(0.025F) + 34.1F * std::sqrt(0.04F));
  const Channel luminance = blurred(Y, 0.0047), red = blurred(Cx, 0.0053);
  const Channel wide = blurred(Cz, 0.04), narrow = blurred(Cz, 0.025);
  for (size_t i = 0; i < rgb.size(); ++i) {
    const float y = luminance[i];
    Colour seen = to_rgb * Colour{red[i] + y, y, y - wide[i] - part * (narrow[i] - wide[i])};
    for (float& value : seen) value = std::clamp(value, 0.0F, 1.0F);
    sight.lab.push_back(hunt_lab(seen));
  }
  return sight;
}

float difference(const Sight& a, const Sight& b, size_t i) {
  static const float largest = distance(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1}));
  const float d = distance(a.lab[i], b.lab[i]) / largest;
  const float colour = d < 0.4F ? 0.95F * d / 0.4F : 0.95F + 0.05F * (d - 0.4F) / 0.6F;
  const float feature =
      std::max(std::abs(a.edges[i] - b.edges[i]), std::abs(a.points[i] - b.points[i]));
  return std::pow(colour, std::max(0.0F, 1.0F - std::sqrt(feature / std::numbers::sqrt2_v<float>)));
}

Colours linear(const Picture& picture, const Window& w) {
  Colours colours(size_t(w.width) * size_t(w.height));
  for (size_t i = 0; i < 3 * colours.size(); ++i) {
    const int x = w.x + int(i / 3 % size_t(w.width)), y = w.y + int(i / 3 / size_t(w.width));
    colours[i / 3][i % 3] = float(picture.value(picture.image.pixel(x, y), i % picture.averaged));
  }
  return colours;
}

// For HDR by Narkowicz's fit of the ACES tone mapper.
Colours shown(Colours colours, FlipKind kind, double exposure) {
  for (Colour& colour : colours) {
    for (float& value : colour) {
      const double v = value * std::exp2(exposure);
      const double mapped = v * (0.9036 * v + 0.018) / (v * (0.8748 * v + 0.354) + 0.14);
      value = static_cast<float>(std::clamp(kind == FlipKind::hdr ? mapped : v, 0.0, 1.0));
    }
  }
  return colours;
}

// First and last.
std::pair<double, double> exposures(const Colours& reference) {
  std::vector<double> luminances;
  for (const Colour& rgb : reference) luminances.push_back((to_xyz * rgb)[1]);
  if (median(luminances) <= 0.0) std::erase_if(luminances, [](double l) { return l <= 0.0; });
  if (luminances.empty()) return {0.0, 0.0};
  constexpr double bright = 2.118873;  // which is shown at 0.85
  return {std::log2(bright / std::ranges::max(luminances)), std::log2(bright / median(luminances))};
}

}  // namespace

Flip flip(FlipKind kind, const Picture& test, const Picture& reference, const Window& window,
          const Regions& regions, double pixels_per_degree) {
  if (test.averaged != 3 && test.averaged != 1) {
    throw std::invalid_argument("FLIP needs three channels (R G B) or one");
  }
  const Colours a = linear(test, window), b = linear(reference, window);
  Flip result{.kind = kind, .map = Channel(a.size()), .pixels_per_degree = pixels_per_degree};
  if (kind == FlipKind::hdr) std::tie(result.first_exposure, result.last_exposure) = exposures(b);
  const double range = result.last_exposure - result.first_exposure;
  const double steps = kind == FlipKind::hdr ? std::max(1.0, std::ceil(range) - 1.0) : 0.0;
  for (double step = 0.0; step <= steps; ++step) {
    const double exposure = result.first_exposure + range * step / std::max(steps, 1.0);
    const Sight of_test = see(shown(a, kind, exposure), window.width, pixels_per_degree);
    const Sight of_reference = see(shown(b, kind, exposure), window.width, pixels_per_degree);
    for (size_t i = 0; i < a.size(); ++i) {
      result.map[i] = std::max(result.map[i], difference(of_test, of_reference, i));
    }
  }
  std::vector<double> values;
  for_each_pixel(window, [&, value = result.map.begin()](int x, int y) mutable {
    const double here{*value++};
    if (regions.hold(test.image.pixel(x, y))) values.push_back(here);
  });
  if (values.empty()) return result;
  result.mean =
      std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  const auto high = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 19 / 20);
  std::ranges::nth_element(values, high);
  result.p95 = *high;
  return result;
}

}  // namespace plumb
