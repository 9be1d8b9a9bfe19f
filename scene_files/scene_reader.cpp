// SPDX-License-Identifier: Apache-2.0

#include "scene_files/scene_reader.h"

#include <Imath/ImathMatrixAlgo.h>
#include <fmt/format.h>

#include <algorithm>
#include <boost/algorithm/string/case_conv.hpp>
#include <boost/algorithm/string/trim.hpp>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <optional>
#include <sstream>
#include <tuple>

#include "scene_files/air_gap.h"
#include "scene_files/mesh_reader.h"
#include "scene_files/refractive_index.h"
#include "scene_files/scene_file.h"
#include "scene_files/scene_grammar.h"
#include "scene_files/spectrum.h"

namespace plumb {
namespace {

using Imath::M44d;  // for row vectors: its rows are what becomes of the axes and of the origin
using pugi::xml_node;

xml_node parameter(const xml_node& parent, const char* name) {
  return parent.find_child_by_attribute("name", name);
}

std::string type_of(const xml_node& node) { return node.attribute("type").value(); }

Vec3 row(const M44d& map, int i) { return {map[i][0], map[i][1], map[i][2]}; }

// By which factor the map scales all directions alike, negative if it mirrors; else 0.
double uniform_scale(const M44d& map) {
  Vec3 scale, shear;
  if (!Imath::extractScalingAndShear(map, scale, shear, false)) return 0.0;
  const double deviation = (scale / scale.x - Vec3(1.0)).length() + shear.length();
  return deviation < 1e-5 ? scale.x : 0.0;
}

// The nearest and the farthest that the camera could see of the scene, along its axis; of spheres
// what is on the safe side.
std::pair<double, double> depths_in_view(const Scene& scene) {
  const Camera& c = scene.camera;
  const double x = c.half_width(), y = c.half_height();
  const Vec3 inwards[] = {c.forward * x + c.right, c.forward * x - c.right, c.forward * y + c.up,
                          c.forward * y - c.up, c.forward};
  double nearest = std::numeric_limits<double>::infinity(), farthest = 0.0;
  const auto include = [&](double low, double high) {
    nearest = std::min(nearest, std::max(low, 0.0));
    farthest = std::max(farthest, high);
  };
  for (const Shape& shape : scene.shapes) {
    if (const auto* sphere = std::get_if<Sphere>(&shape.geometry)) {
      const Vec3 to_center = sphere->center - c.origin;
      const bool is_seen = std::ranges::all_of(inwards, [&](const Vec3& normal) {
        return normal.dot(to_center) > -sphere->radius * normal.length();
      });
      if (!is_seen) continue;
      // A ray meets it no closer than its surface is, and no farther than the horizon from outside;
      // towards a corner of the picture a depth is less than a distance.
      const double distance = to_center.length();
      const double gap = std::abs(distance - sphere->radius) / std::sqrt(1.0 + x * x + y * y);
      const double depth = c.forward.dot(to_center);
      const double horizon = distance * distance - sphere->radius * sphere->radius;
      include(std::max(depth - sphere->radius, gap),
              horizon > 0.0 ? std::sqrt(horizon) : depth + sphere->radius);
      continue;
    }
    for (const Polygon& face : std::get<Mesh>(shape.geometry)) {
      std::vector<Vec3> corners = face.corners;
      for (Vec3& corner : corners) corner -= c.origin;
      for (const Vec3& normal : inwards) corners = part_beyond(corners, normal, 0.0);
      for (const Vec3& corner : corners) include(c.forward.dot(corner), c.forward.dot(corner));
    }
  }
  return {nearest, farthest};
}

// Turns the elements of a file into a scene. What can't be read is refused, and something harmless
// stands in for it until all refusals are told.
class Reader {
 public:
  explicit Reader(SceneFile& file) : file_(file) {}

  Scene read() {
    check_grammar(file_);
    const xml_node root = file_.document().child("scene");
    check_version(root);
    for (const xml_node& node : root.children("shape")) {
      if (!file_.is_refused(node)) scene_.shapes.push_back(read_shape(node));
    }
    for (const xml_node& node : root.children("emitter")) {
      if (!file_.is_refused(node)) read_emitter(node);
    }
    const auto is_specular = [](const Shape& shape) { return shape.bsdf.is_specular(); };
    if (!scene_.points.empty() && std::ranges::any_of(scene_.shapes, is_specular)) {
      file_.note(
          "what mirrors and glass make of a point's light is missing: no path meets a point, here "
          "as in Mitsuba and Cycles");
    }
    for (const std::string& note : leave_air_around_glass(scene_)) file_.note(note);
    // They have done their work, but those that nothing refers to may hold mistakes.
    for (const xml_node& node : root.children("bsdf")) {
      if (!file_.is_refused(node)) read_bsdf(node);
    }
    const xml_node sensor = root.child("sensor");
    if (!file_.is_refused(sensor)) {
      read_sensor(sensor);
      check_clip_planes(sensor);
    }
    if (!file_.is_refused(root.child("integrator"))) read_integrator(root.child("integrator"));
    return std::move(scene_);
  }

 private:
  static constexpr double highest_radiance = 1e30;  // far from float's largest, times any weight

  // Numbers between blanks or commas; none if there is anything else.
  static std::vector<double> parse_numbers(std::string text) {
    std::ranges::replace(text, ',', ' ');
    std::istringstream stream(text + " ");
    const std::vector<double> numbers(std::istream_iterator<double>(stream), {});
    return stream.eof() ? numbers : std::vector<double>{};
  }

  // In a `value`, one stands for three equal ones.
  std::vector<double> read_numbers(const xml_node& node, const std::string& name, size_t count) {
    auto numbers = parse_numbers(node.attribute(name.c_str()).value());
    if (name == "value" && count == 3 && numbers.size() == 1) numbers.resize(3, numbers[0]);
    if (numbers.size() == count) return numbers;
    file_.refuse(node, fmt::format("{} must be {} finite number(s)", name, count));
    return std::vector<double>(count, 1.0);
  }

  double read_number(const xml_node& parent, const char* name, double missing) {
    const xml_node node = parameter(parent, name);
    return node ? read_numbers(node, "value", 1)[0] : missing;
  }

  double read_positive(const xml_node& parent, const char* name, double missing) {
    const double number = read_number(parent, name, missing);
    if (number > 0.0) return number;
    file_.refuse(parameter(parent, name), "must be positive");
    return missing;
  }

  bool read_flag(const xml_node& parent, const char* name) {
    const xml_node node = parameter(parent, name);
    const std::string value = boost::to_lower_copy<std::string>(node.attribute("value").value());
    if (node && value != "true" && value != "false") file_.refuse(node, "supported: true, false");
    return value == "true";
  }

  // Without a number for what is missing, x, y and z must all be there.
  Vec3 read_vector(const xml_node& node, const char* name, std::optional<double> missing = {}) {
    const auto coordinate = [&](const char* axis) {
      return missing && !node.attribute(axis) ? *missing : read_numbers(node, axis, 1)[0];
    };
    if (!node.attribute(name)) return {coordinate("x"), coordinate("y"), coordinate("z")};
    if (node.attribute("x") || node.attribute("y") || node.attribute("z")) {
      file_.refuse(node, "give either value or x, y, z");
    }
    const auto numbers = read_numbers(node, name, 3);
    return {numbers[0], numbers[1], numbers[2]};
  }

  void check_version(const xml_node& root) {
    if (!root.attribute("version")) return;  // refused already
    const auto version = boost::trim_copy<std::string>(root.attribute("version").value());
    const bool is_known = !version.empty() && version[0] >= '0' && version[0] <= '3';
    if (!is_known || (version.size() > 1 && version[1] != '.')) {
      file_.refuse(root, "supported: versions 0.x to 3.x");
    }
  }

  // -- Transforms

  M44d read_rotate(const xml_node& rotate) {
    const Vec3 axis = read_vector(rotate, "value", 0.0);
    const double degrees = read_numbers(rotate, "angle", 1)[0];
    // Mitsuba scales the scene if the axis has another length.
    if (!(std::abs(axis.length() - 1.0) < 1e-5)) {
      const Vec3 unit = axis.length() > 0.0 ? axis.normalized() : Vec3(0.0, 1.0, 0.0);
      file_.refuse(rotate, fmt::format("the axis must have length 1: write value=\"{}, {}, {}\"",
                                       unit.x, unit.y, unit.z));
      return {};
    }
    M44d map;
    map.setAxisAngle(axis, degrees * std::numbers::pi / 180.0);
    // Rounding is taken away, so that walls turned by right angles stay flat.
    for (int i = 0; i < 16; ++i) map[i / 4][i % 4] *= std::abs(map[i / 4][i % 4]) > 1e-15;
    return map;
  }

  M44d read_matrix(const xml_node& matrix) {
    // Row by row, for column vectors; 9 numbers are without the last row and column.
    const bool is_small = parse_numbers(matrix.attribute("value").value()).size() == 9;
    const int size = is_small ? 3 : 4;
    const auto numbers = read_numbers(matrix, "value", is_small ? 9 : 16);
    M44d map;
    for (int i = 0; i < size * size; ++i) map[i % size][i / size] = numbers[size_t(i)];
    if (map[0][3] != 0.0 || map[1][3] != 0.0 || map[2][3] != 0.0 || map[3][3] != 1.0) {
      file_.refuse(matrix, "the last row must be 0 0 0 1");
      return {};
    }
    return map;
  }

  M44d read_lookat(const xml_node& lookat) {
    const Vec3 o = read_vector(lookat, "origin");
    const Vec3 forward = (read_vector(lookat, "target") - o).normalized();
    const Vec3 left = read_vector(lookat, "up").normalized().cross(forward);
    if (!(left.length() > 1e-6)) {
      file_.refuse(lookat, "origin, target and up are on one line");
      return {};
    }
    const Vec3 x = left.normalized();
    const Vec3 y = forward.cross(x);
    return {x.x,       x.y,       x.z,       0, y.x, y.y, y.z, 0,
            forward.x, forward.y, forward.z, 0, o.x, o.y, o.z, 1};
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
    file_.refuse(transform, "the transform is singular");
    return {};
  }

  // -- Colours

  // "400:0.1, 500:0.2", or a file of two columns.
  Spectrum read_spectrum(const xml_node& node) {
    std::string text = node.attribute("value").value();
    const auto filename = node.attribute("filename");
    if (filename) {
      const auto file = file_.find(node, filename.value());
      std::istringstream lines(file_.read_bytes(file));
      for (std::string line; std::getline(lines, line);) {
        text += line.substr(0, line.find('#')) + " ";
      }
      if (text.empty()) file_.refuse(node, file.string() + " cannot be read or is empty");
    }
    std::ranges::replace(text, ':', ' ');
    const std::vector<double> numbers = parse_numbers(text);
    Spectrum spectrum;
    for (size_t i = 0; i + 1 < numbers.size(); i += 2) {
      spectrum.emplace_back(numbers[i], numbers[i + 1]);
    }
    const auto is_not_rising = [](const auto& a, const auto& b) { return a.first >= b.first; };
    if (spectrum.size() >= 2 && numbers.size() % 2 == 0 &&
        std::ranges::adjacent_find(spectrum, is_not_rising) == spectrum.end()) {
      return spectrum;
    }
    file_.refuse(node, "must be two or more wavelength:value, the wavelengths rising");
    return {{400.0, 0.0}, {700.0, 0.0}};
  }

  // As Mitsuba's rgb variants do.
  Rgb read_typed_spectrum(const xml_node& node) {
    const double scale = read_number(node, "scale", 1.0);
    if (type_of(node) == "uniform") return Rgb(read_number(node, "value", 1.0));
    if (type_of(node) == "d65") {
      const xml_node color = parameter(node, "color");
      return (color ? read_color(color, true, 1.0) : Rgb(1.0)) * scale;
    }
    file_.note(node, "by Planck's law, in W / (m^2 sr nm); Mitsuba's rgb variants refuse it");
    return emission_of(black_body(read_positive(node, "temperature", 5000.0))) * scale;
  }

  Rgb read_color(const xml_node& node, bool is_emission, double highest) {
    const std::string value = node.attribute("value").value();
    if (node.name() != std::string_view("spectrum")) {
      if (value.starts_with('#')) file_.refuse(node, "write linear values: value=\"r, g, b\"");
      return value.starts_with('#') ? Rgb(0.0) : read_vector(node, "value");
    }
    if (node.attribute("type")) return read_typed_spectrum(node);
    const std::vector<double> numbers = parse_numbers(value);
    if (numbers.size() == 1) return is_emission ? even_emission(numbers[0]) : Rgb(numbers[0]);
    if (numbers.size() == 3) {
      file_.note(node, "three numbers are taken as red, green, blue, which is <rgb> today");
      return {numbers[0], numbers[1], numbers[2]};
    }
    const Spectrum spectrum = read_spectrum(node);
    const Rgb rgb = is_emission ? emission_of(spectrum) : reflectance_of(spectrum, highest);
    file_.note(node,
               fmt::format("taken as rgb {:.6g}, {:.6g}, {:.6g}, as Mitsuba's rgb variants do",
                           rgb.x, rgb.y, rgb.z));
    return rgb;
  }

  Rgb read_color(const xml_node& parent, const char* name, double missing, double highest) {
    const xml_node node = parameter(parent, name);
    if (!node) return Rgb(missing);
    const std::string_view meaning = name;
    const Rgb rgb = read_color(node, meaning == "radiance" || meaning == "intensity", highest);
    if (std::min({rgb.x, rgb.y, rgb.z}) >= 0.0 && std::max({rgb.x, rgb.y, rgb.z}) <= highest) {
      return rgb;
    }
    file_.refuse(node, fmt::format("must be from 0 to {}", highest));
    return Rgb(missing);
  }

  // -- Shapes

  Bsdf read_conductor(const xml_node& node, bool two_sided) {
    constexpr double highest = 1e3;
    const xml_node material = parameter(node, "material");
    const std::string name = material.attribute("value").as_string("none");
    Bsdf bsdf{.kind = Bsdf::Kind::conductor,
              .reflectance = read_color(node, "specular_reflectance", 1.0, 1.0),
              .two_sided = two_sided};
    if (name == "none") {
      if (!parameter(node, "eta") && !parameter(node, "k")) return bsdf;
      bsdf.eta = read_color(node, "eta", 0.0, highest);
      bsdf.k = read_color(node, "k", 1.0, highest);
    } else if (parameter(node, "eta") || parameter(node, "k")) {
      file_.refuse(material, "give either material or eta and k");
    } else if (const auto index = complex_refractive_index(name)) {
      std::tie(bsdf.eta, bsdf.k) = *index;
    } else {
      file_.refuse(material, "supported: " + names_of_metals());
    }
    // Where both are 0, as the red of AlSb is, all is reflected, but Fresnel's equations are 0 / 0
    // for light that comes straight; they aren't with another k.
    for (int c = 0; c < 3; ++c) {
      if (std::max(bsdf.eta[c], bsdf.k[c]) < 1e-6) bsdf.k[c] = 1.0;
    }
    return bsdf;
  }

  Bsdf read_rough_conductor(const xml_node& node, bool two_sided) {
    Bsdf bsdf = read_conductor(node, two_sided);
    const xml_node u = parameter(node, "alpha_u"), v = parameter(node, "alpha_v");
    bsdf.alpha = read_positive(node, u ? "alpha_u" : "alpha", 0.1);
    constexpr double least = 1e-3;  // float has no digits for less
    if (!(bsdf.alpha >= least && bsdf.alpha <= 1.0)) {
      file_.refuse(u ? u : parameter(node, "alpha"), fmt::format("must be from {} to 1", least));
    }
    if (u && parameter(node, "alpha")) file_.refuse(u, "give either alpha or alpha_u and alpha_v");
    if (bool(u) != bool(v) || (v && read_positive(node, "alpha_v", 0.1) != bsdf.alpha)) {
      file_.refuse(u ? u : v, "supported: alpha_u and alpha_v that are the same");
    }
    if (!parameter(node, "distribution")) {
      file_.refuse(node,
                   "is Beckmann's in Mitsuba; supported: "
                   R"(<string name="distribution" value="ggx"/>)");
    }
    return bsdf;
  }

  // A number or a name.
  double read_index(const xml_node& parent, const char* name, const char* missing) {
    const xml_node node = parameter(parent, name);
    if (node.name() == std::string_view("float")) {
      const double number = read_number(parent, name, 1.0);
      if (number >= 1e-3 && number <= 1e3) return number;
      file_.refuse(node, "must be from 0.001 to 1000");
      return 1.0;
    }
    const auto index = refractive_index(node.attribute("value").as_string(missing));
    if (!index)
      file_.refuse(node, "must be a <float> or, as a <string>, one of " + names_of_transparent());
    return index.value_or(1.0);
  }

  Bsdf read_dielectric(const xml_node& node) {
    return {.kind = Bsdf::Kind::dielectric,
            .reflectance = read_color(node, "specular_reflectance", 1.0, 1.0),
            .two_sided = true,
            .ior = read_index(node, "int_ior", "bk7") / read_index(node, "ext_ior", "air"),
            .transmittance = read_color(node, "specular_transmittance", 1.0, 1.0)};
  }

  Bsdf read_bsdf(const xml_node& node) {
    const std::string type = type_of(node);
    const bool two_sided = read_flag(node, "two_sided");
    if (type == "diffuse") {
      return {.reflectance = read_color(node, "reflectance", 0.5, 1.0), .two_sided = two_sided};
    }
    if (type == "conductor") return read_conductor(node, two_sided);
    if (type == "roughconductor") return read_rough_conductor(node, two_sided);
    if (type == "dielectric") return read_dielectric(node);
    const xml_node nested = node.child("bsdf");
    if (type_of(nested) == type) {
      file_.refuse(node, "must not hold its like");
      return {};
    }
    Bsdf bsdf = read_bsdf(nested);
    if (bsdf.kind == Bsdf::Kind::dielectric) file_.refuse(node, "glass has two sides already");
    bsdf.two_sided = true;
    return bsdf;
  }

  static Mesh read_rectangle_or_cube(const xml_node& shape, const M44d& to_world) {
    // Bits 0, 1 and 2 of a corner say whether x, y and z are 1 or -1. The last face is the
    // rectangle's, once it lies at z = 0.
    constexpr int faces[6][4] = {{2, 0, 4, 6}, {1, 3, 7, 5}, {4, 0, 1, 5},
                                 {2, 6, 7, 3}, {1, 0, 2, 3}, {4, 5, 7, 6}};
    const bool is_cube = type_of(shape) == "cube";
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
    const double radius = read_positive(shape, "radius", 1.0);
    const double scale = uniform_scale(to_world);
    if (!(scale > 0.0)) {
      file_.refuse(shape, "must not be mirrored, sheared or scaled unevenly");
      return {Vec3(0.0), 1.0};
    }
    const xml_node center = parameter(shape, "center");
    return {(center ? read_vector(center, "value") : Vec3(0.0)) * to_world, radius * scale};
  }

  Mesh read_mesh(const xml_node& shape, const M44d& to_world) {
    const xml_node filename = parameter(shape, "filename");
    const std::string path = file_.find(shape, filename.attribute("value").value()).string();
    const std::string text = file_.read_bytes(path);
    if (text.empty()) {
      file_.refuse(filename, path + " cannot be read or is empty");
      return {};
    }
    MeshFile mesh;
    try {
      mesh = (type_of(shape) == "obj" ? read_obj : read_ply)(path, text, to_world);
    } catch (const SceneError& error) {
      file_.refuse(error.what());
      return {};
    }
    constexpr size_t most_faces = 100'000;  // those in one plane are sought pair by pair
    if (mesh.faces.empty()) file_.refuse(path + ": there are no faces");
    if (mesh.faces.size() > most_faces) {
      file_.refuse(fmt::format("{}: has {} faces; supported: up to {}", path, mesh.faces.size(),
                               most_faces));
    }
    if (mesh.folded > 0) {
      file_.note(
          fmt::format("{}: {} faces are concave or cross themselves; the triangles 1-2-3, "
                      "1-3-4, ... of them overlap, and which of these is seen is undefined",
                      path, mesh.folded));
    }
    if (mesh.without_area > 0) {
      file_.note(
          fmt::format("{}: {} faces have no area and are left out", path, mesh.without_area));
    }
    if (read_flag(shape, "face_normals")) return mesh.faces;
    constexpr const char* flat = R"(<boolean name="face_normals" value="true"/>)";
    if (mesh.has_normals && !mesh.normals_are_flat) {
      file_.refuse(shape, fmt::format("{} has normals for smooth shading, which is not supported; "
                                      "add {} to draw it flat",
                                      path, flat));
    } else if (mesh.has_normals && mesh.lacks_normals) {
      file_.note(shape, fmt::format("drawn flat; {} has normals at some corners alone, without {} "
                                    "Mitsuba shades by what it has at the others",
                                    path, flat));
    } else if (!mesh.has_normals && mesh.shares_corners) {
      file_.note(shape, fmt::format("drawn flat; without {} Mitsuba makes up vertex normals and "
                                    "shades smoothly",
                                    flat));
    }
    return mesh.faces;
  }

  Shape read_shape(const xml_node& node) {
    const M44d to_world = read_to_world(node);
    const std::string type = type_of(node);
    Shape shape;
    shape.id = node.attribute("id").as_string(fmt::format("#{}", scene_.shapes.size()).c_str());
    if (type == "sphere") {
      shape.geometry = read_sphere(node, to_world);
    } else {
      const bool is_file = type == "obj" || type == "ply";
      shape.geometry = is_file ? read_mesh(node, to_world) : read_rectangle_or_cube(node, to_world);
    }
    const xml_node emitter = node.child("emitter");
    if (emitter && type_of(emitter) != "area") {
      file_.refuse(emitter, "in a shape; supported: area");
    } else if (emitter) {
      shape.radiance = read_color(emitter, "radiance", 1.0, highest_radiance);
    }
    // Without a BSDF a lamp is black, in Mitsuba too.
    if (emitter) shape.bsdf.reflectance = Rgb(0.0);
    if (const xml_node bsdf = node.child("bsdf")) shape.bsdf = read_bsdf(bsdf);
    if (read_flag(node, "flip_normals")) flip(node, shape);
    return shape;
  }

  // One that is no shape's. Area emitters are there to be referred to.
  void read_emitter(const xml_node& node) {
    if (type_of(node) == "constant") {
      if (scene_.has_sky()) file_.refuse(node, "there is a sky already");
      scene_.sky = read_color(node, "radiance", 1.0, highest_radiance);
    } else if (type_of(node) == "point") {
      const xml_node position = parameter(node, "position");
      if (position && parameter(node, "to_world")) {
        file_.refuse(position, "give either position or to_world");
      }
      const M44d to_world = read_to_world(node);
      scene_.points.push_back({position ? read_vector(position, "value") : row(to_world, 3),
                               read_color(node, "intensity", 1.0, highest_radiance)});
    }
  }

  void flip(const xml_node& node, Shape& shape) {
    if (auto* mesh = std::get_if<Mesh>(&shape.geometry)) {
      for (Polygon& face : *mesh) std::reverse(face.corners.begin(), face.corners.end());
    } else if (shape.bsdf.kind == Bsdf::Kind::dielectric && !shape.is_lamp()) {
      shape.bsdf.ior = 1.0 / shape.bsdf.ior;
    } else if (shape.is_lamp() || !shape.bsdf.two_sided) {
      file_.refuse(parameter(node, "flip_normals"),
                   "a sphere that faces inwards is not supported; if it is no lamp, make its bsdf "
                   "twosided");
    }
  }

  // -- Camera and settings

  int read_image_side(const xml_node& film, const char* name, int missing) {
    const double side = read_number(film, name, missing);
    if (side >= 1 && side <= largest_image_side && side == std::floor(side)) return int(side);
    file_.refuse(parameter(film, name),
                 fmt::format("must be an integer from 1 to {}", largest_image_side));
    return missing;
  }

  Filter read_filter(const xml_node& film) {
    const xml_node node = film.child("rfilter");
    const std::string type = node ? type_of(node) : "gaussian";
    Filter filter;
    if (type == "tent") filter = {Filter::Kind::tent, read_positive(node, "radius", 1.0)};
    if (type == "gaussian") filter = {Filter::Kind::gaussian, read_positive(node, "stddev", 0.5)};
    filter.crosses_border =
        read_flag(film, "sample_border") || read_flag(film, "high_quality_edges");
    if (!node) file_.note(film, "without an rfilter it is gaussian, as in Mitsuba");
    return filter;
  }

  void check_number(const xml_node& parent, const char* name, double wanted) {
    if (read_number(parent, name, wanted) == wanted) return;
    file_.refuse(parameter(parent, name), fmt::format("supported: {}", wanted));
  }

  void read_film(const xml_node& film) {
    Camera& camera = scene_.camera;
    camera.width = read_image_side(film, "width", 768);
    camera.height = read_image_side(film, "height", 576);
    camera.filter = read_filter(film);
    check_number(film, "crop_width", camera.width);
    check_number(film, "crop_height", camera.height);
    check_number(film, "crop_offset_x", 0);
    check_number(film, "crop_offset_y", 0);
    if (type_of(film) == "ldrfilm") file_.note(film, "pictures are linear, as hdrfilm's");
  }

  // "50mm", of a film of 36 by 24 mm.
  double read_focal_length(const xml_node& node) {
    std::string text = node.attribute("value").as_string("50mm");
    if (text.ends_with("mm")) text.resize(text.size() - 2);
    const std::vector<double> numbers = parse_numbers(text);
    if (numbers.size() == 1 && numbers[0] > 0.0) return numbers[0];
    file_.refuse(node, "must be a length such as 50mm");
    return 50.0;
  }

  void read_fov(const xml_node& sensor) {
    Camera& camera = scene_.camera;
    const xml_node fov = parameter(sensor, "fov");
    const xml_node focal_length = parameter(sensor, "focal_length");
    if (fov && focal_length) file_.refuse(focal_length, "give either fov or focal_length");
    camera.fov_axis = Camera::FovAxis::diagonal;
    camera.fov_degrees = 2.0 *
                         std::atan(std::hypot(36.0, 24.0) / 2.0 / read_focal_length(focal_length)) *
                         180.0 / std::numbers::pi;
    if (!fov && !focal_length) {
      file_.note(sensor, fmt::format("without a fov it is {:.5g} degrees along the diagonal, as in "
                                     "Mitsuba",
                                     camera.fov_degrees));
    }
    if (!fov) return;
    camera.fov_degrees = read_number(sensor, "fov", 45.0);
    if (!(camera.fov_degrees > 0.0 && camera.fov_degrees < 180.0)) {
      file_.refuse(fov, "must be more than 0 and less than 180 degrees");
      camera.fov_degrees = 45.0;
    }
    const std::string axis = parameter(sensor, "fov_axis").attribute("value").as_string("x");
    const auto& axes = Camera::fov_axis_names;
    camera.fov_axis = Camera::FovAxis(std::ranges::find(axes, axis) - std::begin(axes));
  }

  // Mitsuba's camera looks along its z; its x points to the left of the image.
  void read_sensor(const xml_node& sensor) {
    Camera& camera = scene_.camera;
    read_film(sensor.child("film"));
    read_fov(sensor);
    check_number(sensor, "principal_point_offset_x", 0);
    check_number(sensor, "principal_point_offset_y", 0);
    const M44d to_world = read_to_world(sensor);
    if (!(std::abs(std::abs(uniform_scale(to_world)) - 1.0) < 1e-5)) {
      file_.refuse(sensor, "must not be scaled or sheared");
      return;
    }
    camera.origin = row(to_world, 3);
    camera.right = -row(to_world, 0).normalized();
    camera.up = row(to_world, 1).normalized();
    camera.forward = row(to_world, 2).normalized();
    if (const xml_node sampler = sensor.child("sampler")) {
      file_.note_no_effect("sampler");
      const double samples = read_number(sampler, "sample_count", 0.0);
      scene_.request.samples_per_pixel = static_cast<int64_t>(std::clamp(samples, 0.0, 1e9));
      if (samples >= 1.0) {
        file_.note(parameter(sampler, "sample_count"), "the default of --spp");
      }
    }
  }

  // What is closer to the camera than the near plane or beyond the far one is not seen in Mitsuba.
  void check_clip_planes(const xml_node& sensor) {
    const auto [nearest, farthest] = depths_in_view(scene_);
    const auto check = [&](const char* name, double missing, double depth, bool cuts) {
      const xml_node node = parameter(sensor, name);
      if (cuts && node) {
        file_.refuse(node, fmt::format("may cut what is seen at a depth of {:.6g}", depth));
      } else if (cuts) {
        file_.note(sensor,
                   fmt::format("Mitsuba's {} of {} may cut what is seen at a depth of {:.6g}", name,
                               missing, depth));
      } else if (node) {
        file_.note_no_effect(name);
      }
    };
    check("near_clip", 0.01, nearest, nearest < read_number(sensor, "near_clip", 0.01));
    check("far_clip", 10000.0, farthest, farthest > read_number(sensor, "far_clip", 10000.0));
  }

  void read_integrator(const xml_node& node) {
    if (!node) return;
    BounceRange& bounces = scene_.request.bounces;
    const xml_node max_depth = parameter(node, "max_depth");
    const double depth = read_number(node, "max_depth", -1.0);  // of edges: 1 is emission alone
    if (read_number(node, "bsdf_samples", 1.0) == 0.0) {
      file_.refuse(parameter(node, "bsdf_samples"), "must be at least 1: mirrors show lamps");
    }
    if (depth != std::floor(depth)) file_.refuse(max_depth, "must be a whole number");
    if (type_of(node) == "direct") {
      bounces.last = 1;
      file_.note(node, "--bounces 0:1 unless told otherwise");
    } else if (depth >= 1.0 && depth < 1e6) {
      bounces.last = static_cast<int>(depth) - 1;
      file_.note(max_depth, fmt::format("--bounces 0:{} unless told otherwise", bounces.last));
    } else if (depth != -1.0 && depth < 1e6) {
      file_.refuse(max_depth, "must be -1 or at least 1");
    }
  }

  SceneFile& file_;
  Scene scene_;
};

}  // namespace

Scene read_scene(const std::filesystem::path& path, FileSource& source) {
  SceneFile file(path, source);
  Scene scene = Reader(file).read();
  file.throw_refusals();
  scene.name = path.stem().string();
  scene.notes = file.notes();
  return scene;
}

}  // namespace plumb
