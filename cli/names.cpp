#include "cli/names.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <locale>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string_view>

namespace plumb {
namespace {

constexpr int64_t largest_picture = int64_t{1} << 26;  // pixels

constexpr std::pair<std::string_view, Method> methods[] = {
    {"bsdf", Method::bsdf}, {"nee", Method::nee}, {"mis", Method::mis}};
constexpr std::pair<std::string_view, Sampler> samplers[] = {{"sobol", Sampler::sobol},
                                                             {"independent", Sampler::independent}};
constexpr std::pair<std::string_view, Precision> precisions[] = {{"float", Precision::float32},
                                                                 {"double", Precision::float64}};

[[noreturn]] void refuse(std::string_view text, std::string_view wanted) {
  throw std::invalid_argument(fmt::format("'{}' is not {}", text, wanted));
}

template <typename T, size_t n>
std::string word_for(T value, const std::pair<std::string_view, T> (&words)[n]) {
  return std::string(
      std::ranges::find(words, value, &std::pair<std::string_view, T>::second)->first);
}

template <typename T, size_t n>
T value_of(const std::string& text, const std::pair<std::string_view, T> (&words)[n]) {
  std::string all;
  for (const auto& [word, value] : words) {
    if (text == word) return value;
    all += fmt::format("{}{}", all.empty() ? "" : ", ", word);
  }
  refuse(text, fmt::format("one of {}", all));
}

template <typename T>
std::optional<T> whole(std::string_view text) {
  T value{};
  const char* end = text.data() + text.size();
  const auto [parsed_to, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc{} || parsed_to != end || value < 0) return std::nullopt;
  return value;
}

// The two numbers of "3:5".
template <typename T>
std::pair<std::optional<T>, std::optional<T>> pair(std::string_view text, char separator) {
  const size_t middle = text.find(separator);
  if (middle == std::string_view::npos) return {};
  return {whole<T>(text.substr(0, middle)), whole<T>(text.substr(middle + 1))};
}

// Not by std::from_chars, which not every standard library has for real numbers.
std::optional<double> real(const std::string& text) {
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  double value = 0.0;
  if (!(stream >> std::noskipws >> value) || stream.peek() != EOF) return std::nullopt;
  return value;
}

}  // namespace

std::string to_string(Method method) { return word_for(method, methods); }
std::string to_string(Sampler sampler) { return word_for(sampler, samplers); }
std::string to_string(Precision precision) { return word_for(precision, precisions); }

Method parse_method(const std::string& text) { return value_of(text, methods); }
Sampler parse_sampler(const std::string& text) { return value_of(text, samplers); }
Precision parse_precision(const std::string& text) { return value_of(text, precisions); }

std::string to_string(const SampleRange& samples) {
  return fmt::format("{}:{}", samples.first, samples.last);
}

SampleRange parse_samples(const std::string& text) {
  const auto [first, last] = pair<int64_t>(text, ':');
  if (!first || !last || *first >= *last || *last > largest_sample) {
    refuse(text, fmt::format("a range A:B with 0 <= A < B <= {}", largest_sample));
  }
  return {*first, *last};
}

std::string to_string(const BounceRange& bounces) {
  if (bounces.last == BounceRange{}.last) return fmt::format("{}:", bounces.first);
  return fmt::format("{}:{}", bounces.first, bounces.last);
}

BounceRange parse_bounces(const std::string& text) {
  if (const auto one = whole<int>(text)) return {*one, *one};
  const std::string closed = text + (text.ends_with(':') ? std::to_string(BounceRange{}.last) : "");
  const auto [first, last] = pair<int>(closed, ':');
  if (!first || !last || *first > *last) refuse(text, "a range A:B with 0 <= A <= B");
  return {*first, *last};
}

int64_t parse_whole(const std::string& text, int64_t least, int64_t most) {
  const auto value = whole<int64_t>(text);
  if (!value || *value < least || *value > most) {
    refuse(text, fmt::format("a whole number from {} to {}", least, most));
  }
  return *value;
}

double parse_positive(const std::string& text) {
  const auto value = real(text);
  if (!value || !(*value > 0.0)) refuse(text, "a number above 0");
  return *value;
}

double parse_between(const std::string& text, double least, double most) {
  const auto value = real(text);
  if (!value || !(*value >= least && *value <= most)) {
    refuse(text, fmt::format("a number from {} to {}", least, most));
  }
  return *value;
}

double parse_fraction(const std::string& text) {
  if (!text.ends_with('%')) return parse_positive(text);
  return parse_positive(text.substr(0, text.size() - 1)) / 100.0;
}

std::pair<int, int> parse_size(const std::string& text) {
  const auto [width, height] = pair<int>(text, 'x');
  if (width.value_or(0) < 1 || height.value_or(0) < 1 ||
      int64_t{*width} * *height > largest_picture) {
    refuse(text, fmt::format("a size WxH of at most {} pixels", largest_picture));
  }
  return {*width, *height};
}

}  // namespace plumb
