// SPDX-License-Identifier: Apache-2.0

// Runs another program to its end.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace plumb {

// Runs `command`, looked up in PATH, in `folder` and without input; its output goes to the file
// `log`, whose last line is shown now and then. Passes a stop on to the program. Returns the exit
// status, or 128 + signal; throws std::system_error if the program can't be started, as when it
// isn't there.
int run_program(const std::vector<std::string>& command, const std::filesystem::path& folder,
                const std::filesystem::path& log,
                const std::function<void(const std::string&)>& show, const std::atomic<bool>& stop);

// What in its log tells most of why a program failed: the last line that names an error, else the
// last one with a word in it.
std::string telling_line(const std::filesystem::path& log);

// Of what run_program() returned: "exit status 7", or the signal's name.
std::string name_of_end(int status);

}  // namespace plumb
