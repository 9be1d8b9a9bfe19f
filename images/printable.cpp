// SPDX-License-Identifier: Apache-2.0

#include "images/printable.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace plumb {
namespace {

// How many bytes the first character has; 0 if they are not UTF-8 or nothing that is seen.
size_t visible_length(std::string_view text) {
  const auto byte = [&](size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U;
  };
  const unsigned first = byte(0);
  if (first < 0x80) return first >= ' ' && first != 0x7f ? 1 : 0;
  if (first < 0xc2 || first > 0xf4) return 0;
  const size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  unsigned code = first & (0x7fU >> length);
  for (size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0U) != 0x80) return 0;
    code = code << 6 | (byte(i) & 0x3fU);
  }
  constexpr unsigned least[] = {0, 0, 0xa0, 0x800, 0x10000};
  // Characters without width and those that turn the direction of writing would hide or reorder
  // text.
  const bool is_hidden = (code >= 0x200b && code <= 0x200f) || (code >= 0x2028 && code <= 0x202e) ||
                         (code >= 0x2060 && code <= 0x206f) || code == 0xfeff;
  const bool is_surrogate = code >= 0xd800 && code < 0xe000;
  const bool is_no_character = code > 0x10ffff || (code & 0xfffeU) == 0xfffe;  // XML has none
  const bool is_bad = code < least[length] || is_surrogate || is_no_character || is_hidden;
  return is_bad ? 0 : length;
}

}  // namespace

std::string printable(std::string_view text, LineEnds ends) {
  std::string result;
  while (!text.empty()) {
    const bool is_kept = ends == LineEnds::kept && text[0] == '\n';
    const size_t length = is_kept ? 1 : visible_length(text);
    if (length > 0) {
      result += text.substr(0, length);
    } else {
      result += fmt::format("\\x{:02x}", static_cast<unsigned char>(text[0]));
    }
    text.remove_prefix(std::max(length, size_t{1}));
  }
  return result;
}

std::array<std::string, 2> told_apart(double a, double b) {
  constexpr int most = std::numeric_limits<double>::max_digits10;
  std::array<std::string, 2> texts;
  for (int digits = 4; digits <= most && texts[0] == texts[1]; ++digits) {
    texts = {fmt::format("{:.{}g}", a, digits), fmt::format("{:.{}g}", b, digits)};
    if (a == b) break;
  }
  return texts;
}

}  // namespace plumb
