// SPDX-License-Identifier: Apache-2.0

#include "compare/markdown.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace plumb {

std::string rounded(double value, int digits) {
  const bool has_more = std::abs(value) >= std::pow(10.0, digits) - 0.5;
  return has_more ? fmt::format("{:.0f}", value) : fmt::format("{:.{}g}", value, digits);
}

namespace {

// Of UTF-8.
size_t letters(const std::string& text) {
  return std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; });
}

}  // namespace

std::string table(const TableRow& head, const std::vector<TableRow>& rows) {
  if (rows.empty()) return "";
  const auto line = [&](const TableRow& cells, char fill) {
    std::string text = "|";
    for (size_t c = 0; c < head.size(); ++c) {
      size_t width = letters(head[c]);
      for (const TableRow& row : rows) width = std::max(width, letters(row[c]));
      text += fill;
      text += cells[c];
      text.append(width - letters(cells[c]) + 1, fill);
      text += '|';
    }
    return text + "\n";
  };
  std::string text = "\n";
  text += line(head, ' ') + line(TableRow(head.size()), '-');
  for (const TableRow& row : rows) text += line(row, ' ');
  return text;
}

std::string percent(double part, double whole) {
  if (whole == 0.0) return "-";
  return rounded(100.0 * part / std::abs(whole), 2) + " %";
}

std::string percent_with_error(double value, double error, int digits) {
  return fmt::format("{}{} ± {} %", std::signbit(value) ? "" : "+", rounded(value, digits),
                     rounded(error, 2));
}

}  // namespace plumb
