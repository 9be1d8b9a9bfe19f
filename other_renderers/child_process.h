// SPDX-License-Identifier: Apache-2.0

// Runs another program to its end.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace plumb {

// Runs `command`, looked up in PATH, in `folder` and without input; its output goes to the file
// `log`, whose last line is shown now and then. Passes a stop on to the program and what that has
// started, and ends them after `seconds`; who does not heed that is killed half a second later.
// Returns the exit status, 128 + signal, or `out_of_time`; throws std::system_error if the program
// can't be started, as when it isn't there.
int run_program(const std::vector<std::string>& command, const std::filesystem::path& folder,
                const std::filesystem::path& log,
                const std::function<void(const std::string&)>& show, const std::atomic<bool>& stop,
                double seconds = std::numeric_limits<double>::infinity());
constexpr int out_of_time = -1;

// What in its log tells most of why a program failed: the last line that names an error, else the
// last one with a word in it.
std::string telling_line(const std::filesystem::path& log);

// Of what run_program() returned: "exit status 7", the signal's name, or that it took too long.
std::string name_of_end(int status);

}  // namespace plumb
