// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "faults/clamp.h"
#include "faults/faults.h"
#include "faults/light_backs.h"
#include "faults/view.h"
#include "images/srgb.h"
#include "renderer/render.h"

namespace plumb {
namespace {

using Matrix = std::array<std::array<double, 3>, 3>;
using Kernel = std::vector<double>;  // from the middle on: it is symmetric

// Rec. 709's R, G and B in other primaries, white to white. The first is that of ITU-R BT.2087; the
// others follow likewise from the primaries of Display P3 and of ACEScg (Bradford from D65 to D60).
constexpr Matrix to_rec2020{
    {{0.6274, 0.3293, 0.0433}, {0.0691, 0.9195, 0.0114}, {0.0164, 0.0880, 0.8956}}};
constexpr Matrix to_p3{{{0.8225, 0.1775, 0.0}, {0.0332, 0.9668, 0.0}, {0.0171, 0.0724, 0.9105}}};
constexpr Matrix to_acescg{
    {{0.6131, 0.3395, 0.0474}, {0.0702, 0.9164, 0.0134}, {0.0206, 0.1096, 0.8698}}};

// A picture's linear R, G and B, row by row, to be changed in place.
class Values {
 public:
  Values(std::vector<float>& rgb, const Camera& camera)
      : rgb_(rgb), width_(camera.width), height_(camera.height) {}

  void turn(bool upside_down) {
    const std::vector<float> before = rgb_;
    for_each([&](int x, int y, size_t i) {
      const size_t from = upside_down ? at(x, height_ - 1 - y) : at(width_ - 1 - x, y);
      std::copy_n(&before[from], 3, &rgb_[i]);
    });
  }

  template <typename Curve>
  void map(Curve curve) {
    for (float& value : rgb_) value = static_cast<float>(curve(double{value}));
  }

  void convert(const Matrix& m) {
    for_each([&](int, int, size_t i) {
      const std::array<double, 3> c{rgb_[i], rgb_[i + 1], rgb_[i + 2]};
      for (size_t k = 0; k < 3; ++k) {
        rgb_[i + k] = static_cast<float>(m[k][0] * c[0] + m[k][1] * c[1] + m[k][2] * c[2]);
      }
    });
  }

  // Along rows and columns; over pixels of the same surface alone, if these are given.
  void convolve(const Kernel& kernel, const std::vector<std::ptrdiff_t>& surfaces = {}) {
    for (const bool along_x : {true, false}) {
      const std::vector<float> before = rgb_;
      for_each([&](int x, int y, size_t i) {
        const int place = along_x ? x : y, size = along_x ? width_ : height_;
        const int reach = static_cast<int>(kernel.size()) - 1;
        std::array<double, 3> sum{};
        double weights = 0.0;
        for (int k = std::max(-reach, -place); k <= std::min(reach, size - 1 - place); ++k) {
          const size_t j = along_x ? at(x + k, y) : at(x, y + k);
          if (!surfaces.empty() && surfaces[i / 3] != surfaces[j / 3]) continue;
          const double weight = kernel[static_cast<size_t>(std::abs(k))];
          weights += weight;
          for (size_t c = 0; c < 3; ++c) sum[c] += weight * double{before[j + c]};
        }
        for (size_t c = 0; c < 3; ++c) rgb_[i + c] = static_cast<float>(sum[c] / weights);
      });
    }
  }

  // A bilateral filter (Tomasi and Manduchi, "Bilateral filtering for gray and color images", ICCV
  // 1998), whose range is relative to the pixel.
  void denoise() {
    constexpr int reach = 4;
    constexpr double deviation = 2.0, range = 0.2;
    const std::vector<float> before = rgb_;
    const auto brightness = [&](size_t i) {
      return double{before[i]} + double{before[i + 1]} + double{before[i + 2]};
    };
    for_each([&](int x, int y, size_t i) {
      std::array<double, 3> sum{};
      double weights = 0.0;
      for (int v = std::max(y - reach, 0); v <= std::min(y + reach, height_ - 1); ++v) {
        for (int u = std::max(x - reach, 0); u <= std::min(x + reach, width_ - 1); ++u) {
          const size_t j = at(u, v);
          const double off = (brightness(j) - brightness(i)) / (range * brightness(i) + 1e-6);
          const double far = ((u - x) * (u - x) + (v - y) * (v - y)) / (deviation * deviation);
          const double weight = std::exp(-0.5 * (far + off * off));
          weights += weight;
          for (size_t c = 0; c < 3; ++c) sum[c] += weight * double{before[j + c]};
        }
      }
      for (size_t c = 0; c < 3; ++c) rgb_[i + c] = static_cast<float>(sum[c] / weights);
    });
  }

  void blacken(const std::vector<double>& depths, double most) {
    for (size_t i = 0; i < rgb_.size(); ++i) {
      if (depths[i / 3] > most) rgb_[i] = 0.0F;
    }
  }

 private:
  size_t at(int x, int y) const {
    return (static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x)) * 3;
  }

  template <typename Use>
  void for_each(Use use) const {
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) use(x, y, at(x, y));
    }
  }

  std::vector<float>& rgb_;
  int width_, height_;
};

Kernel gaussian(double deviation) {
  Kernel kernel;
  for (int k = 0; k <= std::ceil(3.0 * deviation); ++k) {
    kernel.push_back(std::exp(-0.5 * k * k / (deviation * deviation)));
  }
  return kernel;
}

// The integrals over the pixels of the filter with B = C = 1/3 (Mitchell and Netravali,
// "Reconstruction filters in computer graphics", SIGGRAPH 1988).
Kernel mitchell() {
  constexpr int steps = 1000;
  Kernel kernel(3);
  for (int i = 0; i < 2 * steps; ++i) {
    const double x = (i + 0.5) / steps;
    const double inner = 7.0 * x * x * x - 12.0 * x * x + 16.0 / 3.0;
    const double outer = -7.0 / 3.0 * x * x * x + 12.0 * x * x - 20.0 * x + 32.0 / 3.0;
    const double weight = (x < 1.0 ? inner : outer) / 6.0 / steps;
    kernel[static_cast<size_t>(std::lround(x))] += x < 0.5 ? 2.0 * weight : weight;
  }
  return kernel;
}

// What is done to a picture's values.
using Change = std::function<void(Values)>;

Change change_of(Fault fault, const Scene& scene, double n) {
  constexpr double gamma = 2.2;
  const auto by_curve = [](auto curve) { return [curve](Values v) { v.map(curve); }; };
  const auto by_matrix = [](const Matrix& m) { return [&m](Values v) { v.convert(m); }; };
  switch (fault) {
    case Fault::flipped: return [](Values v) { v.turn(true); };
    case Fault::mirrored: return [](Values v) { v.turn(false); };
    case Fault::mitchell_filter: return [](Values v) { v.convolve(mitchell()); };
    case Fault::srgb_encoded: return by_curve(srgb_of_linear);
    case Fault::gamma_encoded:
      return by_curve([](double c) { return std::pow(std::max(c, 0.0), 1.0 / gamma); });
    case Fault::srgb_decoded: return by_curve(linear_of_srgb);
    case Fault::gamma_decoded:
      return by_curve([](double c) { return std::pow(std::max(c, 0.0), gamma); });
    case Fault::clipped: return by_curve([](double c) { return std::min(c, 1.0); });
    case Fault::exposure: return by_curve([n](double c) { return n * c; });
    case Fault::clamp_indirect:
      return by_curve([n](double c) { return n / double{clamped_at} * c; });
    case Fault::rec2020_primaries: return by_matrix(to_rec2020);
    case Fault::p3_primaries: return by_matrix(to_p3);
    case Fault::acescg_primaries: return by_matrix(to_acescg);
    case Fault::blurred: return [n](Values v) { v.convolve(gaussian(n)); };
    case Fault::smeared:
      return [n, view = look_at(scene)](Values v) { v.convolve(gaussian(n), view.surfaces); };
    case Fault::far_clipped:
      return [n, view = look_at(scene)](Values v) { v.blacken(view.depths, n * view.farthest()); };
    case Fault::denoised: return [](Values v) { v.denoise(); };
    default: return {};
  }
}

// With the film's samples.
Film draw_as(const Film& film, const Scene& scene, const Settings& settings) {
  Film other(film.width(), film.height());
  render(scene, settings, {.samples = {0, film.samples_per_pixel()}}, other);
  return other;
}

// The light that has met one surface at most.
Film direct_light(const Film& film, const Scene& scene, Settings settings) {
  settings.bounces.last = std::min(settings.bounces.last, 1);
  return draw_as(film, scene, settings);
}

// The film with other values for each replicate.
Film film_of(const Film& film, const std::array<std::vector<float>, Film::replicates>& replicates) {
  const auto& counts = film.samples_per_replicate();
  Film result(film.width(), film.height());
  for (size_t r = 0; r < replicates.size(); ++r) {
    if (counts[r] == 0) continue;
    result.add_sums(static_cast<int>(r), counts[r], replicates[r], double(counts[r]));
  }
  return result;
}

Film smear_indirect(const Film& film, const Scene& scene, const Settings& settings, double pixels) {
  const Film direct = direct_light(film, scene, settings);
  View view = look_at(scene);
  for (size_t i = 0; i < view.surfaces.size(); ++i) {  // a pixel of a mirror is by itself
    if (view.shows_others[i]) view.surfaces[i] = -2 - static_cast<std::ptrdiff_t>(i);
  }
  std::array<std::vector<float>, Film::replicates> replicates;
  for (size_t r = 0; r < replicates.size(); ++r) {
    if (film.samples_per_replicate()[r] == 0) continue;
    const std::vector<float> sharp = direct.replicate_mean(static_cast<int>(r));
    std::vector<float>& all = replicates[r] = film.replicate_mean(static_cast<int>(r));
    std::ranges::transform(all, sharp, all.begin(), std::minus{});
    Values(all, scene.camera).convolve(gaussian(pixels), view.surfaces);
    std::ranges::transform(all, sharp, all.begin(), std::plus{});
  }
  return film_of(film, replicates);
}

// Each matte surface is a black lamp of that part of its reflectance, seen in mirrors, too.
Film add_ambient(const Film& film, Scene scene, Settings settings, double part) {
  for (Shape& shape : scene.shapes) {
    const bool is_matte = shape.bsdf.kind == Bsdf::Kind::diffuse;
    shape.radiance = is_matte ? part * shape.bsdf.reflectance : Rgb(0.0);
    if (is_matte) shape.bsdf.reflectance = Rgb(0.0);
  }
  light_backs(scene, [](const Shape& shape) { return shape.bsdf.two_sided; });
  scene.points.clear();
  scene.sky = Rgb(0.0);
  settings.bounces.first = 0;
  const Film glow = draw_as(film, scene, settings);
  std::array<std::vector<float>, Film::replicates> replicates;
  for (size_t r = 0; r < replicates.size(); ++r) {
    if (film.samples_per_replicate()[r] == 0) continue;
    replicates[r] = film.replicate_mean(static_cast<int>(r));
    std::ranges::transform(replicates[r], glow.replicate_mean(static_cast<int>(r)),
                           replicates[r].begin(), std::plus{});
  }
  return film_of(film, replicates);
}

}  // namespace

Film spoil(Fault fault, const Film& film, const Scene& scene, const Settings& settings,
           std::optional<double> number) {
  if (fault == Fault::none) return film;
  const auto& numbers = description(fault).numbers;
  const double n = number.value_or(numbers.empty() ? 0.0 : numbers.front());
  if (fault == Fault::smeared_indirect) return smear_indirect(film, scene, settings, n);
  if (fault == Fault::ambient) return add_ambient(film, scene, settings, n);
  const Change change = change_of(fault, scene, n);
  if (!change) return film;
  std::vector<float> mean = film.mean();
  change({mean, scene.camera});
  // Where the change is not linear, the replicates' mean is not that of the picture: they get it.
  std::array<std::vector<float>, Film::replicates> replicates;
  std::vector<double> off(mean.begin(), mean.end());
  const auto& counts = film.samples_per_replicate();
  for (size_t r = 0; r < replicates.size(); ++r) {
    if (counts[r] == 0) continue;
    replicates[r] = film.replicate_mean(static_cast<int>(r));
    change({replicates[r], scene.camera});
    const double share =
        static_cast<double>(counts[r]) / static_cast<double>(film.samples_per_pixel());
    for (size_t i = 0; i < off.size(); ++i) off[i] -= share * double{replicates[r][i]};
  }
  for (std::vector<float>& values : replicates) {
    for (size_t i = 0; i < values.size(); ++i) values[i] += static_cast<float>(off[i]);
  }
  return film_of(film, replicates);
}

}  // namespace plumb
