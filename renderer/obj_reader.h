// Reads Wavefront OBJ text as flat faces.
#pragma once

#include <Imath/ImathMatrix.h>

#include "renderer/scene.h"

namespace plumb {

// The transformed faces in `text`, which `file` holds. A quad that is flat and convex is one
// polygon, any other one the triangles 1-2-3 and 1-3-4. Normals, texture coordinates, groups and
// materials have no effect. Throws SceneError: "box.obj:7: f 1 2 9: ...". Our own, because the
// usual library reads `nan` and `1abc`, leaves out unknown statements and stores floats.
Mesh read_obj(const std::string& file, const std::string& text, const Imath::M44d& to_world);

}  // namespace plumb
