// Writes scenes as other programs read them. What holds for all scenes (how that program expresses
// light and cameras, and its settings) is in an include, which is put beside the scene file.
#pragma once

#include <filesystem>
#include <string>

#include "renderer/scene.h"

namespace plumb {

// For POV-Ray 3.7, and for Blender 3.4 and later as a Python script. Both return the path of the
// include and throw std::runtime_error if a file can't be written.
std::filesystem::path export_to_povray(const Scene& scene, const std::filesystem::path& file);
std::filesystem::path export_to_cycles(const Scene& scene, const std::filesystem::path& file);

// The text of the exported file.
std::string povray_scene(const Scene& scene);
std::string cycles_scene(const Scene& scene);

// `id` with everything but ASCII letters, digits and underscores replaced by underscores: harmless
// in any comment, string or name.
std::string plain_identifier(const std::string& id);

}  // namespace plumb
