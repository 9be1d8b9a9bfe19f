// SPDX-License-Identifier: Apache-2.0

// What files say, as it may be shown: on terminals, in JSON and in XML.
#pragma once

#include <array>
#include <string>
#include <string_view>

namespace plumb {

enum class LineEnds { escaped, kept };

// The text with "\x1b" and so on for the bytes of control characters and of what is not UTF-8.
std::string printable(std::string_view text, LineEnds ends = LineEnds::escaped);

// Two numbers with four digits, or with as many as show that they differ.
std::array<std::string, 2> told_apart(double a, double b);

}  // namespace plumb
