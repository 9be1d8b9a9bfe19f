// SPDX-License-Identifier: Apache-2.0

// Reads files of faces: Wavefront OBJ and Stanford PLY.
#pragma once

#include <Imath/ImathMatrix.h>

#include "scene/scene.h"

namespace plumb {

struct MeshFile {
  Mesh faces;  // transformed; without those that have no area
  int without_area = 0;
  int folded = 0;  // concave or self-crossing faces: their triangles turn against each other
  bool has_normals = false;      // of its own, at corners of its faces
  bool lacks_normals = false;    // at some of them
  bool normals_are_flat = true;  // they are the faces' own
  bool shares_corners = false;   // faces that don't lie in one plane have corners in common
};

// The faces in `text`, which `file` holds. A quad that is flat and convex is one polygon; any other
// face is the triangles 1-2-3, 1-3-4 and so on. Texture coordinates, groups and materials have no
// effect. Throws SceneError: "box.obj:7: f 1 2 9: ...". Both are our own, because the usual
// libraries read `nan` and `1abc`, leave out unknown statements, store floats, and crash where a
// file is damaged.
MeshFile read_obj(const std::string& file, const std::string& text, const Imath::M44d& to_world);
MeshFile read_ply(const std::string& file, const std::string& text, const Imath::M44d& to_world);

}  // namespace plumb
