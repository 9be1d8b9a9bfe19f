// SPDX-License-Identifier: Apache-2.0

// What the parts of the module `_core` have in common. It holds no logic: the package's Python
// turns arguments into the command line's words, and the libraries behind `plumb` do the work.
#pragma once

#include <nanobind/nanobind.h>

#include <atomic>
#include <chrono>
#include <exception>
#include <future>
#include <mutex>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace plumb::python {

namespace nb = nanobind;

using Words = std::vector<std::string>;

void bind_pictures(nb::module_& module);
void bind_judging(nb::module_& module);
void bind_scenes(nb::module_& module);
void bind_studies(nb::module_& module);

// Long work as its caller sees it.
class Watch {
 public:
  std::atomic<bool> stop{false};

  void show(const std::string& text) {
    const std::lock_guard lock(mutex_);
    text_ = text;
  }

  // What has been shown since the last time; nothing if nothing has.
  std::string news() {
    const std::lock_guard lock(mutex_);
    return std::exchange(text_, {});
  }

 private:
  std::mutex mutex_;
  std::string text_;
};

// Throws what Ctrl-C or `progress`, which gets the news, has raised.
inline void look(const nb::object& progress, Watch& watch) {
  if (PyErr_CheckSignals() != 0) throw nb::python_error();
  const std::string news = watch.news();
  if (!news.empty() && !progress.is_none()) progress(news);
}

// Does the work on a thread of its own, without the interpreter's lock, so that Python's other
// threads run and Ctrl-C is heard twenty times a second: then the work is asked to stop.
template <typename Work>
auto watched(const nb::object& progress, Work work) {
  Watch watch;
  auto result = std::async(std::launch::async, [&] { return work(watch); });
  std::exception_ptr raised;
  nb::gil_scoped_release released;
  while (result.wait_for(std::chrono::milliseconds(50)) != std::future_status::ready) {
    if (raised) continue;
    const nb::gil_scoped_acquire held;
    try {
      look(progress, watch);
    } catch (...) {
      raised = std::current_exception();
      watch.stop = true;
    }
  }
  if (raised) std::rethrow_exception(raised);
  return result.get();
}

}  // namespace plumb::python
