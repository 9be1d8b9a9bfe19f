// SPDX-License-Identifier: Apache-2.0

#include "images/output_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

namespace plumb {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& file, std::string_view what, int error = errno) {
  throw FileError(
      fmt::format("{}: {}: {}", file.string(), what, std::generic_category().message(error)));
}

// A hidden file beside the target, which takes the target's place when all is written and vanishes
// when it is not. What is thrown names the path that the caller gave.
class OutputFile {
 public:
  explicit OutputFile(const fs::path& file) : file_(file), target_(file) {
    std::error_code error;
    const fs::file_status status = fs::status(file, error);
    if (fs::is_directory(status)) fail(file, "cannot write", EISDIR);
    if (fs::exists(status) && ::access(file.c_str(), W_OK) != 0) fail(file, "cannot write");
    if (!fs::exists(status) && status.type() != fs::file_type::not_found) {
      fail(file, "cannot write", error.value());
    }
    is_written_in_place_ = fs::exists(status) && !fs::is_regular_file(status);
    while (fs::is_symlink(fs::symlink_status(target_, error))) {
      // /dev/stdout may have been redirected to a file, but stands for what is open.
      const fs::path folder = fs::canonical(target_.parent_path(), error);
      is_written_in_place_ |= folder.native().starts_with("/proc/");
      target_ = target_.parent_path() / fs::read_symlink(target_);
    }
    if (!is_written_in_place_) {
      create_temporary(target_.has_parent_path() ? target_.parent_path() : ".");
    }
  }

  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  ~OutputFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (!temporary_.empty()) ::unlink(temporary_.c_str());
  }

  void write(std::string_view bytes) {
    if (is_written_in_place_) {
      descriptor_ = ::open(file_.c_str(), O_WRONLY | O_TRUNC | O_CLOEXEC);
      if (descriptor_ < 0) fail(file_, "cannot write");
    }
    while (!bytes.empty()) {
      const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
      if (written < 0 && errno != EINTR) fail(file_, "cannot write");
      bytes.remove_prefix(static_cast<size_t>(std::max<ssize_t>(written, 0)));
    }
    if (!is_written_in_place_ && ::fsync(descriptor_) != 0) fail(file_, "cannot write");
    if (::close(std::exchange(descriptor_, -1)) != 0) fail(file_, "cannot write");
    if (is_written_in_place_) return;
    if (::rename(temporary_.c_str(), target_.c_str()) != 0) fail(file_, "cannot replace");
    temporary_.clear();
  }

 private:
  void create_temporary(const fs::path& folder) {
    for (int attempt = 0; descriptor_ < 0; ++attempt) {
      const fs::path path = folder / fmt::format(".plumb-{}-{}.tmp", ::getpid(), attempt);
      descriptor_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      if (descriptor_ < 0 && errno != EEXIST) {
        fail(file_, fmt::format("cannot create a file in {}", folder.string()));
      }
      if (descriptor_ >= 0) temporary_ = path;
    }
  }

  fs::path file_;
  fs::path target_;
  fs::path temporary_;
  bool is_written_in_place_ = false;
  int descriptor_ = -1;
};

}  // namespace

void check_writable(const fs::path& file) { const OutputFile output(file); }

void write_file(const fs::path& file, std::string_view bytes) { OutputFile(file).write(bytes); }

}  // namespace plumb
