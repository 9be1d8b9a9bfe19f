// Where the project's own scenes are.
#pragma once

#include <filesystem>

namespace plumb::cli {

// `reference_scenes` if the working directory has it, as a checkout does; else the folder that was
// installed with this executable, wherever both have been moved to.
std::filesystem::path scene_folder();

}  // namespace plumb::cli
