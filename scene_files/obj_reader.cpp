// SPDX-License-Identifier: Apache-2.0

#include <fmt/ranges.h>

#include <cctype>
#include <iterator>
#include <set>
#include <sstream>
#include <utility>

#include "scene_files/mesh_builder.h"
#include "scene_files/scene_reader.h"

namespace plumb {
namespace {

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

}  // namespace plumb
