// SPDX-License-Identifier: Apache-2.0

#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <fmt/format.h>

#include <array>
#include <optional>
#include <stdexcept>
#include <tuple>
#include <variant>

#include "cli/film_image.h"
#include "cli/names.h"
#include "cli/words.h"
#include "python/bindings.h"
#include "scene_files/region_mask.h"
#include "scene_files/scene_reader.h"

namespace plumb::python {
namespace {

using Triple = std::array<double, 3>;
Triple triple(const Vec3& v) { return {v.x, v.y, v.z}; }

constexpr const char* bsdf_names[] = {"diffuse", "conductor", "dielectric"};

std::vector<std::vector<Triple>> faces(const Shape& shape) {
  std::vector<std::vector<Triple>> all;
  const auto* mesh = std::get_if<Mesh>(&shape.geometry);
  if (mesh == nullptr) return all;
  for (const Polygon& polygon : *mesh) {
    all.emplace_back();
    for (const Vec3& corner : polygon.corners) all.back().push_back(triple(corner));
  }
  return all;
}

std::optional<std::pair<Triple, double>> sphere(const Shape& shape) {
  const auto* ball = std::get_if<Sphere>(&shape.geometry);
  if (ball == nullptr) return {};
  return std::pair(triple(ball->center), ball->radius);
}

void bind_shapes(nb::module_& module) {
  nb::class_<Shape>(module, "Shape")
      .def_ro("id", &Shape::id)
      .def_prop_ro("faces", faces)
      .def_prop_ro("sphere", sphere)
      .def_prop_ro("bsdf", [](const Shape& s) { return bsdf_names[size_t(s.bsdf.kind)]; })
      .def_prop_ro("reflectance", [](const Shape& s) { return triple(s.bsdf.reflectance); })
      .def_prop_ro("transmittance", [](const Shape& s) { return triple(s.bsdf.transmittance); })
      .def_prop_ro("ior", [](const Shape& s) { return s.bsdf.ior; })
      .def_prop_ro("alpha", [](const Shape& s) { return s.bsdf.alpha; })
      .def_prop_ro("two_sided", [](const Shape& s) { return s.bsdf.two_sided; })
      .def_prop_ro("radiance", [](const Shape& s) { return triple(s.radiance); })
      .def_prop_ro("is_lamp", &Shape::is_lamp)
      .def("__repr__", [](const Shape& s) {
        return fmt::format("<plumbline.Shape {}: {}{}>", s.id, bsdf_names[size_t(s.bsdf.kind)],
                           s.is_lamp() ? ", a lamp" : "");
      });
  nb::class_<Camera>(module, "Camera")
      .def_prop_ro("origin", [](const Camera& c) { return triple(c.origin); })
      .def_prop_ro("forward", [](const Camera& c) { return triple(c.forward); })
      .def_prop_ro("right", [](const Camera& c) { return triple(c.right); })
      .def_prop_ro("up", [](const Camera& c) { return triple(c.up); })
      .def_ro("fov_degrees", &Camera::fov_degrees)
      .def_prop_ro("fov_axis",
                   [](const Camera& c) { return Camera::fov_axis_names[size_t(c.fov_axis)]; })
      .def_ro("width", &Camera::width)
      .def_ro("height", &Camera::height)
      .def("__repr__", [](const Camera& c) {
        return fmt::format("<plumbline.Camera {}x{} at {} {} {}, fov {} of {}>", c.width, c.height,
                           c.origin.x, c.origin.y, c.origin.z, c.fov_degrees,
                           Camera::fov_axis_names[size_t(c.fov_axis)]);
      });
}

Scene load(const std::string& file) {
  return cli::load_scene({.file = file, .size = {}, .bounces = {}});
}

// The scene with the size that the words ask for, and with the bounces.
template <typename Options>
Scene adjusted(const Scene& scene, const Options& options) {
  Scene own = scene;
  cli::adjust(own, options.scene);
  return own;
}

using Labels = nb::ndarray<nb::numpy, const int, nb::ndim<2>>;

// The names of the regions, their numbers for each pixel, where these lie in what picture (x, y,
// and the picture's width and height), and the mask as a picture. The words say size and crop.
std::tuple<Words, Labels, std::array<int, 4>, Picture> mask(const Scene& scene,
                                                            const std::string& kind,
                                                            const Words& words) {
  const cli::RenderOptions options = cli::parse_render_options(words);
  const Scene own = adjusted(scene, options);
  const Window window = cli::window_of(options.crop, own.camera);
  auto* found = new RegionMask(region_mask(own, one_of(region_words)(kind), window));
  const nb::capsule owner(found, [](void* p) noexcept { delete static_cast<RegionMask*>(p); });
  return {found->names,
          Labels(found->regions.data(), {size_t(window.height), size_t(window.width)}, owner),
          {window.x, window.y, own.camera.width, own.camera.height},
          to_picture("mask", to_image(*found, window, own.camera))};
}

std::pair<Picture, std::string> render_scene(const Scene& scene, const Words& words,
                                             const nb::object& progress) {
  const cli::RenderOptions options = cli::parse_render_options(words);
  const Scene own = adjusted(scene, options);
  return watched(progress, [&](Watch& watch) {
    watch.show("first pass");
    const auto show = [&](const Progress& p) { watch.show(cli::to_text(p)); };
    cli::Rendering drawn = cli::draw(own, options, show, watch.stop);
    const std::string unfinished = why_unfinished(drawn.cost);
    if (!unfinished.empty()) cli::say(unfinished);
    if (!drawn.image) throw std::runtime_error(cli::why_no_picture(drawn));
    std::string line = cli::summary(own, drawn);
    return std::pair(to_picture("picture", std::move(*drawn.image)), std::move(line));
  });
}

std::pair<Picture, std::string> radiosity_of(const Scene& scene, const Words& words,
                                             const nb::object& progress) {
  const cli::RadiosityOptions options = cli::parse_radiosity_options(words);
  const Scene own = adjusted(scene, options);
  return watched(progress, [&](Watch& watch) {
    cli::RadiosityDrawing drawn = cli::draw(
        own, options, {[&](const std::string& phase) { watch.show(phase); }, &watch.stop});
    if (!drawn.image) throw std::runtime_error(drawn.why_ended);
    if (!drawn.why_ended.empty()) cli::say(drawn.why_ended);
    return std::pair(to_picture("picture", std::move(*drawn.image)), std::move(drawn.summary));
  });
}

}  // namespace

void bind_scenes(nb::module_& module) {
  bind_shapes(module);
  nb::class_<Scene>(module, "Scene")
      .def_ro("name", &Scene::name)
      .def_ro("hash", &Scene::hash)
      .def_ro("notes", &Scene::notes)
      .def_ro("camera", &Scene::camera)
      .def_ro("shapes", &Scene::shapes)
      .def_prop_ro("sky", [](const Scene& s) { return triple(s.sky); });
  module.def("load", load, nb::arg("file"), nb::call_guard<nb::gil_scoped_release>());
  module.def("mask", mask, nb::arg("scene"), nb::arg("kind"), nb::arg("words"));
  module.def("render", render_scene, nb::arg("scene"), nb::arg("words"),
             nb::arg("progress").none());
  module.def("radiosity", radiosity_of, nb::arg("scene"), nb::arg("words"),
             nb::arg("progress").none());
}

}  // namespace plumb::python
