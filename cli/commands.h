// The subcommands of `plumb`: each adds itself to the command line and, once that has been parsed
// and holds it, sets `run`.
#pragma once

#include <CLI/CLI.hpp>

#include <functional>

namespace plumb::cli {

// Does the work and returns the exit code: 0 done, 130 or 143 interrupted. Throws what went wrong.
using Run = std::function<int()>;

void add_render(CLI::App& app, Run& run);
void add_merge(CLI::App& app, Run& run);

}  // namespace plumb::cli
