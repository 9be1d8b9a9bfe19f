#include "renderer/scene_reader.h"

#include <Imath/ImathMatrixAlgo.h>
#include <OpenImageIO/hash.h>
#include <OpenImageIO/strutil.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <numbers>
#include <optional>
#include <sstream>

#include "renderer/obj_reader.h"
#include "renderer/scene_grammar.h"

namespace plumb {
namespace {

using Imath::M44d;  // for row vectors: its rows are what becomes of the axes and of the origin
using pugi::xml_node;

xml_node parameter(const xml_node& parent, const char* name) {
  return parent.find_child_by_attribute("name", name);
}

// `count` numbers between blanks or commas. In a `value`, one stands for three equal ones.
std::vector<double> read_numbers(const xml_node& node, const std::string& name, size_t count) {
  std::string text = node.attribute(name.c_str()).value();
  std::ranges::replace(text, ',', ' ');
  std::istringstream stream(text + " ");
  std::vector<double> numbers;
  for (double number = 0.0; stream >> number >> std::ws;) {
    numbers.push_back(number);
    if (stream.eof()) break;
  }
  if (name == "value" && count == 3 && numbers.size() == 1) numbers.resize(3, numbers[0]);
  if (stream && numbers.size() == count) return numbers;
  throw Refusal{node, fmt::format("{} must be {} finite number(s)", name, count)};
}

// Without a number for what is missing, x, y and z must all be there.
Vec3 read_vector(const xml_node& node, const char* name, std::optional<double> missing = {}) {
  const auto coordinate = [&](const char* axis) {
    return missing && !node.attribute(axis) ? *missing : read_numbers(node, axis, 1)[0];
  };
  if (!node.attribute(name)) return {coordinate("x"), coordinate("y"), coordinate("z")};
  if (node.attribute("x") || node.attribute("y") || node.attribute("z")) {
    throw Refusal{node, "give either value or x, y, z"};
  }
  const auto numbers = read_numbers(node, name, 3);
  return {numbers[0], numbers[1], numbers[2]};
}

Vec3 row(const M44d& map, int i) { return {map[i][0], map[i][1], map[i][2]}; }

// By which factor the map scales all directions alike, negative if it mirrors; else 0.
double uniform_scale(const M44d& map) {
  Vec3 scale, shear;
  if (!Imath::extractScalingAndShear(map, scale, shear, false)) return 0.0;
  const double deviation = (scale / scale.x - Vec3(1.0)).length() + shear.length();
  return deviation < 1e-5 ? scale.x : 0.0;
}

M44d read_rotate(const xml_node& rotate) {
  const Vec3 axis = read_vector(rotate, "value", 0.0);
  // Mitsuba scales the scene if the axis has another length.
  if (!(std::abs(axis.length() - 1.0) < 1e-5)) throw Refusal{rotate, "the axis must have length 1"};
  const double degrees = read_numbers(rotate, "angle", 1)[0];
  M44d map;
  map.setAxisAngle(axis, degrees * std::numbers::pi / 180.0);
  // Rounding is taken away, so that walls turned by right angles stay flat.
  for (int i = 0; i < 16; ++i) map[i / 4][i % 4] *= std::abs(map[i / 4][i % 4]) > 1e-15;
  return map;
}

M44d read_matrix(const xml_node& matrix) {
  const auto numbers = read_numbers(matrix, "value", 16);  // row by row, for column vectors
  M44d map;
  for (int i = 0; i < 16; ++i) map[i % 4][i / 4] = numbers[size_t(i)];
  if (map[0][3] != 0.0 || map[1][3] != 0.0 || map[2][3] != 0.0 || map[3][3] != 1.0) {
    throw Refusal{matrix, "the last row must be 0 0 0 1"};
  }
  return map;
}

M44d read_lookat(const xml_node& lookat) {
  const Vec3 o = read_vector(lookat, "origin");
  const Vec3 forward = (read_vector(lookat, "target") - o).normalized();
  const Vec3 left = read_vector(lookat, "up").normalized().cross(forward);
  if (!(left.length() > 1e-6)) throw Refusal{lookat, "origin, target and up are on one line"};
  const Vec3 x = left.normalized();
  const Vec3 y = forward.cross(x);
  return {x.x, x.y, x.z, 0, y.x, y.y, y.z, 0, forward.x, forward.y, forward.z, 0, o.x, o.y, o.z, 1};
}

M44d read_step(const xml_node& step) {
  const std::string_view tag = step.name();
  if (tag == "translate") return M44d().setTranslation(read_vector(step, "value", 0.0));
  if (tag == "scale") return M44d().setScale(read_vector(step, "value", 1.0));
  if (tag == "rotate") return read_rotate(step);
  return tag == "matrix" ? read_matrix(step) : read_lookat(step);
}

M44d read_to_world(const xml_node& parent) {
  const xml_node transform = parameter(parent, "to_world");
  M44d map;
  for (const xml_node& step : transform.children()) map *= read_step(step);
  const double box = row(map, 0).length() * row(map, 1).length() * row(map, 2).length();
  if (std::abs(map.determinant()) > 1e-12 * box) return map;
  throw Refusal{transform, "the transform is singular"};
}

Rgb read_rgb(const xml_node& parent, const char* name, double missing, double highest) {
  const xml_node parameter_node = parameter(parent, name);
  if (!parameter_node) return Rgb(missing);
  const Rgb rgb = read_vector(parameter_node, "value");
  if (std::min({rgb.x, rgb.y, rgb.z}) >= 0.0 && std::max({rgb.x, rgb.y, rgb.z}) <= highest) {
    return rgb;
  }
  throw Refusal{parameter_node, fmt::format("must be from 0 to {}", highest)};
}

// The BSDF in an element, be it there itself or by reference; a null node if there is none.
xml_node find_bsdf(const xml_node& parent) {
  const xml_node ref = parent.child("ref");
  if (!ref) return parent.child("bsdf");
  const std::string_view id = ref.attribute("id").value();
  const xml_node target = ref.root().find_node([&](const xml_node& node) {
    return node.name() == std::string_view("bsdf") && node.attribute("id").value() == id;
  });
  return target ? target : throw Refusal{ref, "no <bsdf> has this id"};
}

Bsdf read_bsdf(const xml_node& node) {
  using Kind = Bsdf::Kind;
  const std::string_view type = node.attribute("type").value();
  if (type == "diffuse") return {Kind::diffuse, read_rgb(node, "reflectance", 0.5, 1.0)};
  if (type == "conductor") {
    return {Kind::conductor, read_rgb(node, "specular_reflectance", 1.0, 1.0)};
  }
  const xml_node nested = find_bsdf(node);
  if (nested.attribute("type").value() == type) throw Refusal{node, "must not hold its like"};
  Bsdf bsdf = read_bsdf(nested);
  bsdf.two_sided = true;
  return bsdf;
}

Mesh read_rectangle_or_cube(const xml_node& shape, const M44d& to_world) {
  // Bits 0, 1 and 2 of a corner say whether x, y and z are 1 or -1. The last face is the
  // rectangle's, once it lies at z = 0.
  constexpr int faces[6][4] = {{2, 0, 4, 6}, {1, 3, 7, 5}, {4, 0, 1, 5},
                               {2, 6, 7, 3}, {1, 0, 2, 3}, {4, 5, 7, 6}};
  const bool is_cube = shape.attribute("type").value() == std::string_view("cube");
  Mesh mesh(is_cube ? 6 : 1);
  for (size_t i = 0; i < mesh.size(); ++i) {
    auto& corners = mesh[i].corners;
    for (const int bits : faces[6 - mesh.size() + i]) {
      const Vec3 corner(bits & 1 ? 1 : -1, bits & 2 ? 1 : -1, bits & 4 ? 1 : -1);
      corners.push_back((is_cube ? corner : corner * Vec3(1, 1, 0)) * to_world);
    }
    // Mitsuba's normals stay on the same side of what is mirrored.
    if (to_world.determinant() < 0.0) std::reverse(corners.begin(), corners.end());
  }
  return mesh;
}

Sphere read_sphere(const xml_node& shape, const M44d& to_world) {
  const xml_node radius_node = parameter(shape, "radius");
  const double radius = radius_node ? read_numbers(radius_node, "value", 1)[0] : 1.0;
  if (!(radius > 0.0)) throw Refusal{radius_node, "a radius must be positive"};
  const double scale = uniform_scale(to_world);
  if (!(scale > 0.0)) throw Refusal{shape, "must not be mirrored, sheared or scaled unevenly"};
  const xml_node center = parameter(shape, "center");
  return {(center ? read_vector(center, "value") : Vec3(0.0)) * to_world, radius * scale};
}

// The bytes of a file, which count for the scene's hash; none if it cannot be read.
std::string read_bytes(const std::filesystem::path& file, OIIO::SHA1& hash) {
  std::ostringstream bytes;
  bytes << std::ifstream(file, std::ios::binary).rdbuf();
  hash.append(bytes.view().data(), bytes.view().size());
  return bytes.str();
}

int read_image_side(const xml_node& film, const char* name, int missing) {
  const xml_node node = parameter(film, name);
  const double side = node ? read_numbers(node, "value", 1)[0] : missing;
  if (side >= 1 && side <= largest_image_side && side == std::floor(side)) return int(side);
  throw Refusal{node, fmt::format("must be an integer from 1 to {}", largest_image_side)};
}

// Mitsuba's camera looks along its z; its x points to the left of the image.
Camera read_sensor(const xml_node& sensor) {
  Camera camera;
  camera.width = read_image_side(sensor.child("film"), "width", 768);
  camera.height = read_image_side(sensor.child("film"), "height", 576);
  camera.fov_degrees = read_numbers(parameter(sensor, "fov"), "value", 1)[0];
  if (!(camera.fov_degrees > 0.0 && camera.fov_degrees < 180.0)) {
    throw Refusal{parameter(sensor, "fov"), "must be more than 0 and less than 180 degrees"};
  }
  const std::string axis = parameter(sensor, "fov_axis").attribute("value").as_string("x");
  constexpr std::array<std::string_view, 5> axes = {"x", "y", "diagonal", "smaller", "larger"};
  camera.fov_axis = Camera::FovAxis(std::ranges::find(axes, axis) - axes.begin());

  const M44d to_world = read_to_world(sensor);
  if (!(std::abs(std::abs(uniform_scale(to_world)) - 1.0) < 1e-5)) {
    throw Refusal{sensor, "must not be scaled or sheared"};
  }
  camera.origin = row(to_world, 3);
  camera.right = -row(to_world, 0).normalized();
  camera.up = row(to_world, 1).normalized();
  camera.forward = row(to_world, 2).normalized();
  return camera;
}

Shape read_shape(const xml_node& node, const std::filesystem::path& folder, OIIO::SHA1& hash) {
  const std::string_view type = node.attribute("type").value();
  const M44d to_world = read_to_world(node);
  Shape shape;
  shape.id = node.attribute("id").value();
  if (type == "sphere") {
    shape.geometry = read_sphere(node, to_world);
  } else if (type == "obj") {
    const xml_node filename = parameter(node, "filename");
    const auto file = folder / filename.attribute("value").value();
    const std::string text = read_bytes(file, hash);
    if (text.empty()) throw Refusal{filename, file.string() + " cannot be read or is empty"};
    shape.geometry = read_obj(file.string(), text, to_world);
  } else {
    shape.geometry = read_rectangle_or_cube(node, to_world);
  }
  if (const xml_node bsdf = find_bsdf(node)) shape.bsdf = read_bsdf(bsdf);
  constexpr double highest_radiance = std::numeric_limits<double>::max();
  shape.radiance = read_rgb(node.child("emitter"), "radiance", 0.0, highest_radiance);
  const auto* mesh = std::get_if<Mesh>(&shape.geometry);
  if (shape.is_lamp() && mesh != nullptr && !std::ranges::all_of(*mesh, &Polygon::is_rectangle)) {
    throw Refusal{node.child("emitter"), "a lamp must be a sphere or made of rectangles"};
  }
  return shape;
}

std::string scene_name(const std::filesystem::path& file) {
  const auto folder = std::filesystem::absolute(file).lexically_normal().parent_path();
  const bool is_named_by_folder = file.filename() == "scene.xml" && folder.has_filename();
  return (is_named_by_folder ? folder.filename() : file.stem()).string();
}

std::string describe(const xml_node& node) {
  std::string text = fmt::format("<{}", node.name());
  for (const auto& a : node.attributes()) text += fmt::format(" {}=\"{}\"", a.name(), a.value());
  std::ranges::replace(text, '\n', ' ');
  return text + ">";
}

}  // namespace

Scene read_scene(const std::filesystem::path& file) {
  Scene scene;
  OIIO::SHA1 hash;
  const std::string text = read_bytes(file, hash);
  if (!std::filesystem::exists(file)) throw SceneError(file.string() + ": no such file");
  if (text.empty()) throw SceneError(file.string() + ": cannot be read or is empty");
  const auto fail = [&](std::ptrdiff_t offset, const std::string& what) {
    const auto line = 1 + std::count(text.begin(), text.begin() + offset, '\n');
    throw SceneError(fmt::format("{}:{}: {}", file.string(), line, what));
  };
  pugi::xml_document document;
  // As a fragment, so that text outside of <scene> is seen.
  constexpr auto options = pugi::parse_default | pugi::parse_fragment | pugi::parse_trim_pcdata |
                           pugi::parse_pi | pugi::parse_doctype;
  const auto result = document.load_buffer(text.data(), text.size(), options, pugi::encoding_utf8);
  if (!result) fail(result.offset, result.description());
  try {
    check_grammar(document);
    const xml_node root = document.child("scene");
    scene.camera = read_sensor(root.child("sensor"));
    for (const xml_node& shape : root.children("shape")) {
      scene.shapes.push_back(read_shape(shape, file.parent_path(), hash));
    }
    // They have done their work, but those that nothing refers to may hold mistakes.
    for (const xml_node& bsdf : root.children("bsdf")) read_bsdf(bsdf);
  } catch (const Refusal& refusal) {
    fail(refusal.node.offset_debug(), describe(refusal.node) + ": " + refusal.what);
  }
  scene.name = scene_name(file);
  scene.hash = OIIO::Strutil::lower(hash.digest());
  return scene;
}

}  // namespace plumb
