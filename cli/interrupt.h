// SPDX-License-Identifier: Apache-2.0

// Ctrl-C that loses nothing.
#pragma once

#include <atomic>
#include <csignal>

namespace plumb::cli {

inline std::atomic<bool> stop_requested{false};
inline std::atomic<int> stop_signal{0};

// The first signal asks for a stop, after which what is finished is saved; a second one kills as
// usual.
extern "C" inline void request_stop(int signal) {
  stop_requested = true;
  stop_signal = signal;
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

inline void listen_for_interrupts() {
  std::signal(SIGINT, request_stop);
  std::signal(SIGTERM, request_stop);
}

}  // namespace plumb::cli
