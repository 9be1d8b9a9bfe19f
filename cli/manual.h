// SPDX-License-Identifier: Apache-2.0

// The manual's pages and what shells complete, both from the commands as they are parsed. Commands
// without a group are left out, as in the help.
#pragma once

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace plumb::cli {

struct OptionWords {
  std::vector<std::string> names;  // "-o", "--output"; of a positional the one name without dashes
  std::string value;               // what stands for it, "FILE"; empty for flags
  std::string text;                // what it does, in one line
  std::vector<std::string> words;  // that it takes; empty if it takes others, too
  bool takes_files = false;
  bool is_list = false;  // with commas between
  bool is_repeated = false;

  bool is_positional() const { return !names[0].starts_with('-'); }
};

std::vector<OptionWords> options_of(CLI::App& command);
std::vector<CLI::App*> commands_of(CLI::App& app);

// A page for `man`, in roff.
std::string man_page(CLI::App& app, CLI::App& command);

// Scripts for shells.
std::string bash_completion(CLI::App& app);
std::string zsh_completion(CLI::App& app);
std::string fish_completion(CLI::App& app);

}  // namespace plumb::cli
