// SPDX-License-Identifier: Apache-2.0

// Values as words, the same on the command line and in images. All parsers throw
// std::invalid_argument, which says what the text should have been.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "faults/faults.h"
#include "images/window.h"
#include "renderer/settings.h"
#include "scene/scene.h"
#include "scene_files/region_mask.h"

namespace plumb {

// The words for the values of an enumeration.
template <typename Enum>
using Words = std::vector<std::pair<std::string, Enum>>;

inline const Words<Method> method_words{
    {"bsdf", Method::bsdf}, {"nee", Method::nee}, {"mis", Method::mis}, {"plain", Method::plain}};
inline const Words<Sampler> sampler_words{{"sobol", Sampler::sobol},
                                          {"independent", Sampler::independent}};
inline const Words<Precision> precision_words{{"float", Precision::float32},
                                              {"double", Precision::float64}};

inline const Words<RegionKind> region_words{
    {"object", RegionKind::object}, {"side", RegionKind::side}, {"shadow", RegionKind::shadow}};

template <typename Enum>
std::string to_word(Enum value, const Words<Enum>& words) {
  return std::ranges::find(words, value, &Words<Enum>::value_type::second)->first;
}

[[noreturn]] inline void refuse(const std::string& text, const std::string& wanted) {
  throw std::invalid_argument(fmt::format("'{}' is not {}", text, wanted));
}

// A parser of the words.
template <typename Enum>
auto one_of(const Words<Enum>& words) {
  return [&words](const std::string& text) {
    std::string all;
    for (const auto& [word, value] : words) {
      if (text == word) return value;
      all += (all.empty() ? "" : ", ") + word;
    }
    refuse(text, "one of " + all);
  };
}

inline std::string fault_name(Fault fault) {
  return fault == Fault::none ? "none"
                              : std::ranges::find(faults(), fault, &FaultDescription::fault)->name;
}

inline Fault parse_fault(const std::string& text) {
  std::string all;
  for (const FaultDescription& known : faults()) {
    if (text == known.name) return known.fault;
    all += fmt::format("\n  {:<20}{}", known.name, known.text);
  }
  refuse(text, "one of" + all);
}

// A parser of numbers in a range.
template <typename T>
auto number(T least, T most) {
  return [=](const std::string& text) {
    // Wide enough to see what is out of range. Not by std::from_chars, which not every standard
    // library has for real numbers.
    std::conditional_t<std::is_integral_v<T>, int64_t, double> value{};
    std::istringstream stream(text);
    const bool is_number = (stream >> std::noskipws >> value) && stream.eof();
    if (is_number && value >= least && value <= most) return static_cast<T>(value);
    const char* kind = std::is_integral_v<T> ? "whole number" : "number";
    refuse(text, fmt::format("a {} from {} to {}", kind, least, most));
  };
}

// The numbers of "3:5".
template <typename T>
std::pair<T, T> parse_pair(const std::string& text, char separator, T least, T most) {
  const size_t middle = text.find(separator);
  if (middle == std::string::npos) refuse(text, fmt::format("of the form A{}B", separator));
  const auto parse = number(least, most);
  return {parse(text.substr(0, middle)), parse(text.substr(middle + 1))};
}

// "640x480", each side as in a scene file.
inline std::pair<int, int> parse_size(const std::string& text) {
  return parse_pair(text, 'x', 1, largest_image_side);
}

// "16,0,640,480": x and y of the first pixel, width and height.
inline std::string to_string(const Window& w) {
  return fmt::format("{},{},{},{}", w.x, w.y, w.width, w.height);
}

inline Window parse_window(const std::string& text) {
  std::istringstream stream(text);
  Window w;
  char a = 0, b = 0, c = 0;
  stream >> w.x >> a >> w.y >> b >> w.width >> c >> w.height;
  const bool has_form = stream && stream.peek() == EOF && a == ',' && b == ',' && c == ',';
  if (!has_form || w.x < 0 || w.y < 0 || w.width < 1 || w.height < 1)
    refuse(text, "of the form X,Y,WIDTH,HEIGHT");
  return w;
}

// "0.01" or "1%".
inline double parse_fraction(const std::string& text) {
  if (!text.ends_with('%')) return number(1e-6, 1.0)(text);
  return number(1e-4, 100.0)(text.substr(0, text.size() - 1)) / 100.0;
}

// "64:128", the last one left out.
inline std::string to_string(const SampleRange& samples) {
  return fmt::format("{}:{}", samples.first, samples.last);
}

inline SampleRange parse_samples(const std::string& text) {
  const auto [first, last] = parse_pair<int64_t>(text, ':', 0, largest_sample);
  if (first >= last) refuse(text, "a range A:B with A < B");
  return {first, last};
}

// "2:5", the last one included; "2:" for 2 and more.
inline std::string to_string(const BounceRange& bounces) {
  const bool is_open = bounces.last == BounceRange{}.last;
  return fmt::format("{}:{}", bounces.first, is_open ? "" : std::to_string(bounces.last));
}

inline BounceRange parse_bounces(const std::string& text) {
  constexpr int most = BounceRange{}.last;
  const std::string closed = text.ends_with(':') ? text + std::to_string(most) : text;
  const auto [first, last] = parse_pair(closed, ':', 0, most);
  if (first > last) refuse(text, "a range A:B with A <= B");
  return {first, last};
}

}  // namespace plumb
