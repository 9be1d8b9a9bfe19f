// Tables for documents and terminals.
#pragma once

#include <string>
#include <vector>

namespace plumb {

using TableRow = std::vector<std::string>;

// A Markdown table that is also fit for a terminal. No rows, no table.
std::string table(const TableRow& head, const std::vector<TableRow>& rows);

}  // namespace plumb
