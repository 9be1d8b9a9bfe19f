// SPDX-License-Identifier: Apache-2.0

// Writes scenes as other renderers read them, and what the descriptions of these renderers share.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "other_renderers/other_renderer.h"
#include "scene/surfaces.h"

namespace plumb {

// Writes the scene in the renderer's format, which it must have, and beside it the renderer's
// script, which holds what is true of all scenes. Returns the script's path; throws
// FileError if a file cannot be written.
std::filesystem::path export_scene(const OtherRenderer& renderer, const Scene& scene,
                                   const std::filesystem::path& file);

// That `renderer` draws a box one pixel wide; empty if that is the scene's filter.
std::string box_filter_note(const std::string& renderer, const Filter& filter);

inline bool is_glass(const Shape& shape) { return shape.bsdf.kind == Bsdf::Kind::dielectric; }

// Which refractive index is where, in that of what surrounds all glass. Throws
// std::invalid_argument if there's glass that encloses nothing, or a shape that is partly in glass.
class Media {
 public:
  explicit Media(const std::vector<Shape>& shapes);

  double index_at(const Vec3& point) const;
  double index_before(const Shape& shape) const;

 private:
  double index_along(const Ray& ray) const;

  Scene holder_;  // of the shapes of glass
  std::vector<Surface> surfaces_;
  std::vector<Vec3> targets_;  // one on each shape: rays go there, and the opposite way
};

// The scene for programs that leave radiance as it is where light goes through glass: in it lamps
// have the radiance that the camera's surroundings make of it.
Scene without_radiance_steps(Scene scene);

// A line of its own, none for an empty note.
std::string comment(const std::string& mark, const std::string& note);

// `id` with everything but ASCII letters, digits and underscores replaced by underscores: harmless
// in any comment, string or name.
std::string plain_identifier(const std::string& id);

// The options that all Python scripts of this folder take: `command` with what the job says; `more`
// are options of this script alone.
std::vector<Run> script_call(Command command, const Job& job, const Command& more = {});

}  // namespace plumb
