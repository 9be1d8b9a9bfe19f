#include "renderer/obj_reader.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <set>
#include <sstream>

#include "renderer/scene_reader.h"

namespace plumb {
namespace {

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

// The numbers of a face's corners are the rest of its statement: `5/1/7` is vertex 5.
Mesh read_face(std::istream& statement, const std::vector<Vec3>& vertices) {
  Polygon face;
  for (std::string word; statement >> word;) {
    std::istringstream number(word.substr(0, word.find('/')));
    size_t index = 0;
    const bool is_number = std::isdigit(word[0]) != 0 && number >> index && number.eof();
    if (!is_number || index < 1 || index > vertices.size()) {
      throw SceneError(fmt::format("{} is not one of {} vertices above", word, vertices.size()));
    }
    face.corners.push_back(vertices[index - 1]);
  }
  const auto& c = face.corners;
  if (c.size() != 3 && c.size() != 4) throw SceneError("a face has three corners or four");
  if (is_flat_and_convex(face)) return {face};
  Mesh triangles = {{{c[0], c[1], c[2]}}, {{c[0], c[2], c.back()}}};
  if (std::ranges::all_of(triangles, is_flat_and_convex)) return triangles;
  throw SceneError("the face or one of its triangles has no area");
}

}  // namespace

Mesh read_obj(const std::string& file, const std::string& text, const Imath::M44d& to_world) {
  const std::set<std::string> no_effect = {"", "vn", "vt", "o", "g", "s", "usemtl", "mtllib"};
  std::vector<Vec3> vertices;
  Mesh mesh;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::istringstream statement(line.substr(0, line.find('#')) + " ");
    std::string keyword;
    statement >> keyword;
    try {
      if (keyword == "v") {
        Vec3 v;
        const bool is_whole = (statement >> v.x >> v.y >> v.z >> std::ws) && statement.eof();
        if (!is_whole) throw SceneError("a vertex is three finite numbers");
        vertices.push_back(v * to_world);
      } else if (keyword == "f") {
        const Mesh face = read_face(statement, vertices);
        mesh.insert(mesh.end(), face.begin(), face.end());
      } else if (!no_effect.contains(keyword)) {
        throw SceneError(fmt::format("supported: v, f{}", fmt::join(no_effect, ", ")));
      }
    } catch (const SceneError& error) {
      throw SceneError(fmt::format("{}:{}: {}: {}", file, number, line, error.what()));
    }
  }
  if (mesh.empty()) throw SceneError(file + ": there are no faces");
  return mesh;
}

}  // namespace plumb
