// SPDX-License-Identifier: Apache-2.0

// Writes whole files: what is read under a name is the old file or the new one, never a half.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string_view>

namespace plumb {

// What went wrong with a file, which the message names first.
class FileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Throws FileError if `file` could not be written now, before any work is put into it.
void check_writable(const std::filesystem::path& file);

// Writes beside the file and renames, so that a full disk or a kill leaves what was there before;
// through symbolic links. Devices, pipes and what this process has open (/dev/stdout) are written
// to as they are. Throws FileError.
void write_file(const std::filesystem::path& file, std::string_view bytes);

}  // namespace plumb
