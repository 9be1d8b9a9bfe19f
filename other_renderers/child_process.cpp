// SPDX-License-Identifier: Apache-2.0

#include "other_renderers/child_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>
#include <regex>
#include <system_error>
#include <thread>
#include <utility>

namespace plumb {
namespace {

pid_t start(const std::vector<std::string>& command, const std::filesystem::path& folder,
            const std::filesystem::path& log) {
  std::vector<char*> arguments;
  arguments.reserve(command.size() + 1);
  for (const std::string& argument : command) {
    arguments.push_back(const_cast<char*>(argument.c_str()));  // posix_spawnp() doesn't write
  }
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC,
                                   0666);
  posix_spawn_file_actions_addchdir_np(&files, folder.c_str());
  posix_spawn_file_actions_adddup2(&files, STDOUT_FILENO, STDERR_FILENO);
  posix_spawnattr_t attributes;  // a process group of its own, which can be ended as a whole
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  pid_t process = 0;
  const int error =
      posix_spawnp(&process, arguments[0], &files, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  if (error != 0) throw std::system_error(error, std::generic_category(), command[0]);
  return process;
}

// POV-Ray's headings stand between rules, and tables of its options have dots: both contain such
// words too.
bool separator(const std::string& line) {
  return std::ranges::count_if(line, [](unsigned char c) { return std::isalpha(c); }) < 2 ||
         line.starts_with("----") || line.starts_with("====") ||
         line.find("......") != std::string::npos;
}

// Of a text that may be long. A carriage return ends a line too: that is how programs show
// progress.
std::string last_line(const std::filesystem::path& file) {
  constexpr std::streamoff enough = 400;
  std::ifstream stream(file, std::ios::ate);
  stream.seekg(-std::min<std::streamoff>(enough, stream.tellg()), std::ios::end);
  const std::string text(std::istreambuf_iterator<char>(stream), {});
  const size_t end = text.find_last_not_of("\r\n ") + 1;
  const size_t begin = text.find_last_of("\r\n", end == 0 ? 0 : end - 1) + 1;
  return text.substr(begin, end - begin);
}

// Longer ones are no messages, and too much for std::regex.
constexpr size_t longest_line = 2000;

}  // namespace

std::string telling_line(const std::filesystem::path& log) {
  // The best first. POV-Ray says what is wrong in "Parse Error: ...", and after it only that it
  // was fatal; Python's last line names its exception.
  static const std::array<std::regex, 3> telling{
      std::regex("Error|Exception|error: |terminate called|out of memory"),
      std::regex("error|exception|fatal|failed|memory|abort", std::regex::icase),
      std::regex("[A-Za-z]{2}")};
  std::array<std::string, telling.size()> last;
  std::ifstream stream(log, std::ios::binary);
  std::string line;
  while (std::getline(stream, line)) {
    // Of progress, which carriage returns overwrite, what was to be seen in the end.
    line.erase(line.find_last_not_of("\r\n ") + 1);
    line.erase(0, line.find_last_of('\r') + 1);
    if (line.size() > longest_line || separator(line) || line.starts_with("plumbline:")) continue;
    for (size_t i = 0; i < telling.size(); ++i) {
      if (std::regex_search(line, telling[i])) last[i] = line;
    }
  }
  const auto found = std::ranges::find_if_not(last, &std::string::empty);
  return found == last.end() ? "said nothing" : found->substr(found->find_first_not_of(' '));
}

std::string name_of_end(int status) {
  if (status == out_of_time) return "took longer than its time limit";
  if (status <= 128) return fmt::format("exit status {}", status);
  const char* name = sigabbrev_np(status - 128);
  if (name == nullptr) return fmt::format("exit status {}", status);
  return fmt::format("SIG{}: {}", name, sigdescr_np(status - 128));
}

int run_program(const std::vector<std::string>& command, const std::filesystem::path& folder,
                const std::filesystem::path& log,
                const std::function<void(const std::string&)>& show, const std::atomic<bool>& stop,
                double seconds) {
  using Clock = std::chrono::steady_clock;
  constexpr auto grace = std::chrono::milliseconds(500);
  const auto begin = Clock::now();
  const pid_t process = start(command, folder, log);
  std::optional<Clock::time_point> told;  // to end
  bool is_late = false;
  int status = 0;
  while (waitpid(process, &status, WNOHANG) == 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    show(last_line(log));
    const auto now = Clock::now();
    is_late |= std::chrono::duration<double>(now - begin).count() > seconds;
    if (!stop && !is_late) continue;
    if (!told) kill(-process, SIGTERM);
    if (!told) told = now;
    if (now - *told > grace) kill(-process, SIGKILL);
  }
  if (is_late) return out_of_time;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace plumb
