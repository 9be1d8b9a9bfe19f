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

// What of the scene's pixel filter that program draws otherwise; empty if nothing.
std::string povray_filter_note(const Camera& camera);
std::string cycles_filter_note(const Camera& camera);

// Cycles' gaussian is exp(-8 (x / width)^2), out to one and a half widths: ours, but for 0.03 %
// where ours ends. 0: it has no such filter.
double cycles_filter_width(const Filter& filter);

// A line of its own, none for an empty note.
std::string comment(const std::string& mark, const std::string& note);

// `id` with everything but ASCII letters, digits and underscores replaced by underscores: harmless
// in any comment, string or name.
std::string plain_identifier(const std::string& id);

}  // namespace plumb
