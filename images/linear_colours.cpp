// SPDX-License-Identifier: Apache-2.0

#include "images/linear_colours.h"

#include <ImathMatrix.h>
#include <ImfChromaticities.h>
#include <OpenImageIO/color.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

namespace plumb {
namespace {

using Imath::M44f;
using Imath::V3f;

// Tools that mean sRGB write a gamma of 1 / 0.45455, which approximates it, or state nothing.
std::string transfer_of(StoredImage& stored) {
  std::vector<std::string>& notes = stored.image.notes;
  if (stored.transfer.empty()) return "srgb";
  if (stored.transfer == "gamma") {
    if (std::abs(stored.gamma - 2.2F) > 0.01F) return "gamma";
    notes.emplace_back("Its gamma of 2.2 was taken as the curve of sRGB, which it approximates.");
    return "srgb";
  }
  for (const char* known : {"linear", "srgb", "rec709"}) {
    if (stored.transfer == known) return known;
  }
  notes.push_back(fmt::format("Its transfer function {} is not known: the curve of sRGB was taken.",
                              stored.transfer));
  return "srgb";
}

float linear_value(const std::string& transfer, float gamma, float code) {
  if (transfer == "srgb") return OIIO::sRGB_to_linear(code);
  if (transfer == "rec709") return OIIO::Rec709_to_linear(code);
  return std::pow(code, gamma);
}

// Calls `change` with each pixel's first value and its alpha.
template <typename Change>
void for_each_pixel(StoredImage& stored, Change change) {
  const size_t count = stored.image.channels.size();
  for (size_t p = 0; p < stored.image.values.size(); p += count) {
    float* pixel = &stored.image.values[p];
    change(pixel, stored.alpha < 0 ? 1.0F : pixel[stored.alpha]);
  }
}

// Integers that are multiplied by alpha are so as codes.
void undo_transfer(StoredImage& stored) {
  const std::string transfer = transfer_of(stored);
  Image& image = stored.image;
  const std::string name = transfer == "gamma" ? fmt::format("gamma{}", stored.gamma) : transfer;
  image.encoding += (stored.transfer.empty() ? ", assumed to be " : ", ") + name;
  image.tags["transfer function"] = name;
  if (transfer == "linear") return;
  image.encoding += ", made linear";
  const auto count = static_cast<int>(image.channels.size());
  for_each_pixel(stored, [&](float* pixel, float alpha) {
    const bool is_multiplied = !stored.is_alpha_straight && alpha > 0.0F && alpha < 1.0F;
    const float scale = is_multiplied ? alpha : 1.0F;
    for (int c = 0; c < count; ++c) {
      if (c == stored.alpha) continue;
      pixel[c] = scale * linear_value(transfer, stored.gamma, pixel[c] / scale);
    }
  });
}

void multiply_by_alpha(StoredImage& stored) {
  const bool is_straight = stored.alpha >= 0 && stored.is_alpha_straight;
  stored.image.tags["alpha"] = is_straight ? "straight" : "multiplied";
  if (!is_straight) return;
  const auto count = static_cast<int>(stored.image.channels.size());
  for_each_pixel(stored, [&](float* pixel, float alpha) {
    for (int c = 0; c < count; ++c) {
      if (c != stored.alpha) pixel[c] *= alpha;
    }
  });
  stored.image.notes.emplace_back("Its colours were multiplied by its alpha, which was straight.");
}

Imf::Chromaticities to_imf(const Chromaticities& c) {
  return {{c[0], c[1]}, {c[2], c[3]}, {c[4], c[5]}, {c[6], c[7]}};
}

// Of the tristimulus values X, Y and Z themselves, stored as R, G and B.
constexpr Chromaticities xyz = {1, 0, 0, 1, 0, 0, 1.0F / 3.0F, 1.0F / 3.0F};

// Programs round these numbers to three places and more.
bool is_same(const Chromaticities& a, const Chromaticities& b) {
  return std::ranges::equal(a, b, [](float x, float y) { return std::abs(x - y) < 0.001F; });
}

// For row vectors of linear R, G and B. What is white in one is white in the other, by Bradford's
// cones: Lam, "Metamerism and colour constancy", 1985. X, Y and Z have no white of their own.
M44f conversion(const Chromaticities& from, const Chromaticities& to) {
  if (is_same(from, xyz)) return Imf::XYZtoRGB(to_imf(to), 1.0F);
  const M44f cones(0.8951F, -0.7502F, 0.0389F, 0, 0.2664F, 1.7135F, -0.0685F, 0, -0.1614F, 0.0367F,
                   1.0296F, 0, 0, 0, 0, 1);
  const auto white = [&](const Chromaticities& c) {
    return V3f(c[6] / c[7], 1.0F, (1.0F - c[6] - c[7]) / c[7]) * cones;
  };
  M44f scale;
  scale.setScale(white(to) / white(from));
  return Imf::RGBtoXYZ(to_imf(from), 1.0F) * cones * scale * cones.inverse() *
         Imf::XYZtoRGB(to_imf(to), 1.0F);
}

// The places of R, G and B in each layer that has them.
std::vector<std::array<size_t, 3>> colours_of(const std::vector<std::string>& channels) {
  std::vector<std::array<size_t, 3>> found;
  for (size_t r = 0; r < channels.size(); ++r) {
    const std::string& name = channels[r];
    if (name != "R" && !name.ends_with(".R")) continue;
    const std::string layer = name.substr(0, name.size() - 1);
    const auto g = std::ranges::find(channels, layer + "G");
    const auto b = std::ranges::find(channels, layer + "B");
    if (g == channels.end() || b == channels.end()) continue;
    found.push_back({r, size_t(g - channels.begin()), size_t(b - channels.begin())});
  }
  return found;
}

// Multiplies the colours by the matrix, and their variances by its squares.
void convert_primaries(StoredImage& stored) {
  const Chromaticities from = stored.chromaticities.value_or(rec709);
  Image& image = stored.image;
  image.tags["primaries"] =
      is_same(from, rec709) ? "Rec. 709" : fmt::format("{}", fmt::join(from, " "));
  if (is_same(from, rec709)) return;
  const M44f matrix = conversion(from, rec709);
  M44f squares;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) squares[i][j] = matrix[i][j] * matrix[i][j];
  }
  image.is_converted = true;
  for (const std::array<size_t, 3>& places : colours_of(image.channels)) {
    const bool is_variance = image.channels[places[0]].starts_with("variance.");
    for_each_pixel(stored, [&](float* pixel, float) {
      V3f colour(pixel[places[0]], pixel[places[1]], pixel[places[2]]);
      colour = colour * (is_variance ? squares : matrix);
      for (int c = 0; c < 3; ++c) pixel[places[size_t(c)]] = colour[c];
    });
  }
  image.notes.push_back(
      fmt::format("Its primaries are not those of Rec. 709 but red {},{}, green {},{}, blue {},{}, "
                  "white {},{}: its colours were converted, {}. What Rec. 709 lacks is negative.",
                  from[0], from[1], from[2], from[3], from[4], from[5], from[6], from[7],
                  is_same(from, xyz) ? "as X, Y and Z" : "white to white"));
}

}  // namespace

void make_linear(StoredImage& stored) {
  stored.image.tags["transfer function"] = "linear";
  if (stored.is_integer) {
    undo_transfer(stored);
  } else if (!stored.transfer.empty() && stored.transfer != "linear") {
    stored.image.notes.push_back(
        fmt::format("Its numbers were taken as linear, though it states {}.", stored.transfer));
  }
  multiply_by_alpha(stored);
  convert_primaries(stored);
}

}  // namespace plumb
