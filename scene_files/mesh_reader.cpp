// SPDX-License-Identifier: Apache-2.0

#include "scene_files/mesh_reader.h"

#include <assimp/scene.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cctype>
#include <iterator>
#include <optional>
#include <set>
#include <sstream>
#include <utility>

#include "scene_files/scene_reader.h"

namespace plumb {
namespace {

// Unit vectors that differ by less are the same: files hold few digits.
constexpr double same_direction = 1e-3;

// Of a triangle: whether it has an area.
bool is_flat_and_convex(const Polygon& polygon) {
  const auto& c = polygon.corners;
  const Vec3 normal = polygon.normal();
  double size = 0.0;
  for (const Vec3& corner : c) size = std::max(size, (corner - c[0]).length());
  for (size_t i = 0; i < c.size(); ++i) {
    const Vec3 in = c[(i + 1) % c.size()] - c[i];
    const Vec3 out = c[(i + 2) % c.size()] - c[(i + 1) % c.size()];
    if (!(std::abs(normal.dot(c[i] - c[0])) <= 1e-6 * size)) return false;
    if (!(in.cross(out).dot(normal) > 1e-12 * size * size)) return false;
  }
  return true;
}

// A face's corner: numbers of its vertex and of its normal, if it has one.
struct Corner {
  size_t vertex = 0;
  std::optional<size_t> normal = {};
};

// Puts faces together from vertices and normals as they stand in a file.
class MeshBuilder {
 public:
  explicit MeshBuilder(const Imath::M44d& to_world)
      : to_world_(to_world), normals_to_world_(to_world.inverse().transposed()) {}

  size_t vertex_count() const { return vertices_.size(); }
  size_t normal_count() const { return normals_.size(); }
  MeshFile& mesh() { return mesh_; }

  void add_vertex(const Vec3& v) {
    vertices_.push_back(v * to_world_);
    normal_at_.emplace_back();
  }
  void add_normal(const Vec3& n) {
    Vec3 normal;
    normals_to_world_.multDirMatrix(n, normal);
    normals_.push_back(normal.normalized());
  }

  void add_face(const std::vector<Corner>& corners) {
    Polygon face;
    for (const Corner& corner : corners) face.corners.push_back(vertices_[corner.vertex]);
    if (corners.size() <= 4 && is_flat_and_convex(face)) return keep(face, corners);
    bool is_folded = false;
    std::optional<Vec3> first;  // triangle's normal
    for (size_t i = 2; i < corners.size(); ++i) {
      const Polygon triangle{{face.corners[0], face.corners[i - 1], face.corners[i]}};
      if (is_flat_and_convex(triangle)) {
        if (!first) first = triangle.normal();
        is_folded |= triangle.normal().dot(*first) < 0.0;
        keep(triangle, {corners[0], corners[i - 1], corners[i]});
      } else {
        ++mesh_.without_area;
      }
    }
    mesh_.folded += is_folded ? 1 : 0;
  }

 private:
  void keep(const Polygon& face, const std::vector<Corner>& corners) {
    const Vec3 normal = face.normal();
    const auto is_same = [&](const Vec3& n) { return (n - normal).length() < same_direction; };
    for (const Corner& corner : corners) {
      mesh_.lacks_normals |= !corner.normal;
      if (!corner.normal) continue;
      mesh_.has_normals = true;
      mesh_.normals_are_flat &= is_same(normals_[*corner.normal]);
    }
    for (const Corner& corner : corners) {
      auto& first = normal_at_[corner.vertex];
      if (first) mesh_.shares_corners |= !is_same(*first);
      first = normal;
    }
    mesh_.faces.push_back(face);
  }

  Imath::M44d to_world_, normals_to_world_;
  std::vector<Vec3> vertices_, normals_;
  std::vector<std::optional<Vec3>> normal_at_;  // of a face at each vertex
  MeshFile mesh_;
};

// A vertex may have a weight of 1 or a colour after its coordinates.
Vec3 read_vector(std::istream& statement) {
  const std::vector<double> numbers(std::istream_iterator<double>(statement), {});
  const bool has_weight = numbers.size() == 4 && numbers[3] == 1.0;
  const bool is_whole =
      statement.eof() && (numbers.size() == 3 || numbers.size() == 6 || has_weight);
  if (is_whole) return {numbers[0], numbers[1], numbers[2]};
  throw SceneError("must be three finite numbers");
}

size_t read_index(const std::string& corner, const std::string& word, size_t count,
                  const char* things) {
  std::istringstream number(word);
  size_t index = 0;
  const bool is_number = std::isdigit(word[0]) != 0 && number >> index && number.eof();
  if (is_number && index >= 1 && index <= count) return index - 1;
  throw SceneError(fmt::format("{} is not one of {} {} above", corner, count, things));
}

// Corners are the rest of a face's statement: `5/1/7` is vertex 5 with normal 7.
std::vector<Corner> read_corners(std::istream& statement, const MeshBuilder& builder) {
  std::vector<Corner> corners;
  for (std::string word; statement >> word;) {
    Corner corner{
        read_index(word, word.substr(0, word.find('/')), builder.vertex_count(), "vertices")};
    const size_t last = word.rfind('/');
    if (last != word.npos && last != word.find('/') && last + 1 < word.size()) {
      corner.normal = read_index(word, word.substr(last + 1), builder.normal_count(), "normals");
    }
    corners.push_back(corner);
  }
  if (corners.size() < 3) throw SceneError("a face has at least three corners");
  return corners;
}

}  // namespace

MeshFile read_obj(const std::string& file, const std::string& text, const Imath::M44d& to_world) {
  const std::set<std::string> no_effect = {"",  "vt", "o",  "g",      "s",      "l",
                                           "p", "vp", "mg", "usemtl", "mtllib", "usemap"};
  MeshBuilder builder(to_world);
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::istringstream statement(line.substr(0, line.find('#')) + " ");
    std::string keyword;
    statement >> keyword;
    try {
      if (keyword == "v") {
        builder.add_vertex(read_vector(statement));
      } else if (keyword == "vn") {
        builder.add_normal(read_vector(statement));
      } else if (keyword == "f") {
        builder.add_face(read_corners(statement, builder));
      } else if (!no_effect.contains(keyword)) {
        throw SceneError(fmt::format("supported: v, vn, f{}", fmt::join(no_effect, ", ")));
      }
    } catch (const SceneError& error) {
      throw SceneError(fmt::format("{}:{}: {}: {}", file, number, line, error.what()));
    }
  }
  return std::move(builder.mesh());
}

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
