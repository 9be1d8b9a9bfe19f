// SPDX-License-Identifier: Apache-2.0

// One line on stderr that keeps the user informed of long work.
#pragma once

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <string>

namespace plumb::cli {

// On a terminal the line is rewritten in place; elsewhere a line appears every ten seconds.
class ProgressLine {
 public:
  ~ProgressLine() {
    if (is_terminal_) fmt::print(stderr, "\r\033[K");
  }

  void show(const std::string& text) {
    const auto now = std::chrono::steady_clock::now();
    if (is_terminal_) {
      fmt::print(stderr, "\r\033[K{}", text);
    } else if (now - last_shown_ >= std::chrono::seconds(10)) {
      fmt::print(stderr, "{}\n", text);
      last_shown_ = now;
    }
  }

 private:
  bool is_terminal_ = isatty(STDERR_FILENO) != 0;
  std::chrono::steady_clock::time_point last_shown_ = std::chrono::steady_clock::now();
};

}  // namespace plumb::cli
