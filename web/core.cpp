// SPDX-License-Identifier: Apache-2.0

// The renderer as a WebAssembly module: what the page calls. Strings and arrays pass through the
// module's memory. Each worker of the page has a module of its own, which renders its share of
// the pixels: chunks of 64, of which worker k of n takes the k-th, the (k + n)-th and so on.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <functional>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "faults/faults.h"
#include "light_origins/trace_selected.h"
#include "renderer/film.h"
#include "renderer/packed_scene.h"
#include "renderer/render.h"
#include "renderer/trace.h"
#include "scene/surfaces.h"
#include "scene_files/precision.h"
#include "scene_files/scene_reader.h"

namespace plumb {
namespace {

using nlohmann::json;

// One picture in progress.
struct Picture {
  Settings settings;
  LightOrigin origin;
  PackedScene<float> scene;
  Film film;
  int64_t first_pixel;
  int64_t shares;
  std::vector<float> mean{}, variance{};
};

std::map<std::string, std::string> files;
Scene scene;
std::map<int, Picture> pictures;  // by the numbers that the page gives them
std::string answer;

int told(const json& value) {
  answer = value.dump(-1, ' ', false, json::error_handler_t::replace);
  return 0;
}

int failed(const std::string& message) {
  answer = message;
  return 1;
}

json to_json(const Vec3& v) { return {v.x, v.y, v.z}; }

const char* material_of(const Bsdf& bsdf) {
  if (bsdf.kind == Bsdf::Kind::dielectric) return "glass";
  if (bsdf.kind == Bsdf::Kind::conductor) {
    return bsdf.is_metal() || !bsdf.is_mirror() ? "metal" : "steel";
  }
  return "matte";
}

json describe(const Shape& shape) {
  Vec3 low(std::numeric_limits<double>::infinity()), high = -low;
  const auto include = [&](const Vec3& p) {
    for (int i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], p[i]);
      high[i] = std::max(high[i], p[i]);
    }
  };
  size_t faces = 0;  // of a sphere none
  if (const auto* sphere = std::get_if<Sphere>(&shape.geometry)) {
    include(sphere->center - Vec3(sphere->radius));
    include(sphere->center + Vec3(sphere->radius));
  } else {
    const Mesh& mesh = std::get<Mesh>(shape.geometry);
    faces = mesh.size();
    for (const Polygon& face : mesh) {
      for (const Vec3& corner : face.corners) include(corner);
    }
  }
  return {{"id", shape.id},
          {"faces", faces},
          {"low", to_json(low)},
          {"high", to_json(high)},
          {"twoSided", shape.bsdf.two_sided},
          {"material", material_of(shape.bsdf)},
          {"reflectance", to_json(shape.bsdf.reflectance)},
          {"eta", to_json(shape.bsdf.eta)},
          {"k", to_json(shape.bsdf.k)},
          {"alpha", shape.bsdf.alpha},
          {"ior", shape.bsdf.ior},
          {"transmittance", to_json(shape.bsdf.transmittance)},
          {"radiance", to_json(shape.radiance)}};
}

json describe() {
  const Camera& c = scene.camera;
  json shapes = json::array();
  for (const Shape& shape : scene.shapes) shapes.push_back(describe(shape));
  const BounceRange& bounces = scene.request.bounces;
  return {{"camera",
           {{"origin", to_json(c.origin)},
            {"forward", to_json(c.forward)},
            {"right", to_json(c.right)},
            {"up", to_json(c.up)},
            {"halfWidth", c.half_width()},
            {"halfHeight", c.half_height()},
            {"width", c.width},
            {"height", c.height}}},
          {"shapes", shapes},
          {"bounces", {bounces.first, bounces.last}},
          {"notes", scene.notes}};
}

const Picture* find(int picture) {
  const auto found = pictures.find(picture);
  return found == pictures.end() ? nullptr : &found->second;
}

}  // namespace

}  // namespace plumb

#define EXPORT(name) extern "C" __attribute__((export_name(#name)))

using namespace plumb;  // NOLINT(google-build-using-namespace)

EXPORT(allocate) void* allocate(size_t size) { return std::malloc(size); }
EXPORT(release) void release(void* memory) { std::free(memory); }

// The last answer: JSON, or a message after a failure.
EXPORT(answer) const char* last_answer() { return answer.data(); }
EXPORT(answer_size) size_t answer_size() { return answer.size(); }

// Puts a file into memory for the next scene.
EXPORT(add_file) void add_file(const char* name, size_t size, const char* bytes, size_t count) {
  files[std::string(name, size)] = std::string(bytes, count);
}

// Reads a scene file from memory; answers what it describes. After a failure, 1, the scene before
// remains.
EXPORT(load) int load(const char* name, size_t size) {
  try {
    FilesInMemory source(std::exchange(files, {}));
    scene = read_scene(std::string(name, size), source);
    const std::string need = needs_double(scene);
    if (!need.empty()) scene.notes.push_back("drawn in float, which is too coarse for " + need);
    return told(describe());
  } catch (const std::exception& error) {
    return failed(error.what());
  }
}

// Answers the bugs that can be planted, with which the list of faults begins: name and text.
EXPORT(faults) int list_faults() {
  json all = json::array();
  for (const FaultDescription& fault : faults()) {
    if (!fault.is_set_up) all.push_back({fault.name, fault.text});
  }
  return told(all);
}

// Begins a picture of the scene, of which this worker renders its share. `fault` is a number in
// the list of faults, or -1. `way` is LightOrigin's, of the light that came by way of the shapes
// whose ids are the strings of a JSON array; -1: all light.
EXPORT(begin)
int begin(int picture, int width, int height, int method, int sampler, uint32_t seed,
          int first_bounce, int last_bounce, int fault, int way, const char* ids, size_t ids_size,
          int worker, int workers) {
  try {
    Scene changed = scene;
    changed.camera.width = width;
    changed.camera.height = height;
    changed.camera.sees_through_backs = true;
    Settings settings{.method = static_cast<Method>(method),
                      .sampler = static_cast<Sampler>(sampler),
                      .seed = seed,
                      .bounces = {first_bounce, last_bounce}};
    if (fault >= 0) plant(faults().at(static_cast<size_t>(fault)).fault, changed, settings);
    LightOrigin origin;
    if (way >= 0) {
      if (settings.tracer != nullptr) {
        return failed("light by way of some shapes alone can't be drawn with this bug");
      }
      origin = light_origin(scene, static_cast<LightOrigin::Way>(way),
                            json::parse(ids, ids + ids_size).get<std::vector<std::string>>());
    }
    pictures.erase(picture);
    pictures.insert({picture,
                     {.settings = settings,
                      .origin = origin,
                      .scene = PackedScene<float>(changed),
                      .film = Film(width, height),
                      .first_pixel = pixels_at_once * worker,
                      .shares = workers}});
    Picture& begun = pictures.at(picture);
    begun.film.set_brightness(changed.brightness());
    if (way >= 0) select_light(begun.origin, begun.settings);
    return 0;
  } catch (const std::exception& error) {
    return failed(error.what());
  }
}

// Adds samples first <= s < last, after which mean() and variance() are new. Fails where a path
// doesn't end.
EXPORT(render) int render_samples(int picture, double first, double last) {
  Picture& p = pictures.at(picture);
  const SampleRange samples{static_cast<int64_t>(first), static_cast<int64_t>(last)};
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::seconds(2);
  bool is_endless = false;
  const std::function<bool(int64_t)> is_abandoned = [&](int64_t longest) {
    is_endless |= longest > endless_path && Clock::now() > end;
    return is_endless;
  };
  std::atomic<int64_t> next_pixel = p.first_pixel;
  const TraceJob<PackedScene<float>> job{p.scene,    p.settings,   samples, p.film,
                                         next_pixel, is_abandoned, p.shares};
  p.film.begin_pass();
  p.settings.tracer == nullptr ? trace(job) : p.settings.tracer->in_float(job);
  if (is_endless) return failed("a path does not end: every surface that it meets reflects all");
  p.film.end_pass(samples);
  p.mean = p.film.mean();
  p.variance = p.film.variance();
  return 0;
}

// In the layout of Film::mean(); right for this worker's pixels only.
EXPORT(mean) const float* mean(int picture) { return find(picture)->mean.data(); }
EXPORT(variance) const float* variance(int picture) { return find(picture)->variance.data(); }

EXPORT(end) void end(int picture) { pictures.erase(picture); }

// Answers the shape that is seen at a place, each from 0 to 1 from the picture's upper left corner:
// its number and the point, or null.
EXPORT(pick) int pick(double x, double y) {
  const Ray ray{scene.camera.origin,
                scene.camera.direction(x * scene.camera.width, y * scene.camera.height)};
  const auto surfaces = list_surfaces(scene);
  auto [surface, distance] = find_nearest(surfaces, ray, 0.0);
  // Not a one-sided back: the camera looks through those of walls.
  while (surface != nullptr && !surface->shape->bsdf.two_sided &&
         surface->normal(ray.at(distance)).dot(ray.direction) > 0.0) {
    std::tie(surface, distance) = find_nearest(surfaces, ray, distance * (1.0 + 1e-9));
  }
  if (surface == nullptr) return told(nullptr);
  return told({{"shape", surface->shape - scene.shapes.data()},
               {"point", to_json(ray.at(distance))},
               {"normal", to_json(surface->normal(ray.at(distance)))}});
}
