// SPDX-License-Identifier: Apache-2.0

#include <OpenImageIO/hash.h>
#include <OpenImageIO/strutil.h>

#include <fstream>
#include <sstream>

#include "scene_files/file_source.h"
#include "scene_files/scene_reader.h"

namespace plumb {
namespace {

namespace fs = std::filesystem;

class DiskFiles : public FileSource {
 public:
  bool exists(const fs::path& path) const override { return fs::exists(path); }
  bool is_file(const fs::path& path) const override { return fs::is_regular_file(path); }
  std::string read(const fs::path& file) override {
    std::ostringstream bytes;
    bytes << std::ifstream(file, std::ios::binary).rdbuf();
    sha1_.append(bytes.view().data(), bytes.view().size());
    return bytes.str();
  }

  // Of all that was read, lower-case SHA-1; to be asked once, at the end.
  std::string hash() { return OIIO::Strutil::lower(sha1_.digest()); }

 private:
  OIIO::SHA1 sha1_;
};

std::string scene_name(const std::filesystem::path& file) {
  const auto folder = std::filesystem::absolute(file).lexically_normal().parent_path();
  const bool is_named_by_folder = file.filename() == "scene.xml" && folder.has_filename();
  return (is_named_by_folder ? folder.filename() : file.stem()).string();
}

}  // namespace

Scene read_scene(const fs::path& path) {
  DiskFiles files;
  Scene scene = read_scene(path, files);
  scene.name = scene_name(path);
  scene.hash = files.hash();
  return scene;
}

}  // namespace plumb
