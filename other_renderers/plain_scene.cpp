// SPDX-License-Identifier: Apache-2.0

#include "other_renderers/plain_scene.h"

#include <nlohmann/json.hpp>

namespace plumb {
namespace {

using Json = nlohmann::ordered_json;

Json list(const Vec3& v) { return {v.x, v.y, v.z}; }

Json camera(const Camera& c) {
  const Vec3 back = -c.forward;
  Json matrix = Json::array();
  for (int i = 0; i < 3; ++i) matrix.push_back({c.right[i], c.up[i], back[i], c.origin[i]});
  matrix.push_back({0, 0, 0, 1});
  const auto ray = [&](int x, int y) { return list(c.direction(x, y).normalized()); };
  constexpr const char* filters[] = {"box", "tent", "gaussian"};  // as in Filter::Kind
  return {{"width", c.width},
          {"height", c.height},
          {"camera_to_world", matrix},
          {"half_width", c.half_width()},
          {"half_height", c.half_height()},
          {"corner_rays",
           {{"top_left", ray(0, 0)},
            {"top_right", ray(c.width, 0)},
            {"bottom_left", ray(0, c.height)},
            {"bottom_right", ray(c.width, c.height)}}},
          {"filter", {{"kind", filters[size_t(c.filter.kind)]}, {"size", c.filter.size}}}};
}

Json material(const Bsdf& bsdf) {
  Json json;
  switch (bsdf.kind) {
    case Bsdf::Kind::diffuse:
      json = {{"kind", "matte"}, {"reflectance", list(bsdf.reflectance)}};
      break;
    case Bsdf::Kind::conductor:
      json = {{"kind", "metal"}, {"reflectance", list(bsdf.reflectance)}, {"alpha", bsdf.alpha}};
      if (bsdf.is_metal()) {
        json["eta"] = list(bsdf.eta);
        json["k"] = list(bsdf.k);
      }
      break;
    case Bsdf::Kind::dielectric:
      json = {{"kind", "glass"},
              {"ior", bsdf.ior},
              {"reflectance", list(bsdf.reflectance)},
              {"transmittance", list(bsdf.transmittance)}};
      break;
  }
  json["two_sided"] = bsdf.two_sided;
  return json;
}

Json triangles(const Mesh& mesh) {
  Json triangles = Json::array();
  for (const Polygon& polygon : mesh) {
    for (size_t i = 2; i < polygon.corners.size(); ++i) {
      triangles.push_back(
          {list(polygon.corners[0]), list(polygon.corners[i - 1]), list(polygon.corners[i])});
    }
  }
  return triangles;
}

Json shape(const Shape& shape) {
  Json json{{"id", shape.id}, {"material", material(shape.bsdf)}};
  if (shape.is_lamp()) json["radiance"] = list(shape.radiance);
  if (const Sphere* sphere = std::get_if<Sphere>(&shape.geometry)) {
    json["sphere"] = {{"center", list(sphere->center)}, {"radius", sphere->radius}};
  } else {
    json["triangles"] = triangles(std::get<Mesh>(shape.geometry));
  }
  return json;
}

}  // namespace

std::string plain_scene(const Scene& scene) {
  Json json{{"name", scene.name}, {"hash", scene.hash}, {"camera", camera(scene.camera)}};
  json["shapes"] = Json::array();
  for (const Shape& s : scene.shapes) json["shapes"].push_back(shape(s));
  json["points"] = Json::array();
  for (const PointLamp& point : scene.points) {
    json["points"].push_back(
        {{"position", list(point.position)}, {"intensity", list(point.intensity)}});
  }
  json["sky"] = list(scene.sky);
  return json.dump(1) + "\n";
}

}  // namespace plumb
