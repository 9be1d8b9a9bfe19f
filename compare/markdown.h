// Tables for documents and terminals.
#pragma once

#include <string>
#include <vector>

namespace plumb {

using Row = std::vector<std::string>;

// A Markdown table that is also fit for a terminal. No rows, no table.
std::string table(const Row& head, const std::vector<Row>& rows);

}  // namespace plumb
