#include "reference_scenes/child_process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <iterator>
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
  pid_t process = 0;
  const int error =
      posix_spawnp(&process, arguments[0], &files, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  if (error != 0) throw std::system_error(error, std::generic_category(), command[0]);
  return process;
}

}  // namespace

std::string last_line(const std::filesystem::path& file) {
  constexpr std::streamoff enough = 400;
  std::ifstream stream(file, std::ios::ate);
  stream.seekg(-std::min<std::streamoff>(enough, stream.tellg()), std::ios::end);
  const std::string text(std::istreambuf_iterator<char>(stream), {});
  const size_t end = text.find_last_not_of("\r\n ") + 1;
  const size_t begin = text.find_last_of("\r\n", end == 0 ? 0 : end - 1) + 1;
  return text.substr(begin, end - begin);
}

int run_program(const std::vector<std::string>& command, const std::filesystem::path& folder,
                const std::filesystem::path& log,
                const std::function<void(const std::string&)>& show,
                const std::atomic<bool>& stop) {
  const pid_t process = start(command, folder, log);
  bool is_told = false;
  int status = 0;
  while (waitpid(process, &status, WNOHANG) == 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    show(last_line(log));
    if (stop && !std::exchange(is_told, true)) kill(process, SIGTERM);
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace plumb
