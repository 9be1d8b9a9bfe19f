// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cctype>
#include <sstream>

#include "cli/manual.h"

namespace plumb::cli {
namespace {

// Roff takes these for something else: a hyphen, quotation marks, accents.
std::string escaped(const std::string& text) {
  std::string roff;
  for (const char c : text) {
    switch (c) {
      case '\\': roff += "\\e"; break;
      case '-': roff += "\\-"; break;
      case '\'': roff += "\\(aq"; break;
      case '`': roff += "\\(ga"; break;
      case '^': roff += "\\(ha"; break;
      case '~': roff += "\\(ti"; break;
      default: roff += c;
    }
  }
  return roff.starts_with('.') ? "\\&" + roff : roff;
}

std::string option_entry(const OptionWords& option) {
  std::string head;
  for (const std::string& name : option.names) {
    const char* face = option.is_positional() ? "I" : "B";
    head += fmt::format("{}\\f{}{}\\fR", head.empty() ? "" : ", ", face, escaped(name));
  }
  if (!option.value.empty()) head += fmt::format(" \\fI{}\\fR", escaped(option.value));
  return fmt::format(".TP\n{}{}\n{}\n", head, option.is_repeated ? " ..." : "",
                     escaped(option.text));
}

// What stands below the options in the help: examples, which are indented, sentences, exit codes.
std::string footer_sections(std::string footer) {
  const std::string exits = "Exit codes: ";
  if (const size_t start = footer.find(exits); start != std::string::npos) {
    footer.replace(start, exits.size(), "\n.SH EXIT STATUS\n");
  }
  std::string roff;
  bool is_example = false;
  std::istringstream lines(footer);
  for (std::string line; std::getline(lines, line);) {
    const bool is_title = line.starts_with(".SH");
    if (is_example && !line.starts_with(' ') && !line.empty()) {
      roff += is_title ? ".EE\n" : ".EE\n.SH NOTES\n";
      is_example = false;
    }
    if (line.starts_with("Example")) {
      roff += ".SH EXAMPLES\n.EX\n";
      is_example = true;
    } else if (!line.empty()) {
      roff += (is_title ? line : escaped(line)) + "\n";
    }
  }
  return roff;
}

std::string command_list(CLI::App& app) {
  std::string roff = ".SH COMMANDS\n";
  for (const CLI::App* command : commands_of(app)) {
    roff += fmt::format(".TP\n\\fBplumb\\-{}\\fR(1)\n{}\n", escaped(command->get_name()),
                        escaped(command->get_description()));
  }
  return roff;
}

std::string positional_names(const std::vector<OptionWords>& options) {
  std::string names;
  for (const OptionWords& option : options) {
    if (!option.is_positional()) continue;
    names += fmt::format(" \\fI{}\\fR{}", option.names[0], option.is_repeated ? " ..." : "");
  }
  return names;
}

}  // namespace

std::string man_page(CLI::App& app, CLI::App& command) {
  const bool is_whole = &command == &app;
  const std::string name = is_whole ? "plumb" : "plumb-" + command.get_name();
  std::string upper = name;
  for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  const std::vector<OptionWords> options = options_of(command);
  std::string roff = fmt::format(
      ".TH {} 1 \"\" \"Plumbline {}\" \"Plumbline\"\n.SH NAME\n{} \\- {}\n.SH SYNOPSIS\n"
      "\\fBplumb{}\\fR [\\fIoptions\\fR]{}\n.SH OPTIONS\n",
      upper, PLUMB_VERSION, escaped(name), escaped(command.get_description()),
      is_whole ? R"( \fIcommand\fR)" : " " + command.get_name(), positional_names(options));
  for (const OptionWords& option : options) roff += option_entry(option);
  if (is_whole) roff += command_list(app);
  roff += footer_sections(command.get_footer());
  return roff + (is_whole ? "" : ".SH SEE ALSO\n\\fBplumb\\fR(1)\n");
}

}  // namespace plumb::cli
