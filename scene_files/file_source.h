// SPDX-License-Identifier: Apache-2.0

// Where the files of a scene are read from: a disk, or what a program holds in memory.
#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace plumb {

class FileSource {
 public:
  virtual ~FileSource() = default;

  virtual bool exists(const std::filesystem::path& path) const = 0;  // a file or a folder
  virtual bool is_file(const std::filesystem::path& path) const = 0;

  // The bytes of a file; none if it can't be read.
  virtual std::string read(const std::filesystem::path& file) = 0;
};

// Files in no folder: of what a scene names, only the last part of the path counts.
class FilesInMemory : public FileSource {
 public:
  explicit FilesInMemory(std::map<std::string, std::string> files) : files_(std::move(files)) {}

  bool exists(const std::filesystem::path& path) const override { return is_file(path); }
  bool is_file(const std::filesystem::path& path) const override {
    return files_.contains(path.filename().string());
  }
  std::string read(const std::filesystem::path& file) override {
    const auto found = files_.find(file.filename().string());
    return found == files_.end() ? "" : found->second;
  }

 private:
  std::map<std::string, std::string> files_;
};

}  // namespace plumb
