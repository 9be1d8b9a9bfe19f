// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "compare/markdown.h"
#include "faults/faults.h"

namespace plumb::cli {
namespace {

const char* word(FaultSite site) {
  constexpr const char* words[] = {"scene", "integrator", "picture"};
  return words[static_cast<size_t>(site)];
}

std::string table_of(bool set_ups) {
  std::vector<TableRow> rows;
  for (const FaultDescription& row : faults()) {
    if (row.is_set_up != set_ups) continue;
    rows.push_back({"`" + row.name + "`", row.text, word(row.site), row.made, row.met, row.shows});
  }
  return table({set_ups ? "set-up" : "bug", "what it is", "in", "how it is made", "where it is met",
                "what shows it"},
               rows);
}

}  // namespace

void add_faults(CLI::App& app, int&) {
  CLI::App& command = *app.add_subcommand("faults", "List what can be wrong with a picture");
  command.footer(R"(The names are for 'plumb render --fault', 'plumb power --fault' and what
'plumb diagnose' says. Bugs come first, then differences of set-up.

Exit codes: 0 done, 2 trouble.)");
  command.callback([] { fmt::print("{}{}", table_of(false), table_of(true)); });
}

}  // namespace plumb::cli
