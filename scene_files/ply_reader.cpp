// SPDX-License-Identifier: Apache-2.0

#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <sstream>
#include <utility>

#include "scene_files/mesh_builder.h"
#include "scene_files/scene_reader.h"

namespace plumb {
namespace {

// How many of an element a PLY file's header announces.
size_t announced(const std::string& text, const std::string& element) {
  std::istringstream header(text.substr(0, text.find("end_header")));
  size_t count = 0;
  for (std::string word; header >> word;) {
    if (word == "element" && header >> word && word == element) header >> count;
  }
  return count;
}

}  // namespace

MeshFile read_ply(const std::string& file, const std::string& text, const Imath::M44d& to_world) {
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFileFromMemory(text.data(), text.size(), 0, "ply");
  if (scene == nullptr) throw SceneError(file + ": " + importer.GetErrorString());
  MeshBuilder builder(to_world);
  size_t faces = 0;
  const auto to_vector = [](const aiVector3D& v) { return Vec3(v.x, v.y, v.z); };
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& mesh = *scene->mMeshes[m];
    const size_t first = builder.vertex_count();
    faces += mesh.mNumFaces;
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      builder.add_vertex(to_vector(mesh.mVertices[i]));
      builder.add_normal(mesh.HasNormals() ? to_vector(mesh.mNormals[i]) : Vec3(0.0));
    }
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
      const aiFace& face = mesh.mFaces[i];
      if (face.mNumIndices < 3) {
        throw SceneError(fmt::format("{}: face {} has less than three corners", file, i));
      }
      std::vector<Corner> corners;
      for (unsigned k = 0; k < face.mNumIndices; ++k) {
        const unsigned index = face.mIndices[k];
        if (index >= mesh.mNumVertices) {
          throw SceneError(fmt::format("{}: face {}: {} is not one of {} vertices", file, i,
                                       static_cast<int>(index), mesh.mNumVertices));
        }
        corners.push_back({first + index});
        if (mesh.HasNormals()) corners.back().normal = first + index;
      }
      builder.add_face(corners);
    }
  }
  // Assimp takes the last line of an ASCII file again where lines are missing.
  const size_t wanted = announced(text, "vertex") + announced(text, "face");
  const size_t header_end = std::min(text.find("end_header"), text.size());
  const bool is_text = text.find("format ascii") < header_end;
  const auto line_ends = static_cast<size_t>(
      std::count(text.begin() + static_cast<std::ptrdiff_t>(header_end), text.end(), '\n'));
  const bool is_short = line_ends + (text.ends_with('\n') ? 0 : 1) < wanted + 1;
  if (builder.vertex_count() + faces != wanted || (is_text && is_short)) {
    throw SceneError(file + ": holds less than its header says");
  }
  return std::move(builder.mesh());
}

}  // namespace plumb
