// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <exception>
#include <new>
#include <stdexcept>

#include "cli/commands.h"

namespace {

namespace cli = plumb::cli;

constexpr int trouble = 2;

int run(int argc, char** argv) {
  CLI::App app{"Plumbline, a reference renderer that measures its own noise", "plumb"};
  app.get_formatter()->column_width(22);
  app.set_version_flag("--version", "plumb " PLUMB_VERSION, "Show the version and exit");
  app.footer(R"(Example:
  plumb render reference_scenes/cornell/scene.xml -o cornell.exr

'plumb COMMAND --help' tells more.)");
  int exit_code = 0;
  for (cli::AddCommand* add :
       {cli::add_render, cli::add_merge, cli::add_compare, cli::add_converge, cli::add_chart,
        cli::add_power, cli::add_export, cli::add_reference, cli::add_stress}) {
    add(app, exit_code);
  }
  app.require_subcommand(0, 1);  // what is missing is told below: CLI11 hides misspelt names
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& request) {
    return app.exit(request);
  }
  if (app.get_subcommands().empty()) {
    throw std::invalid_argument("no command given, see 'plumb --help'");
  }
  return exit_code;
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
