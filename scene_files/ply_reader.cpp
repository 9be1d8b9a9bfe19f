// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

#include "scene_files/mesh_builder.h"
#include "scene_files/scene_reader.h"

namespace plumb {
namespace {

template <typename T>
double number_at(const char* bytes) {
  T number{};
  std::memcpy(&number, bytes, sizeof number);
  return static_cast<double>(number);
}

struct PlyType {
  std::string_view name, other_name;
  size_t size;
  double (*number_at)(const char* bytes);
};
constexpr PlyType ply_types[] = {
    {"char", "int8", 1, number_at<int8_t>},    {"uchar", "uint8", 1, number_at<uint8_t>},
    {"short", "int16", 2, number_at<int16_t>}, {"ushort", "uint16", 2, number_at<uint16_t>},
    {"int", "int32", 4, number_at<int32_t>},   {"uint", "uint32", 4, number_at<uint32_t>},
    {"float", "float32", 4, number_at<float>}, {"double", "float64", 8, number_at<double>}};

struct PlyProperty {
  std::string name;
  const PlyType* type;
  const PlyType* count;  // of a list; else null
};

struct PlyElement {
  std::string name;
  size_t count = 0;
  std::vector<PlyProperty> properties = {};
};

struct PlyHeader {
  std::string format = {};
  std::vector<PlyElement> elements = {};
};

std::string next_word(std::istream& stream) {
  std::string word;
  stream >> word;
  return word;
}

const PlyType* read_type(const std::string& name) {
  for (const PlyType& type : ply_types) {
    if (name == type.name || name == type.other_name) return &type;
  }
  throw SceneError(fmt::format("no type '{}'", name));
}

// Leaves the stream behind the header.
PlyHeader read_header(std::istream& stream) {
  PlyHeader header;
  if (next_word(stream) != "ply") throw SceneError("not a PLY file");
  for (std::string line; std::getline(stream, line);) {
    std::istringstream statement(line);
    const std::string keyword = next_word(statement);
    if (keyword == "end_header" && !header.format.empty()) return header;
    if (keyword == "format") {
      header.format = next_word(statement);
      const auto formats = {"ascii", "binary_little_endian", "binary_big_endian"};
      if (std::ranges::count(formats, header.format) == 0) throw SceneError("no " + line);
    }
    if (keyword == "element") {
      header.elements.push_back({next_word(statement)});
      statement >> header.elements.back().count;
      if (!statement) throw SceneError(line + ": lacks a count");
    }
    if (keyword != "property") continue;
    if (header.elements.empty()) throw SceneError(line + ": is of no element");
    std::string type = next_word(statement);
    const PlyType* count = nullptr;
    if (type == "list") {
      count = read_type(next_word(statement));
      type = next_word(statement);
    }
    header.elements.back().properties.push_back({next_word(statement), read_type(type), count});
  }
  throw SceneError("the header lacks its format or its end");
}

double read_number(std::istream& stream, const std::string& format, const PlyType& type) {
  double number = 0.0;
  if (format == "ascii") {
    stream >> number;
  } else {
    std::string bytes(type.size, '\0');
    stream.read(bytes.data(), static_cast<std::streamsize>(type.size));
    const bool is_little = format == "binary_little_endian";
    if (is_little != (std::endian::native == std::endian::little)) std::ranges::reverse(bytes);
    number = type.number_at(bytes.data());
  }
  if (!stream) throw SceneError("holds less than its header says, or what is no number");
  return number;
}

// Of a vertex or a face: the numbers of each property.
using PlyNumbers = std::map<std::string, std::vector<double>>;

void read_numbers(std::istream& stream, const std::string& format, const PlyElement& element,
                  PlyNumbers& numbers) {
  for (const PlyProperty& property : element.properties) {
    std::vector<double>& of_property = numbers[property.name];
    of_property.clear();
    const double count = property.count ? read_number(stream, format, *property.count) : 1.0;
    for (double i = 0.0; i < count; ++i) {
      of_property.push_back(read_number(stream, format, *property.type));
    }
  }
}

std::optional<Vec3> to_vector(const PlyNumbers& numbers, const std::array<const char*, 3>& names) {
  Vec3 vector;
  for (int i = 0; i < 3; ++i) {
    const auto found = numbers.find(names[size_t(i)]);
    if (found == numbers.end() || found->second.size() != 1) return {};
    vector[i] = found->second[0];
    if (!std::isfinite(vector[i])) throw SceneError("must have finite numbers");
  }
  return vector;
}

void add_vertex(const PlyNumbers& numbers, MeshBuilder& builder) {
  const auto vertex = to_vector(numbers, {"x", "y", "z"});
  if (!vertex) throw SceneError("must have x, y and z");
  builder.add_vertex(*vertex);
  if (const auto normal = to_vector(numbers, {"nx", "ny", "nz"})) builder.add_normal(*normal);
}

void add_face(PlyNumbers& numbers, MeshBuilder& builder) {
  std::vector<Corner> corners;
  for (const char* name : {"vertex_indices", "vertex_index"}) {
    for (const double number : numbers[name]) {
      const bool is_there = number >= 0.0 && number < double(builder.vertex_count());
      if (!is_there || number != std::floor(number)) {
        throw SceneError(
            fmt::format("{} is not one of {} vertices above", number, builder.vertex_count()));
      }
      corners.push_back({static_cast<size_t>(number)});
      if (builder.normal_count() == builder.vertex_count()) {
        corners.back().normal = corners.back().vertex;
      }
    }
  }
  if (corners.size() < 3) throw SceneError("must have three or more vertex_indices");
  builder.add_face(corners);
}

}  // namespace

MeshFile read_ply(const std::string& file, const std::string& text, const Imath::M44d& to_world) {
  MeshBuilder builder(to_world);
  std::istringstream stream(text);
  std::string place = file;
  try {
    const PlyHeader header = read_header(stream);
    for (const PlyElement& element : header.elements) {
      if (element.properties.empty()) continue;
      PlyNumbers numbers;
      for (size_t i = 0; i < element.count; ++i) {
        place = fmt::format("{}: {} {}", file, element.name, i);
        read_numbers(stream, header.format, element, numbers);
        if (element.name == "vertex") add_vertex(numbers, builder);
        if (element.name == "face") add_face(numbers, builder);
      }
    }
  } catch (const SceneError& error) {
    throw SceneError(fmt::format("{}: {}", place, error.what()));
  }
  return std::move(builder.mesh());
}

}  // namespace plumb
