#include "cli/scene_folder.h"

#include <system_error>

namespace plumb::cli {

namespace fs = std::filesystem;

fs::path scene_folder() {
  const fs::path here = "reference_scenes";
  std::error_code error;
  const fs::path executable = fs::read_symlink("/proc/self/exe", error);
  const fs::path installed = (executable.parent_path() / PLUMB_SCENES_FROM_BIN).lexically_normal();
  return fs::is_directory(here, error) || !fs::is_directory(installed, error) ? here : installed;
}

}  // namespace plumb::cli
