// One line on stderr that keeps the user informed of long work.
#pragma once

#include <string>

namespace plumb::cli {

// On a terminal the line is rewritten in place; elsewhere a line appears every ten seconds.
class ProgressLine {
 public:
  ProgressLine();
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void show(const std::string& text);

 private:
  bool is_terminal_;
  bool is_shown_ = false;
  double last_shown_;
};

// "42 s", "3 min 05 s", "2 h 10 min".
std::string duration(double seconds);

}  // namespace plumb::cli
