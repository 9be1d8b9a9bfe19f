// SPDX-License-Identifier: Apache-2.0

// Cycles, the path tracer of Blender 3.4 and later, which reads a scene as a Python script.
#include <fmt/ranges.h>

#include <algorithm>
#include <ranges>
#include <string>

#include "other_renderers/export.h"
#include "other_renderers/plumbline_cycles.py.h"

namespace plumb {
namespace {

// Of Cycles' gaussian, exp(-8 (x / width)^2) out to one and a half widths: ours, but for 0.03 %
// where ours ends. 0: it has no such filter.
double gaussian_width(const Filter& filter) {
  constexpr double widest = 10.0;
  const double width = 4.0 * filter.size;
  return filter.kind == Filter::Kind::gaussian && width <= widest ? width : 0.0;
}

std::string filter_note(const Filter& filter) {
  if (gaussian_width(filter) == 0.0) return box_filter_note("Cycles", filter);
  if (filter.crosses_border) return "";
  return "Cycles counts what lies beside the picture for its outermost pixels, the scene doesn't";
}

std::string notes(const Scene& scene) {
  std::string notes = filter_note(scene.camera.filter);
  if (std::ranges::any_of(scene.shapes, [](const Shape& shape) {
        return shape.bsdf.alpha > 0.0 && shape.bsdf.is_metal();
      })) {
    notes += notes.empty() ? "" : "; ";
    notes +=
        "Cycles draws rough metals with what Fresnel's equations reflect at the surface's angle, "
        "not at the microfacets'";
  }
  return notes;
}

std::string tuple(const Vec3& v) { return fmt::format("({}, {}, {})", v.x, v.y, v.z); }

std::string camera_text(const Camera& c) {
  const double filter = gaussian_width(c.filter);
  return fmt::format(R"(    camera=Camera(
        origin={}, forward={}, right={}, up={},
        fov={}, fov_axis="{}", width={}, height={}{}),
)",
                     tuple(c.origin), tuple(c.forward), tuple(c.right), tuple(c.up), c.fov_degrees,
                     Camera::fov_axis_names[size_t(c.fov_axis)], c.width, c.height,
                     filter == 0.0 ? "" : fmt::format(", gaussian_width={}", filter));
}

std::string surface_text(const Bsdf& bsdf) {
  std::string text = fmt::format("{}={}", bsdf.kind == Bsdf::Kind::diffuse ? "diffuse" : "mirror",
                                 tuple(bsdf.reflectance));
  if (bsdf.alpha > 0.0) text += fmt::format(", alpha={}", bsdf.alpha);
  if (bsdf.is_metal()) text += fmt::format(", eta={}, k={}", tuple(bsdf.eta), tuple(bsdf.k));
  if (bsdf.kind == Bsdf::Kind::dielectric) {
    text += fmt::format(", glass={}, transmittance={}", bsdf.ior, tuple(bsdf.transmittance));
  }
  if (bsdf.two_sided) text += ", two_sided=True";
  return text;
}

std::string shape_text(const Shape& shape) {
  std::string surface = surface_text(shape.bsdf);
  if (shape.is_lamp()) surface += fmt::format(", radiance={}", tuple(shape.radiance));

  const std::string name = plain_identifier(shape.id);
  if (const Sphere* sphere = std::get_if<Sphere>(&shape.geometry)) {
    return fmt::format("        Sphere(\"{}\", center={}, radius={}, {}),\n", name,
                       tuple(sphere->center), sphere->radius, surface);
  }
  std::string text = fmt::format("        Mesh(\"{}\", {}, polygons=[\n", name, surface);
  for (const Polygon& polygon : std::get<Mesh>(shape.geometry)) {
    text += fmt::format("            [{}],\n",
                        fmt::join(polygon.corners | std::views::transform(tuple), ", "));
  }
  return text + "        ]),\n";
}

std::string scene_text(const Scene& original) {
  const Scene scene = without_radiance_steps(original);
  std::string shapes, points;
  for (const Shape& shape : scene.shapes) shapes += shape_text(shape);
  for (const PointLamp& point : scene.points) {
    points += fmt::format("({}, {}), ", tuple(point.position), tuple(point.intensity));
  }
  std::string others;
  if (scene.has_sky()) others += fmt::format(", sky={}", tuple(scene.sky));
  if (!points.empty()) others += fmt::format(", points=[{}]", points);
  return fmt::format(R"(# The scene {0}, from the scene file with SHA-1 {1}. To draw it:
#   blender -b --python {0}.py -- -o {0}.exr --spp 256
{4}# Coordinates are the scene file's, colours are linear RGB.
import os
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
try:
    from plumbline_cycles import Camera, Mesh, Sphere, main
except ImportError as error:
    sys.exit(f"{{error}}: plumbline_cycles.py belongs beside this file")

main(
    "{0}",
{2}    shapes=[
{3}    ]{5})
)",
                     plain_identifier(scene.name), scene.hash, camera_text(scene.camera), shapes,
                     comment("# ", notes(scene)), others);
}

std::vector<Run> runs(const Job& job) {
  // Blender looks where PWD says that it is.
  return script_call({"blender", "-b", "--factory-startup", "--python", job.file, "--"}, job);
}

}  // namespace

OtherRenderer cycles() {
  return {
      .word = "cycles",
      .name = "Cycles",
      .software = "Blender",
      .probe = {"blender", "--version"},
      .how_to_install = "Blender is not installed: 'apt-get install blender', or see blender.org",
      .example_setting = "sample_clamp_indirect=10",
      .script_name = "plumbline_cycles.py",
      .script = plumbline_cycles_py,
      .format = SceneFormat{".py", scene_text},
      .drawn_otherwise = notes,
      .runs = runs};
}

}  // namespace plumb
