// SPDX-License-Identifier: Apache-2.0

#include "other_renderers/export.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "images/output_file.h"

namespace plumb {

namespace fs = std::filesystem;

namespace {

// On no line of symmetry.
Vec3 some_point(const Surface& surface) {
  if (const Sphere* sphere = surface.sphere()) {
    return sphere->center + Vec3(0.36, 0.48, 0.8) * sphere->radius;
  }
  const auto& c = surface.polygon()->corners;
  return c[0] * 0.57 + c[1] * 0.3 + c[2] * 0.13;
}

double size(const Surface& surface) {
  if (const Sphere* sphere = surface.sphere()) return sphere->radius;
  const auto& c = surface.polygon()->corners;
  return (c[1] - c[0]).length();
}

}  // namespace

Media::Media(const std::vector<Shape>& shapes) {
  for (const Shape& shape : shapes) {
    if (is_glass(shape)) holder_.shapes.push_back(shape);
  }
  surfaces_ = list_surfaces(holder_);
  const Shape* last = nullptr;
  for (const Surface& surface : surfaces_) {
    if (surface.shape != last) targets_.push_back(some_point(surface));
    last = surface.shape;
  }
}

double Media::index_at(const Vec3& point) const {
  std::optional<double> index;
  for (const Vec3& target : targets_) {
    for (const double sign : {1.0, -1.0}) {
      const double seen = index_along({point, (target - point) * sign});
      if (index && std::abs(seen - *index) > 1e-6 * *index) {
        throw std::invalid_argument("there is glass that has two sides, but no inside");
      }
      index = seen;
    }
  }
  return index.value_or(1.0);
}

double Media::index_before(const Shape& shape) const {
  Scene alone;
  alone.shapes = {shape};
  const std::vector<Surface> surfaces = list_surfaces(alone);
  std::optional<double> index;
  const size_t step = std::max<size_t>(1, surfaces.size() / 64);
  for (size_t i = 0; i < surfaces.size(); i += step) {
    const Vec3 point = some_point(surfaces[i]);
    const Vec3 off = surfaces[i].normal(point) * (1e-6 * size(surfaces[i]));
    const double there = index_at(point + off);
    if (std::abs(there - index.value_or(there)) > 1e-6 * there) {
      throw std::invalid_argument(shape.id + " is partly in glass");
    }
    index = there;
  }
  return index.value_or(1.0);
}

double Media::index_along(const Ray& ray) const {
  constexpr double beyond = 1.0 + 1e-9;  // the last one that was met
  double index = 1.0;
  for (const Surface& surface : surfaces_) {
    for (double t = 0.0; std::isfinite(t = surface.intersect(ray, t * beyond));) {
      const double ior = surface.shape->bsdf.ior;
      const bool is_front = surface.normal(ray.at(t)).dot(ray.direction) < 0.0;
      index *= is_front ? 1.0 / ior : ior;
    }
  }
  return index;
}

Scene without_radiance_steps(Scene scene) {
  const Media media(scene.shapes);
  const double here = media.index_at(scene.camera.origin);
  for (Shape& shape : scene.shapes) {
    if (!shape.is_lamp()) continue;
    const double ratio = here / media.index_before(shape);
    shape.radiance *= ratio * ratio;
  }
  scene.sky *= here * here;
  for (PointLamp& point : scene.points) {
    const double ratio = here / media.index_at(point.position);
    point.intensity *= ratio * ratio;
  }
  return scene;
}

fs::path export_scene(const OtherRenderer& renderer, const Scene& scene, const fs::path& file) {
  fs::path script = fs::path(file).replace_filename(renderer.script_name);
  if (script == file) {
    throw std::runtime_error(fmt::format("{}: is the name of its include", file.string()));
  }
  write_file(file, renderer.format->text(scene));
  if (!renderer.script.empty()) write_file(script, renderer.script);
  return script;
}

std::string box_filter_note(const std::string& renderer, const Filter& filter) {
  constexpr const char* names[] = {"box", "tent", "gaussian"};  // as in Filter::Kind
  if (filter.kind == Filter::Kind::box && filter.size == 0.5) return "";
  return fmt::format("{} draws a box filter, the scene asks for {} {}", renderer,
                     names[size_t(filter.kind)], filter.size);
}

std::string comment(const std::string& mark, const std::string& note) {
  return note.empty() ? "" : fmt::format("{}{}\n", mark, note);
}

std::string plain_identifier(const std::string& id) {
  std::string plain = id;
  for (char& c : plain) {
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  }
  return plain;
}

std::vector<Run> script_call(Command command, const Job& job, const Command& more) {
  const auto add = [&](const std::string& option, const std::string& value) {
    command.insert(command.end(), {option, value});
  };
  const ReferenceSettings& settings = job.settings;
  add("-o", picture_name);
  add("--spp", std::to_string(settings.samples_per_pixel));
  add("--seed", std::to_string(job.seed));
  add("--size", fmt::format("{}x{}", job.scene.camera.width, job.scene.camera.height));
  command.insert(command.end(), more.begin(), more.end());
  if (job.most_bounces) add("--bounces", std::to_string(*job.most_bounces));
  if (settings.threads > 0) add("--threads", std::to_string(settings.threads));
  for (const std::string& setting : settings.overrides) add("--set", setting);
  return {{command}};
}

}  // namespace plumb
