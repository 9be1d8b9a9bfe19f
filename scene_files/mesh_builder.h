// SPDX-License-Identifier: Apache-2.0

// Puts the faces of a mesh together from vertices and normals as they stand in a file.
#pragma once

#include <Imath/ImathMatrix.h>

#include <cstddef>
#include <optional>
#include <vector>

#include "scene_files/mesh_reader.h"

namespace plumb {

// A face's corner: numbers of its vertex and of its normal, if it has one.
struct Corner {
  size_t vertex = 0;
  std::optional<size_t> normal = {};
};

class MeshBuilder {
 public:
  // The map is applied to all that is added.
  explicit MeshBuilder(const Imath::M44d& to_world);

  size_t vertex_count() const { return vertices_.size(); }
  size_t normal_count() const { return normals_.size(); }
  MeshFile& mesh() { return mesh_; }

  void add_vertex(const Vec3& v);
  void add_normal(const Vec3& n);
  void add_face(const std::vector<Corner>& corners);

 private:
  void keep(const Polygon& face, const std::vector<Corner>& corners);

  Imath::M44d to_world_, normals_to_world_;
  std::vector<Vec3> vertices_, normals_;
  std::vector<std::optional<Vec3>> normal_at_;  // of a face at each vertex
  MeshFile mesh_;
};

}  // namespace plumb
