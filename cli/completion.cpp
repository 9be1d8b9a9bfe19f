// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/manual.h"

namespace plumb::cli {
namespace {

// For shells within '...'. In zsh's lists of options, brackets and colons mean something.
std::string quoted(const std::string& text, const std::string& special = "") {
  std::string safe;
  for (const char c : text) {
    if (special.find(c) != std::string::npos) safe += '\\';
    safe += c == '\'' ? "'\\''" : std::string(1, c);
  }
  return safe;
}

std::string command_names(CLI::App& app) {
  std::string names;
  for (const CLI::App* command : commands_of(app)) names += " " + command->get_name();
  return names.substr(1);
}

std::string option_names(CLI::App& command) {
  std::string names;
  for (const OptionWords& option : options_of(command)) {
    if (!option.is_positional()) names += fmt::format(" {}", fmt::join(option.names, " "));
  }
  return names.substr(1);
}

// Cases of the value of an option.
std::string bash_values(CLI::App& command) {
  std::string cases;
  for (const OptionWords& option : options_of(command)) {
    if (option.is_positional() || option.value.empty()) continue;
    std::string pattern;
    for (const std::string& name : option.names) {
      pattern += fmt::format("{}'{} {}'", pattern.empty() ? "" : "|", command.get_name(), name);
    }
    cases += fmt::format("    {}) words='{}' files={} ;;\n", pattern, fmt::join(option.words, " "),
                         option.takes_files ? "yes" : "");
  }
  return cases;
}

// What completes the value of an option in zsh.
std::string zsh_value(const OptionWords& option) {
  if (option.words.empty()) return option.takes_files ? "_files" : "";
  const std::string words = quoted(fmt::format("{}", fmt::join(option.words, " ")), ":");
  if (option.is_list && !option.takes_files) return "_sequence compadd - " + words;
  return option.takes_files ? "{compadd - " + words + "; _files}" : "(" + words + ")";
}

std::string zsh_option(const OptionWords& option) {
  std::string value = zsh_value(option);
  if (!option.value.empty()) value = ":" + quoted(option.value, ":") + ":" + value;
  std::string all;
  for (const std::string& name : option.names) {
    all += fmt::format("{}      '*{}[{}]{}'", all.empty() ? "" : " \\\n", name,
                       quoted(option.text, "[]:\\"), value);
  }
  return all;
}

std::string fish_options(CLI::App& command, const std::string& condition) {
  std::string lines;
  for (const OptionWords& option : options_of(command)) {
    if (option.is_positional()) continue;
    std::string line = fmt::format("complete -c plumb -n '{}'", condition);
    for (const std::string& name : option.names) {
      const bool is_long = name.starts_with("--");
      line += fmt::format(" {} {}", is_long ? "-l" : "-s", name.substr(is_long ? 2 : 1));
    }
    if (!option.value.empty()) line += option.takes_files ? " -r -F" : " -x";
    const std::string words = fmt::format("{}", fmt::join(option.words, " "));
    if (!words.empty()) {
      line += " -a '" + (option.is_list ? "(__fish_append , " + words + ")" : words) + "'";
    }
    lines += fmt::format("{} -d '{}'\n", line, quoted(option.text, "\\"));
  }
  return lines;
}

}  // namespace

std::string bash_completion(CLI::App& app) {
  std::string values, options;
  for (CLI::App* command : commands_of(app)) {
    values += bash_values(*command);
    options += fmt::format("    {}) words='{}' ;;\n", command->get_name(), option_names(*command));
  }
  return fmt::format(R"(# Completes the words of plumb(1) in bash.
_plumb() {{
  local command=${{COMP_WORDS[1]}} current=${{COMP_WORDS[COMP_CWORD]}} words='' files=''
  local before=${{COMP_WORDS[COMP_CWORD-1]}} list=''
  if [ "$current" = = ]; then
    current=''
  elif [ "$before" = = ]; then
    before=${{COMP_WORDS[COMP_CWORD-2]}}
  fi
  [ "$COMP_CWORD" = 1 ] && command=''
  case "$command $before" in
{}    *)
      files=yes
      case "$command" in
{}    '') words='{} {}' files='' ;;
      esac
      case "$current" in -*) files='' ;; *) [ -n "$command" ] && words='' ;; esac ;;
  esac
  case "$current" in *,*) list=${{current%,*}}, ;; esac
  COMPREPLY=($(compgen -P "$list" -W "$words" -- "${{current#"$list"}}"))
  if [ -n "$files" ]; then
    compopt -o filenames
    mapfile -t -O "${{#COMPREPLY[@]}}" COMPREPLY < <(compgen -f -- "$current")
  fi
}}
complete -F _plumb plumb
)",
                     values, options, command_names(app), option_names(app));
}

std::string zsh_completion(CLI::App& app) {
  std::string names, cases;
  for (CLI::App* command : commands_of(app)) {
    names += fmt::format("    '{}:{}'\n", command->get_name(),
                         quoted(command->get_description(), ":\\"));
    std::string options;
    for (const OptionWords& option : options_of(*command)) {
      if (!option.is_positional()) options += " \\\n" + zsh_option(option);
    }
    cases += fmt::format("    {}) _arguments{} '*:file:_files' ;;\n", command->get_name(), options);
  }
  std::string own;
  for (const OptionWords& option : options_of(app)) own += zsh_option(option) + " \\\n";
  return fmt::format(R"(#compdef plumb
# Completes the words of plumb(1) in zsh.
local -a commands=(
{})
_arguments -C \
{}      '1:command:->command' '*::argument:->argument'
case $state in
  command) _describe command commands ;;
  argument) case $words[1] in
{}    esac ;;
esac
)",
                     names, own, cases);
}

std::string fish_completion(CLI::App& app) {
  std::string lines =
      "# Completes the words of plumb(1) in fish.\n" + fish_options(app, "__fish_use_subcommand");
  for (CLI::App* command : commands_of(app)) {
    lines += fmt::format("complete -c plumb -n __fish_use_subcommand -f -a {} -d '{}'\n",
                         command->get_name(), quoted(command->get_description(), "\\"));
  }
  for (CLI::App* command : commands_of(app)) {
    lines += fish_options(*command, "__fish_seen_subcommand_from " + command->get_name());
  }
  return lines;
}

}  // namespace plumb::cli
