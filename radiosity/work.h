// SPDX-License-Identifier: Apache-2.0

// Long work in parts that don't depend on each other: shown as it goes on, and stopped when asked.
#pragma once

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <functional>
#include <string>

namespace plumb::radiosity {

// Thrown when a stop is asked for.
struct Stopped {};

struct Work {
  std::function<void(const std::string& phase)> show;  // called on the thread that waits
  const std::atomic<bool>* stop;

  bool is_stopped() const { return stop != nullptr && *stop; }
  void check() const {
    if (is_stopped()) throw Stopped();
  }

  // Calls `use` with the numbers below `count`, on any thread in any order.
  template <typename Use>
  void for_each(const std::string& phase, size_t count, Use use) const {
    const size_t step = std::max<size_t>(count / 64, 64);
    for (size_t begin = 0; begin < count; begin += step) {
      show(fmt::format("{}, {} %", phase, 100 * begin / count));
      tbb::parallel_for(begin, std::min(begin + step, count), [&](size_t i) {
        if (!is_stopped()) use(i);
      });
      check();
    }
  }
};

}  // namespace plumb::radiosity
