// SPDX-License-Identifier: Apache-2.0

#include "compare/maps.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <stdexcept>
#include <string_view>

namespace plumb {
namespace {

constexpr int bar_height = 9;
constexpr int least_width = 96;

using Colour = std::array<float, 3>;

// Linear RGB for -1 to 1.
Colour diverging(double t) {
  const double size = std::min(std::abs(t), 1.0);
  const double L = 1.0 - 0.55 * size;
  const double hue = (t < 0.0 ? 264.0 : 29.0) * std::numbers::pi / 180.0;
  const double a = 0.2 * size * std::cos(hue);
  const double b = 0.2 * size * std::sin(hue);
  const double l = std::pow(L + 0.3963377774 * a + 0.2158037573 * b, 3.0);
  const double m = std::pow(L - 0.1055613458 * a - 0.0638541728 * b, 3.0);
  const double s = std::pow(L - 0.0894841775 * a - 1.2914855480 * b, 3.0);
  return {static_cast<float>(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
          static_cast<float>(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
          static_cast<float>(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s)};
}

void set(Image& image, int x, int y, const Colour& colour) {
  std::ranges::copy(colour, &image.values[image.pixel(x, y) * 3]);
}

// Draws digits three pixels wide and five high, with the left upper corner at x, y.
void write(Image& image, int x, int y, const std::string& text) {
  constexpr std::string_view characters = "0123456789.-+e";
  constexpr std::array<uint16_t, 14> glyphs = {// rows of three bits, from the top
                                               075557, 026227, 071747, 071717, 055711,
                                               074717, 074757, 071111, 075757, 075717,
                                               000002, 000700, 002720, 075747};
  for (const char character : text) {
    const unsigned glyph = glyphs[characters.find(character)];
    for (int bit = 0; bit < 15; ++bit) {
      if ((glyph >> (14 - bit) & 1U) != 0) set(image, x + bit % 3, y + bit / 3, {0, 0, 0});
    }
    x += 4;
  }
}

// 1, 2 or 5 times a power of ten, not below the absolute values but for one in 50.
double round_scale(std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  const auto high = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 49 / 50);
  std::ranges::nth_element(values, high);
  const double power = std::pow(10.0, std::floor(std::log10(std::max(*high, 1e-30))));
  for (const double step : {1.0, 2.0, 5.0}) {
    if (step * power >= *high * (1.0 - 1e-6)) return step * power;  // radiance is float
  }
  return 10.0 * power;
}

// Of the mean over the channels in a unit.
double value(MapKind kind, const Picture& test, const Picture& reference, const Window& w) {
  Pool pool;
  for_each_pixel(w, [&](int x, int y) {
    pool.add(mean_pair(test, reference, test.image.pixel(x, y)), test, reference);
  });
  const double difference = pool.test - pool.reference;
  const double variance = pool.test_variance + pool.reference_variance;
  if (kind == MapKind::difference) return difference;
  return variance > 0.0 ? difference / std::sqrt(variance) : 0.0;
}

}  // namespace

Image draw_map(MapKind kind, const Picture& test, const Picture& reference, const Window& window,
               const std::optional<Flip>& flip) {
  const bool is_flip = kind == MapKind::flip;
  if (is_flip && !flip) throw std::invalid_argument("--map flip needs --flip ldr or hdr");
  const int step = kind == MapKind::blocks ? block_side : 1;
  const auto place = [&](int x, int y) { return size_t(y) * size_t(window.width) + size_t(x); };
  std::vector<double> values;
  if (is_flip) values.assign(flip->map.begin(), flip->map.end());
  for (int y = 0; !is_flip && y < window.height; ++y) {
    for (int x = 0; x < window.width; ++x) {
      const int u = x / step * step;
      const int v = y / step * step;
      const Window unit{window.x + u, window.y + v, std::min(step, window.width - u),
                        std::min(step, window.height - v)};
      const bool is_drawn = x == u && y == v;  // else it is as the unit's first pixel
      values.push_back(is_drawn ? value(kind, test, reference, unit) : values[place(u, v)]);
    }
  }
  const double scale = is_flip ? 1.0 : kind == MapKind::difference ? round_scale(values) : 5.0;
  const std::string number = fmt::format("{:g}", scale);
  Image image{std::max(window.width, least_width),
              window.height + bar_height,
              {"R", "G", "B"},
              {},
              {.scale = number}};
  image.values.assign(image.pixel(0, image.height) * 3, 1.0F);
  for_each_pixel({0, 0, window.width, window.height},
                 [&](int x, int y) { set(image, x, y, diverging(values[place(x, y)] / scale)); });
  const double least = is_flip ? 0.0 : -1.0;
  for_each_pixel({0, window.height + 1, image.width, bar_height - 1}, [&](int x, int y) {
    set(image, x, y, diverging(least + (1.0 - least) * x / (image.width - 1)));
  });
  const int text = window.height + 3;
  write(image, 2, text, is_flip ? "0" : "-" + number);
  if (!is_flip) write(image, image.width / 2 - 1, text, "0");
  write(image, image.width - 4 * static_cast<int>(number.size() + 1) - 1, text, "+" + number);
  return image;
}

}  // namespace plumb
