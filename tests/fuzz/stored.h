// SPDX-License-Identifier: Apache-2.0

// Readers take files by their names. TMPDIR=/dev/shm keeps these in memory.
#pragma once

#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

namespace plumb {

// A folder that goes with the process, and the file in it that holds the bytes.
inline std::filesystem::path store(const std::string& name, const uint8_t* data, size_t size) {
  namespace fs = std::filesystem;
  static const struct Folder {
    fs::path path = fs::temp_directory_path() / ("plumb-fuzz-" + std::to_string(getpid()));
    Folder() { fs::create_directories(path); }
    ~Folder() { fs::remove_all(path); }
  } folder;
  std::ofstream(folder.path / name, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  return folder.path / name;
}

}  // namespace plumb
