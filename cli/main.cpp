#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <exception>
#include <new>
#include <stdexcept>
#include <string>

#include "cli/commands.h"

namespace {

constexpr int trouble = 2;

std::string help_line(const std::string& left, const std::string& right) {
  constexpr size_t indent = 22;
  return fmt::format("  {:<{}}{}\n", left, indent - 2,
                     CLI::detail::find_and_replace(right, "\n", "\n" + std::string(indent, ' ')));
}

std::string with_value(const std::string& name, const CLI::Option& option) {
  return CLI::detail::trim_copy(name + " " + option.get_option_text());
}

// Laid out here because every version of CLI11 does it in another way.
std::string help(const CLI::App* app, const std::string& name, CLI::AppFormatMode) {
  std::string usage = name;
  std::string lists;
  for (const CLI::App* command : app->get_subcommands({})) {
    if (lists.empty()) lists = "\nCommands:\n";
    lists += help_line(command->get_name(), command->get_description());
  }
  usage += lists.empty() ? "" : " COMMAND";
  for (const std::string& group : app->get_groups()) {
    lists += fmt::format("\n{}:\n", group);
    for (const CLI::Option* option : app->get_options()) {
      if (option->get_group() != group) continue;
      const std::string names =
          CLI::detail::find_and_replace(option->get_name(false, true), ",", ", ");
      lists += help_line(with_value(names, *option), option->get_description());
      if (option->get_required()) usage += " " + with_value(option->get_name(), *option);
    }
  }
  return fmt::format("{}.\n\nUsage: {} [OPTION...]\n{}\n{}\n", app->get_description(), usage, lists,
                     app->get_footer());
}

int run(int argc, char** argv) {
  CLI::App app{"Plumbline, a reference renderer that measures its own noise", "plumb"};
  app.formatter_fn(help);
  plumb::cli::Run run_command;
  plumb::cli::add_render(app, run_command);
  plumb::cli::add_merge(app, run_command);
  app.require_subcommand(0, 1);  // what is missing is told below: CLI11 hides misspelt names
  app.set_version_flag("--version", "plumb " PLUMB_VERSION, "Show the version");
  for (CLI::App* any : {&app, app.get_subcommand("render"), app.get_subcommand("merge")}) {
    any->set_help_flag("-h,--help", "Show this help");
  }
  app.footer(R"(Example:
  plumb render reference_scenes/cornell/scene.xml -o cornell.exr

'plumb COMMAND --help' tells more.)");
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& request) {
    return app.exit(request);
  }
  if (!run_command) throw std::invalid_argument("no command given, see 'plumb --help'");
  return run_command();
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "plumb: not enough memory\n");
  } catch (const std::exception& error) {
    fmt::print(stderr, "plumb: {}\n", error.what());
  }
  return trouble;
}
