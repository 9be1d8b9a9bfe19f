// SPDX-License-Identifier: Apache-2.0

#include <OpenImageIO/hash.h>
#include <OpenImageIO/strutil.h>

#include <fstream>
#include <sstream>
#include <system_error>

#include "scene_files/file_source.h"
#include "scene_files/scene_reader.h"

namespace plumb {
namespace {

namespace fs = std::filesystem;

class DiskFiles : public FileSource {
 public:
  explicit DiskFiles(const fs::path& scene) : scene_(scene) {}

  bool exists(const fs::path& path) const override {
    std::error_code too_long;
    return fs::exists(path, too_long);
  }
  bool is_file(const fs::path& path) const override {
    std::error_code too_long;
    return fs::is_regular_file(path, too_long);
  }
  std::string read(const fs::path& file) override {
    // Devices have no end. The scene itself may come through a pipe.
    if (file != scene_ && !is_file(file)) return "";
    std::ostringstream bytes;
    bytes << std::ifstream(file, std::ios::binary).rdbuf();
    sha1_.append(bytes.view().data(), bytes.view().size());
    return bytes.str();
  }

  // Of all that was read, lower-case SHA-1; to be asked once, at the end.
  std::string hash() { return OIIO::Strutil::lower(sha1_.digest()); }

 private:
  fs::path scene_;
  OIIO::SHA1 sha1_;
};

std::string scene_name(const std::filesystem::path& file) {
  const auto folder = std::filesystem::absolute(file).lexically_normal().parent_path();
  const bool is_named_by_folder = file.filename() == "scene.xml" && folder.has_filename();
  return (is_named_by_folder ? folder.filename() : file.stem()).string();
}

}  // namespace

Scene read_scene(const fs::path& path) {
  DiskFiles files(path);
  Scene scene = read_scene(path, files);
  scene.name = scene_name(path);
  scene.hash = files.hash();
  return scene;
}

}  // namespace plumb
