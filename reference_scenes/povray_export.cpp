#include <fmt/format.h>

#include <string>
#include <variant>
#include <vector>

#include "reference_scenes/exporters.h"

namespace plumb {
namespace {

std::string vector(const Vec3& v) { return fmt::format("<{}, {}, {}>", v.x, v.y, v.z); }

// "first, second, ...".
std::string corner_list(const std::vector<Vec3>& corners) {
  std::string list;
  for (const Vec3& corner : corners) list += (list.empty() ? "" : ", ") + vector(corner);
  return list;
}

std::string sphere(const Sphere& sphere) {
  return fmt::format("{}, {}", vector(sphere.center), sphere.radius);
}

std::string surface(const Shape& shape) {
  if (const auto* ball = std::get_if<Sphere>(&shape.geometry)) {
    return fmt::format("sphere {{ {} Surface() }}\n", sphere(*ball));
  }
  std::string text = "union {\n";
  for (const Polygon& polygon : std::get<Mesh>(shape.geometry)) {
    text += fmt::format("  {}({})\n", polygon.corners.size() == 3 ? "Triangle" : "Quad",
                        corner_list(polygon.corners));
  }
  return text + "  Surface()\n}\n";
}

std::string lamp(const Shape& shape) {
  const std::string radiance = vector(shape.radiance);
  if (const auto* ball = std::get_if<Sphere>(&shape.geometry)) {
    return fmt::format("Sphere_lamp({}, {})\n", sphere(*ball), radiance);
  }
  std::string text;
  for (const Polygon& polygon : std::get<Mesh>(shape.geometry)) {
    const std::vector<Vec3>& corner = polygon.corners;
    text += fmt::format("Rectangle_lamp({}, {})\n", corner_list({corner[0], corner[1], corner[3]}),
                        radiance);
  }
  return text;
}

std::string camera(const Camera& camera) {
  return fmt::format("Camera({}, {},\n       {}, {}, {})\n", vector(camera.origin),
                     vector(camera.forward), vector(camera.right), vector(camera.up),
                     camera.half_width());
}

}  // namespace

std::string povray_scene(const Scene& scene) {
  std::string text = fmt::format(
      "// {}, for POV-Ray 3.7: povray FILE +W{} +H{}\n"
      "#version 3.7;\n#include \"plumbline.inc\"\n\n{}",
      plain_identifier(scene.name), scene.camera.width, scene.camera.height, camera(scene.camera));
  for (const Shape& shape : scene.shapes) {
    const bool diffuse = shape.bsdf.kind == Bsdf::Kind::diffuse;
    text += fmt::format("\n// {}\n{}({}, {})\n{}", plain_identifier(shape.id),
                        diffuse ? "Diffuse" : "Conductor", vector(shape.bsdf.reflectance),
                        shape.bsdf.two_sided ? "yes" : "no", surface(shape));
    if (shape.is_lamp()) text += lamp(shape);
  }
  return text;
}

}  // namespace plumb
