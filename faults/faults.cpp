// SPDX-License-Identifier: Apache-2.0

#include "faults/faults.h"

#include <algorithm>
#include <cmath>

#include "faults/clamp.h"
#include "faults/light_backs.h"
#include "faults/trace_faulty.h"
#include "faults/view.h"
#include "images/srgb.h"

namespace plumb {
namespace {

template <typename Change>
void change_reflectances(Scene& scene, Change change) {
  for (Shape& shape : scene.shapes) {
    for (int c = 0; c < 3; ++c) shape.bsdf.reflectance[c] = change(shape.bsdf.reflectance[c]);
  }
}

void turn_glass_inside_out(Scene& scene) {
  for (Shape& shape : scene.shapes) shape.bsdf.ior = 1.0 / shape.bsdf.ior;
}

// To the right and down, by leaning the camera's axis.
void shift_half_pixels(Camera& camera, double times) {
  const double half_pixel = camera.half_width() / camera.width;
  camera.forward += (camera.right - camera.up) * (half_pixel * times);
}

// The camera's rays go where they went, and its axes tell trace_faulty() how far away they begin,
// in radii of the scene.
void clip_near(Scene& scene, double part) {
  const double depth = look_at(scene).depth_at(part) / scene.radius();
  for (Vec3* axis : {&scene.camera.forward, &scene.camera.right, &scene.camera.up}) *axis *= depth;
}

void take_other_axis(Camera& camera) {
  using enum Camera::FovAxis;
  constexpr Camera::FovAxis others[] = {y, x, x, larger, smaller};
  camera.fov_axis = others[static_cast<size_t>(camera.fov_axis)];
}

void cut_after(double bounces, Settings& settings) {
  constexpr int most = BounceRange{}.last;
  settings.bounces.last = bounces < most ? static_cast<int>(bounces) : most;
}

// Multiplies what lamps of all kinds emit.
void dim(Scene& scene, double factor) {
  for (Shape& shape : scene.shapes) shape.radiance *= factor;
  for (PointLamp& point : scene.points) point.intensity *= factor;
  scene.sky *= factor;
}

// Counted from 1.
void put_out(Scene& scene, int lamp) {
  for (Shape& shape : scene.shapes) {
    if (shape.is_lamp() && --lamp == 0) shape.radiance = Rgb(0.0);
  }
  for (PointLamp& point : scene.points) {
    if (--lamp == 0) point.intensity = Rgb(0.0);
  }
  if (scene.has_sky() && --lamp == 0) scene.sky = Rgb(0.0);
}

void turn_lamps(Scene& scene) {
  for (Shape& shape : scene.shapes) {
    if (!shape.is_lamp()) continue;
    if (auto* faces = std::get_if<Mesh>(&shape.geometry)) {
      for (Polygon& face : *faces) std::reverse(face.corners.begin(), face.corners.end());
    } else {
      shape.radiance = Rgb(0.0);
    }
  }
}

// About the middle of each lamp's corners.
void resize_lamps(Scene& scene, double area) {
  const double size = std::sqrt(area);
  for (Shape& shape : scene.shapes) {
    if (!shape.is_lamp()) continue;
    if (auto* sphere = std::get_if<Sphere>(&shape.geometry)) {
      sphere->radius *= size;
      continue;
    }
    auto& faces = std::get<Mesh>(shape.geometry);
    Vec3 sum(0.0);
    double corners = 0.0;
    for (const Polygon& face : faces) {
      for (const Vec3& corner : face.corners) sum += corner, ++corners;
    }
    const Vec3 middle = sum / corners;
    for (Polygon& face : faces) {
      for (Vec3& corner : face.corners) corner = middle + (corner - middle) * size;
    }
  }
}

void whiten_mirrors(Scene& scene) {
  for (Shape& shape : scene.shapes) {
    if (shape.bsdf.kind == Bsdf::Kind::conductor) shape.bsdf.reflectance = Rgb(1.0);
  }
}

void set_sides(Scene& scene, bool two_sided) {
  for (Shape& shape : scene.shapes) {
    if (shape.bsdf.kind != Bsdf::Kind::dielectric) shape.bsdf.two_sided = two_sided;
  }
}

// A quad that is read comes as the triangles 1-2-3 and 1-3-4.
void split_otherwise(Scene& scene) {
  for (Shape& shape : scene.shapes) {
    auto* faces = std::get_if<Mesh>(&shape.geometry);
    for (size_t i = 0; faces != nullptr && i + 1 < faces->size(); ++i) {
      auto &a = (*faces)[i].corners, &b = (*faces)[i + 1].corners;
      const bool is_quad = a.size() == 3 && b.size() == 3 && a[0] == b[0] && a[2] == b[1];
      if (!is_quad) continue;
      a[2] = b[2];
      b[0] = a[1];
      ++i;
    }
  }
}

}  // namespace

void light_backs(Scene& scene, const std::function<bool(const Shape&)>& wanted) {
  constexpr double gap = 1e-4;  // in sizes of the lamp
  for (size_t i = 0, count = scene.shapes.size(); i < count; ++i) {
    Shape back = scene.shapes[i];
    auto* faces = std::get_if<Mesh>(&back.geometry);
    if (!back.is_lamp() || faces == nullptr || !wanted(back)) continue;
    for (Polygon& face : *faces) {
      const Vec3 shift = face.normal() * (gap * (face.corners[2] - face.corners[0]).length());
      for (Vec3& corner : face.corners) corner -= shift;
      std::reverse(face.corners.begin(), face.corners.end());
    }
    scene.shapes.push_back(back);
  }
}

void plant(Fault fault, Scene& scene, Settings& settings, std::optional<double> number) {
  if (fault == Fault::none || description(fault).site == FaultSite::picture) return;
  const auto& numbers = description(fault).numbers;
  const double n = number.value_or(numbers.empty() ? 0.0 : numbers.front());
  Camera& camera = scene.camera;
  constexpr double gamma = 2.2;
  switch (fault) {
    case Fault::five_bounces:
      return cut_after(number ? n : std::min<double>(settings.bounces.last, n), settings);
    case Fault::gamma_reflectance:
      return change_reflectances(scene, [](double c) { return std::pow(c, 1.0 / gamma); });
    case Fault::srgb_reflectance: return change_reflectances(scene, linear_of_srgb);
    case Fault::half_pixel: return shift_half_pixels(camera, n);
    case Fault::glass_inside_out: return turn_glass_inside_out(scene);
    case Fault::two_sided_lamp: return light_backs(scene, [](const Shape&) { return true; });
    case Fault::fov_axis: return take_other_axis(camera);
    case Fault::gaussian_filter: camera.filter = {Filter::Kind::gaussian, 0.5}; return;
    case Fault::blackman_harris_filter:
      camera.filter = {Filter::Kind::blackman_harris, 1.5};  // Cycles' width is its radius
      return;
    case Fault::lamp_missing: return put_out(scene, static_cast<int>(n));
    case Fault::lamp_flipped: return turn_lamps(scene);
    case Fault::lamp_unseen: settings.bounces.first = std::max(settings.bounces.first, 1); return;
    case Fault::lamp_area: return resize_lamps(scene, n);
    case Fault::white_mirrors: return whiten_mirrors(scene);
    case Fault::one_sided_walls: return set_sides(scene, false);
    case Fault::two_sided_walls: return set_sides(scene, true);
    case Fault::other_diagonal: return split_otherwise(scene);
    case Fault::near_clipped: clip_near(scene, n); break;
    case Fault::clamp_indirect: dim(scene, clamped_at / n); break;  // which spoil() undoes
    case Fault::webgl_demo:
      cut_after(std::min(settings.bounces.last, 5), settings);
      settings.method = Method::nee;
      break;
    default: break;
  }
  settings.fault = fault;
  static constexpr Tracer faulty{.in_float = trace_faulty};
  settings.tracer = &faulty;
}

}  // namespace plumb
