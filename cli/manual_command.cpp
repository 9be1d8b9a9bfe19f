// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <sstream>

#include "cli/commands.h"
#include "cli/manual.h"
#include "images/output_file.h"

namespace plumb::cli {
namespace {

namespace fs = std::filesystem;

// Every parser that knows words names them when it refuses another: "one of a, b, and no FILE", or
// a line for each, "one of\n  a  what it is".
std::vector<std::string> words_of(CLI::Option& option) {
  std::string refusal;
  try {
    option.add_result("?")->run_callback();
  } catch (const std::exception& error) {
    refusal = error.what();
  }
  option.clear();
  const std::string mark = " is not one of";
  const size_t start = refusal.find(mark);
  if (start == std::string::npos) return {};
  std::istringstream list(refusal.substr(start + mark.size()));
  const char separator = list.peek() == '\n' ? '\n' : ',';
  std::vector<std::string> words;
  for (std::string item; std::getline(list, item, separator);) {
    std::string word;
    if (!(std::istringstream(item) >> word)) continue;
    if (word == "and") break;
    words.push_back(word);
  }
  return words;
}

void write_manual(CLI::App& app, const fs::path& folder) {
  const auto write = [&](const std::string& name, const std::string& text) {
    fs::create_directories((folder / name).parent_path());
    write_file(folder / name, text);
  };
  write("man/man1/plumb.1", man_page(app, app));
  for (CLI::App* command : commands_of(app)) {
    write("man/man1/plumb-" + command->get_name() + ".1", man_page(app, *command));
  }
  write("bash-completion/completions/plumb", bash_completion(app));
  write("zsh/site-functions/_plumb", zsh_completion(app));
  write("fish/vendor_completions.d/plumb.fish", fish_completion(app));
}

}  // namespace

std::vector<OptionWords> options_of(CLI::App& command) {
  constexpr std::array file_values{"FILE", "FOLDER", "DIR", "MASK"};
  std::vector<OptionWords> all;
  for (CLI::Option* option : command.get_options([](CLI::Option*) { return true; })) {
    OptionWords words;
    for (const std::string& name : option->get_snames()) words.names.push_back("-" + name);
    for (const std::string& name : option->get_lnames()) words.names.push_back("--" + name);
    if (words.names.empty()) words.names.push_back(option->get_name());
    if (option->get_items_expected_max() > 0) words.value = option->get_type_name();
    words.text = option->get_description();
    std::ranges::replace(words.text, '\n', ' ');
    words.is_list = words.value.ends_with(",...");
    const std::string one = words.value.substr(0, words.value.find(','));
    const bool is_file = std::ranges::count(file_values, one) > 0;
    // Whoever is asked keeps the question, and names of scenes depend on the folder.
    if (!words.value.empty() && !is_file) words.words = words_of(*option);
    words.takes_files = words.is_positional() || is_file || one == "PROGRAM";
    words.is_repeated = option->get_items_expected_max() > 1;
    all.push_back(std::move(words));
  }
  return all;
}

std::vector<CLI::App*> commands_of(CLI::App& app) {
  return app.get_subcommands([](CLI::App* command) { return !command->get_group().empty(); });
}

void add_manual(CLI::App& app, int&) {
  CLI::App& command =
      *app.add_subcommand("manual", "Write the manual's pages and what shells complete")->group("");
  auto folder = std::make_shared<std::string>();
  add_option(command, "FOLDER", "", *folder, "Laid out as in /usr/share")->required();
  command.callback([folder, &app] { write_manual(app, *folder); });
}

}  // namespace plumb::cli
