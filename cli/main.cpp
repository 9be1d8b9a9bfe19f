// SPDX-License-Identifier: Apache-2.0

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <exception>
#include <new>
#include <stdexcept>
#include <system_error>

#include "cli/bug_report.h"
#include "cli/commands.h"
#include "images/printable.h"

namespace {

namespace cli = plumb::cli;

constexpr int trouble = 2;

int run(int argc, char** argv) {
  CLI::App app{"Plumbline, a reference renderer that measures its own noise", "plumb"};
  app.get_formatter()->column_width(22);
  bool is_verbose = false;
  CLI::Option& verbose =
      *app.add_flag("--verbose", is_verbose, "With --version: all that a bug report needs");
  verbose.needs(app.set_version_flag(
      "--version", [&] { return is_verbose ? cli::bug_report() : "plumb " PLUMB_VERSION; },
      "Show the version and exit"));
  app.footer(R"(Example:
  plumb render reference_scenes/cornell/scene.xml -o cornell.exr

'plumb COMMAND --help' tells more.)");
  int exit_code = 0;
  for (cli::AddCommand* add :
       {cli::add_render, cli::add_merge, cli::add_compare, cli::add_converge, cli::add_chart,
        cli::add_power, cli::add_radiosity, cli::add_export, cli::add_reference, cli::add_stress,
        cli::add_certify, cli::add_diagnose, cli::add_faults, cli::add_manual}) {
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
    const int exit_code = run(argc, argv);
    if (std::fflush(stdout) == 0) return exit_code;
    throw std::system_error(errno, std::generic_category(), "standard output");
  } catch (const std::bad_alloc&) {
    std::fputs("plumb: not enough memory\n", stderr);
  } catch (const std::exception& error) {
    const std::string told = plumb::printable(error.what(), plumb::LineEnds::kept);
    std::fprintf(stderr, "plumb: %s\n", told.c_str());
  }
  return trouble;
}
