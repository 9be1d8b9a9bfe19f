// SPDX-License-Identifier: Apache-2.0

#include "faults/faults.h"

#include <algorithm>
#include <cmath>

#include "faults/trace_faulty.h"

namespace plumb {
namespace {

void encode_reflectances(Scene& scene) {
  constexpr double gamma = 2.2;
  for (Shape& shape : scene.shapes) {
    for (int c = 0; c < 3; ++c) {
      shape.bsdf.reflectance[c] = std::pow(shape.bsdf.reflectance[c], 1.0 / gamma);
    }
  }
}

// Puts a lamp that faces the other way behind each, too close for light to get between them.
void light_backs(Scene& scene) {
  constexpr double gap = 1e-4;  // in sizes of the lamp
  for (size_t i = 0, count = scene.shapes.size(); i < count; ++i) {
    Shape back = scene.shapes[i];
    auto* faces = std::get_if<Mesh>(&back.geometry);
    if (!back.is_lamp() || faces == nullptr) continue;
    for (Polygon& face : *faces) {
      const Vec3 shift = face.normal() * (gap * (face.corners[2] - face.corners[0]).length());
      for (Vec3& corner : face.corners) corner -= shift;
      std::reverse(face.corners.begin(), face.corners.end());
    }
    scene.shapes.push_back(back);
  }
}

void turn_glass_inside_out(Scene& scene) {
  for (Shape& shape : scene.shapes) shape.bsdf.ior = 1.0 / shape.bsdf.ior;
}

// To the right and down, by leaning the camera's axis.
void shift_half_a_pixel(Camera& camera) {
  const double half_pixel = camera.half_width() / camera.width;
  camera.forward += (camera.right - camera.up) * half_pixel;
}

void cut_at_five_bounces(Settings& settings) {
  settings.bounces.last = std::min(settings.bounces.last, 5);
}

}  // namespace

const std::vector<FaultDescription>& faults() {
  static const std::vector<FaultDescription> all{
      {"emitter-cosine", Fault::emitter_cosine, "the lamp's cosine is forgotten"},
      {"inverse-pi", Fault::inverse_pi, "1/pi is forgotten where lamps are sampled"},
      {"uniform-directions", Fault::uniform_directions,
       "uniform directions, weighted as by cosine"},
      {"five-bounces", Fault::five_bounces, "paths are cut after five bounces"},
      {"roulette-weight", Fault::roulette_weight, "Russian roulette without its weight"},
      {"clamp-indirect", Fault::clamp_indirect, "contributions of indirect light clamped at 10"},
      {"two-sided-lamp", Fault::two_sided_lamp, "lamps shine on both sides"},
      {"half-lamp-area", Fault::half_lamp_area, "the area of sampled lamps is off by its half"},
      {"one-sided-mis", Fault::one_sided_mis, "only light that is met by chance is weighted"},
      {"gamma-reflectance", Fault::gamma_reflectance, "reflectances are gamma-encoded"},
      {"half-pixel", Fault::half_pixel, "the camera is half a pixel aside and down"},
      {"tangent-frame", Fault::tangent_frame, "the tangents are not normalised"},
      {"webgl-random", Fault::webgl_random, "the random numbers of WebGL demos"},
      {"webgl-demo", Fault::webgl_demo, "the shading of such a demo, with its random numbers"},
      {"n-squared", Fault::n_squared, "radiance in glass is not n^2 times that in air", true},
      {"fresnel-ignored", Fault::fresnel_ignored, "glass reflects only where nothing goes through",
       true},
      {"glass-inside-out", Fault::glass_inside_out, "glass and the air around it are swapped",
       true},
      {"schlick", Fault::schlick, "Schlick's approximation for what glass reflects", true},
      {"total-reflection-black", Fault::total_reflection_black, "total reflection is lost", true}};
  return all;
}

void plant(Fault fault, Scene& scene, Settings& settings) {
  switch (fault) {
    case Fault::none: return;
    case Fault::five_bounces: return cut_at_five_bounces(settings);
    case Fault::gamma_reflectance: return encode_reflectances(scene);
    case Fault::half_pixel: return shift_half_a_pixel(scene.camera);
    case Fault::glass_inside_out: return turn_glass_inside_out(scene);
    case Fault::two_sided_lamp: return light_backs(scene);
    case Fault::webgl_demo:
      cut_at_five_bounces(settings);
      settings.method = Method::nee;
      [[fallthrough]];
    default: settings.fault = fault; settings.faulty_tracer = trace_faulty;
  }
}

}  // namespace plumb
