// SPDX-License-Identifier: Apache-2.0

// Tables and numbers for documents and terminals.
#pragma once

#include <string>
#include <vector>

namespace plumb {

using TableRow = std::vector<std::string>;

// A Markdown table whose columns are aligned, so that it can be read in a terminal too. Without
// rows it is empty. Every row has as many cells as the head.
std::string table(const TableRow& head, const std::vector<TableRow>& rows);

// A number with so many significant digits; a large one without an exponent.
std::string rounded(double value, int digits);

// A part of a whole in per cent with two digits; "-" if the whole is 0.
std::string percent(double part, double whole = 1.0);

// "+12 ± 3.4 %" of two numbers in percent, the first of so many digits and the other of two; large
// ones without exponents, however.
std::string percent_with_error(double value, double error, int digits);

}  // namespace plumb
