// SPDX-License-Identifier: Apache-2.0

// Radiance that is known exactly, for every method, sampler and precision.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include "scene/surfaces.h"
#include "tests/closed_forms.h"
#include "tests/test_scenes.h"

namespace plumb::test {
namespace {

constexpr double pi = std::numbers::pi;

// Irradiance at p, facing n, from a polygon of radiance 1 that is all above p's horizon: Lambert
// 1760, half the sum over the edges of the angle they are seen at times the normal's component
// along the edge's plane. Corners are clockwise seen from p.
double lambert(const std::vector<Vec3>& corners, const Vec3& p, const Vec3& n) {
  double sum = 0.0;
  for (size_t i = 0; i < corners.size(); ++i) {
    const Vec3 a = corners[i] - p;
    const Vec3 b = corners[(i + 1) % corners.size()] - p;
    const Vec3 normal = a.cross(b);
    sum += std::atan2(normal.length(), a.dot(b)) * normal.normalized().dot(n);
  }
  return std::abs(sum) / 2.0;
}

// A point on a wall, lit by a polygon of radiance 1 that faces down. Seen from in front. The wall
// may itself be a lamp, on this side or the other.
Case polygon_lamp(const std::string& name, const std::vector<Vec3>& lamp, const Vec3& point,
                  const Vec3& normal, double front = 0.0, double back = 0.0) {
  constexpr double albedo = 0.75;
  const Vec3 side = (std::abs(normal.y) < 0.5 ? Vec3(0, 1, 0) : Vec3(0, 0, 1)).cross(normal);
  const Vec3 up = normal.cross(side);
  Scene scene;
  Shape wall = parallelogram(point - side * 0.25 - up * 0.25, side * 0.5, up * 0.5,
                             diffuse(albedo, true), front + back);
  auto& corners = std::get<Mesh>(wall.geometry)[0].corners;
  if (back > 0.0) std::reverse(corners.begin(), corners.end());
  Mesh faces{{lamp}};
  if (lamp.size() > 4) {
    faces = {{{lamp[0], lamp[1], lamp[2]}}, {{lamp[0], lamp[2], lamp[3], lamp[4]}}};
  }
  scene.shapes = {wall, {"lamp", faces, diffuse(0.0), Rgb(1.0)}};
  scene.camera = camera(point + normal * 0.02 + side * 0.4 - up * 0.1, point, pinpoint);
  return {name, scene, albedo / pi * lambert(lamp, point, normal), {1, 1}};
}

Case rectangle_lamp(const std::string& name, const Vec3& corner, const Vec3& x, const Vec3& y,
                    const Vec3& point, const Vec3& normal) {
  return polygon_lamp(name, {corner, corner + x, corner + x + y, corner + y}, point, normal);
}

std::vector<Case> rectangle_lamps() {
  const Vec3 x(1, 0, 0);
  const Vec3 z(0, 0, 1);
  return {
      rectangle_lamp("below", {-0.5, 2, -0.5}, x, z, {0.1, 0, 0.2}, {0, 1, 0}),
      rectangle_lamp("aside", {0.5, 2, -1.5}, x, z, {0, 0, 0}, {0, 1, 0}),
      rectangle_lamp("tilted", {1.5, 2, -0.5}, x, z, {0, 0, 0}, Vec3(0.6, 0.8, 0)),
      rectangle_lamp("large_and_near", {-2, 0.2, -2}, x * 4, z * 4, {0.3, 0, 0.1}, {0, 1, 0}),
      // A wall beside the lamp, 3 % and 0.5 % of the lamp's size below its plane.
      rectangle_lamp("grazing", {-0.5, 0.03, 0.1}, x, z, {0.1, 0, 0}, {0, 0, 1}),
      rectangle_lamp("more_grazing", {-2, 0.005, 0.02}, x * 4, z, {0.1, 0, 0}, {0, 0, 1}),
      // The Cornell box's back wall, 68.3 and 8.3 units below the lamp's plane; units are halved
      // lamp depths.
      rectangle_lamp("cornell_480", {-65 / 52.5, 68.3 / 52.5, 227.2 / 52.5}, x * (130 / 52.5),
                     z * 2, {0, 0, 0}, {0, 0, 1}),
      rectangle_lamp("cornell_540", {-65 / 52.5, 8.3 / 52.5, 227.2 / 52.5}, x * (130 / 52.5), z * 2,
                     {0, 0, 0}, {0, 0, 1}),
  };
}

std::vector<Case> polygon_lamps() {
  const Vec3 up(0, 1, 0);
  const std::vector<Vec3> triangle{{-0.5, 1, -0.4}, {0.6, 1, -0.2}, {0.1, 1, 0.7}};
  const std::vector<Vec3> trapezium{
      {-0.9, 0.7, -0.6}, {0.9, 0.7, -0.6}, {0.3, 0.7, 0.8}, {-0.2, 0.7, 0.8}};
  const std::vector<Vec3> pentagon{
      {-0.6, 1.2, -0.6}, {0.6, 1.2, -0.6}, {0.8, 1.2, 0.3}, {0, 1.2, 0.9}, {-0.8, 1.2, 0.3}};
  const Vec3 aslant(0.6, 0.8, 0);
  Case tilted_triangle = polygon_lamp("triangle_tilted", triangle, {0.1, 0, 0.2}, up);
  tilted_triangle.scene = tilted(tilted_triangle.scene);
  return {
      polygon_lamp("triangle", triangle, {0.1, 0, 0.2}, up), tilted_triangle,
      polygon_lamp("triangle_near", {{-3, 0.2, -2}, {3, 0.2, -2}, {0, 0.2, 4}}, {0.3, 0, 0.1}, up),
      polygon_lamp("triangle_far", {{-0.6, 5, -0.4}, {0.6, 5, -0.4}, {0, 5, 0.8}}, {0, 0, 0}, up),
      // Beside the triangle's edge, 3 % of its size below its plane.
      polygon_lamp("triangle_grazing", {{-0.5, 0.03, 0.1}, {0.5, 0.03, 0.1}, {0, 0.03, 1.1}},
                   {0.1, 0, 0}, {0, 0, 1}),
      polygon_lamp("trapezium", trapezium, {0.1, 0, 0.2}, up),
      polygon_lamp("pentagon", pentagon, {0.1, 0, 0.2}, aslant),
      polygon_lamp("onto_a_lamp", triangle, {0.1, 0, 0.2}, up, 3.0),
      polygon_lamp("onto_a_lamps_back", trapezium, {0.1, 0, 0.2}, aslant, 0.0, 3.0)};
}

// E = pi L sin^2(theta) cos(tilt): the whole sphere is above the horizon.
Case sphere_lamp(const std::string& name, double radius, double distance, double tilt) {
  constexpr double albedo = 0.75;
  Scene scene;
  scene.shapes = {
      parallelogram({-0.5, 0, -0.5}, {0, 0, 1}, {1, 0, 0}, diffuse(albedo)),
      sphere(Vec3(std::sin(tilt), std::cos(tilt), 0) * distance, radius, diffuse(0.0), 1.0)};
  scene.camera = camera({-0.4, 0.03, 0.05}, {0, 0, 0}, pinpoint);
  const double sine = radius / distance;
  return {name, scene, albedo * sine * sine * std::cos(tilt), {1, 1}};
}

// A point that lamps of all kinds light, none before another, each as if it were alone. The
// brightest of all turns its back.
Case lamps_of_all_kinds(const std::string& name, bool is_tilted) {
  const Vec3 x(1, 0, 0), z(0, 0, 1), up(0, 1, 0), point(0, 0, 0);
  const std::vector<Vec3> triangle{{-0.5, 1, -0.4}, {0.6, 1, -0.2}, {0.1, 1, 0.7}};
  Case c = polygon_lamp(name, triangle, point, up);
  const Case alone = rectangle_lamp("", {1.5, 2, -0.5}, x, z, point, up);
  c.scene.shapes.push_back(parallelogram({1.5, 2, -0.5}, x, z, diffuse(0.0), 3.0));
  const Case round = sphere_lamp("", 0.2, 1.5, -0.9);
  c.scene.shapes.push_back(round.scene.shapes.back());
  c.scene.shapes.back().radiance = Rgb(5.0);
  c.scene.shapes.push_back(parallelogram({-0.5, 1, 2}, z, x, diffuse(0.0), 50.0));
  c.radiance += 3.0 * alone.radiance + 5.0 * round.radiance;
  if (is_tilted) c.scene = tilted(c.scene);
  return c;
}

// Every wall emits 1 and reflects a: radiance is 1 + a + a^2 + ... = 1 / (1 - a) everywhere, and a
// perfect mirror in the room shows nothing else.
Case furnace(const std::string& name, double albedo, bool with_mirror) {
  Scene scene;
  scene.shapes = room({-1, -1, -1}, {1, 1.5, 1}, diffuse(albedo), 1.0);
  if (with_mirror) scene.shapes.push_back(sphere({0.2, -0.3, 0.1}, 0.5, mirror(1.0)));
  scene.camera = camera({-0.7, 0.6, -0.8}, {0.2, -0.2, 0.1}, 60.0);
  return {name, scene, 1.0 / (1.0 - albedo), {}};
}

// The same with walls of triangles, and in it lamps of all kinds that reflect as much and emit as
// much: nothing of them is seen. Also tilted, because rounding is not in a world of right angles.
Case crowded_furnace(const std::string& name, double albedo, bool is_tilted) {
  Case c = furnace(name, albedo, true);
  const auto walls = c.scene.shapes;
  c.scene.shapes.clear();
  for (const Shape& wall : walls) {
    const auto* mesh = std::get_if<Mesh>(&wall.geometry);
    if (mesh == nullptr) {
      c.scene.shapes.push_back(wall);
      continue;
    }
    const auto& corners = mesh->front().corners;
    c.scene.shapes.push_back(polygon({corners[0], corners[1], corners[2]}, wall.bsdf, 1.0));
    c.scene.shapes.push_back(polygon({corners[0], corners[2], corners[3]}, wall.bsdf, 1.0));
  }
  const Bsdf bsdf = diffuse(albedo);
  c.scene.shapes.push_back(sphere({-0.6, 1.0, 0.5}, 0.3, bsdf, 1.0));
  c.scene.shapes.push_back(icosphere({0.6, 0.9, 0.5}, 0.3, 0, bsdf, 1.0));
  // A cube that stands on the floor, and one that touches it.
  for (const Vec3& low : {Vec3(-0.9, -1, 0.4), Vec3(-0.5, -1, 0.4)}) {
    for (Shape& side : room(low, low + Vec3(0.4, 0.5, 0.4), bsdf, 1.0)) {
      auto& face = std::get<Mesh>(side.geometry)[0];
      std::reverse(face.corners.begin(), face.corners.end());
      c.scene.shapes.push_back(side);
    }
  }
  if (is_tilted) c.scene = tilted(c.scene);
  c.patience = 5.0;  // between the cubes lamps touch
  return c;
}

// A plate that emits 1 above a diffuse one of the same size: the mean radiance over the lower plate
// is albedo times the form factor of two equal parallel rectangles. The camera sees the lower plate
// exactly, and a pinhole camera in front of a plate samples its area evenly.
Case facing_plates() {
  constexpr double albedo = 0.75;
  const double x = 1.5;  // sides over distance
  const double y = 1.5;
  Scene scene;
  scene.shapes = {parallelogram({-x / 2, 0, -y / 2}, {0, 0, y}, {x, 0, 0}, diffuse(albedo)),
                  parallelogram({-x / 2, 1, -y / 2}, {x, 0, 0}, {0, 0, y}, diffuse(0.0), 1.0)};
  scene.camera = camera({0, 0.9, 0}, {0, 0, 0}, 2.0 * std::atan(x / 2 / 0.9) * 180.0 / pi);
  const double rx = std::sqrt(1 + x * x);
  const double ry = std::sqrt(1 + y * y);
  const double factor =
      2 / (pi * x * y) *
      (std::log(rx * ry / std::sqrt(1 + x * x + y * y)) + x * ry * std::atan(x / ry) +
       y * rx * std::atan(y / rx) - x * std::atan(x) - y * std::atan(y));
  return {"facing_plates", scene, albedo * factor, {1, 1}};
}

// A lamp of radius r in the middle of a white sphere of radius R, with the albedos b and a. All of
// the sphere is lit the same, and sees the lamp under f = (r / R)^2 of its hemisphere, and the lamp
// sees nothing but the sphere, so w = a (f (1 + b w) + (1 - f) w): w = a f / (1 - a (1 - f + f b)).
Case integrating_sphere(const std::string& name, double lamp_albedo, bool two_sided) {
  constexpr double albedo = 0.8;
  Scene scene;
  scene.shapes = {sphere({0, 0, 0}, 2.0, diffuse(albedo, true)),
                  sphere({0, 0, 0}, 0.5, diffuse(lamp_albedo, two_sided), 1.0)};
  scene.camera = camera({0.9, 0.3, -0.8}, {1.8, 0.2, -1}, 30.0);
  const double f = 0.25 * 0.25;
  return {name, scene, albedo * f / (1 - albedo * (1 - f + f * lamp_albedo)), {}};
}

std::vector<Case> cases() {
  std::vector<Case> all = rectangle_lamps();
  for (const Case& c : polygon_lamps()) all.push_back(c);
  all.push_back(sphere_lamp("sphere_above", 0.5, 2.0, 0.0));
  all.push_back(sphere_lamp("sphere_aslant", 0.5, 1.2, 1.0));
  all.push_back(sphere_lamp("sphere_near", 1.0, 1.02, 0.1));
  all.push_back(lamps_of_all_kinds("lamps_of_all_kinds", false));
  all.push_back(lamps_of_all_kinds("lamps_of_all_kinds_tilted", true));
  all.push_back(furnace("furnace_50", 0.5, false));
  all.push_back(furnace("furnace_95", 0.95, false));
  all.push_back(furnace("furnace_80_with_mirror", 0.8, true));
  all.push_back(facing_plates());
  all.push_back(integrating_sphere("integrating_sphere", 0.0, false));
  all.push_back(integrating_sphere("integrating_sphere_with_white_lamp", 0.9, true));
  all.push_back(crowded_furnace("crowded_furnace", 0.8, false));
  all.push_back(crowded_furnace("crowded_furnace_tilted", 0.6, true));
  return all;
}

class ClosedForm : public testing::TestWithParam<std::tuple<Combination, int>> {};

TEST_P(ClosedForm, IsMetWithinFourStandardErrors) {
  const auto& [combination, number] = GetParam();
  const Method method = std::get<Method>(combination);
  const bool is_sampled = method == Method::nee || method == Method::mis;
  const double wanted = is_sampled ? 2e-4 : method == Method::plain ? 3e-3 : 1e-3;
  expect_met(cases()[size_t(number)], combination, wanted, 1e-6);
}

std::string case_name_of(const testing::TestParamInfo<ClosedForm::ParamType>& info) {
  const auto& [combination, number] = info.param;
  return name_of(combination) + cases()[size_t(number)].name;
}

INSTANTIATE_TEST_SUITE_P(All, ClosedForm,
                         testing::Combine(all_combinations,
                                          testing::Range(0, static_cast<int>(cases().size()))),
                         case_name_of);

INSTANTIATE_TEST_SUITE_P(Plain, ClosedForm,
                         testing::Combine(plain_combination,
                                          testing::Range(0, static_cast<int>(cases().size()))),
                         case_name_of);

// Light that comes by way of one mirror to a point of albedo 0.75: its radiance there in each
// channel, and that of the light that comes straight from the lamps.
struct MirrorCase {
  std::string name;
  Scene scene;
  Vec3 point, normal;
  Rgb by_mirror{0.0};
  Rgb direct{0.0};
  bool is_solved = true;  // else both are left to brute force
};

constexpr double wall_albedo = 0.75;

// What a ray from the point meets after so many reflections by mirrors.
Rgb seen_after(int reflections, const std::vector<Surface>& surfaces, Ray ray) {
  Rgb weight(1.0);
  for (;; --reflections) {
    const auto [surface, distance] = find_nearest(surfaces, ray, 1e-9);
    if (surface == nullptr) return Rgb(0.0);
    const Vec3 normal = surface->normal(ray.at(distance));
    const bool is_front = normal.dot(ray.direction) < 0.0;
    const Bsdf& bsdf = surface->shape->bsdf;
    if (reflections == 0) return is_front ? weight * surface->shape->radiance : Rgb(0.0);
    if (bsdf.kind == Bsdf::Kind::diffuse || !(is_front || bsdf.two_sided)) return Rgb(0.0);
    weight *= bsdf.reflectance;
    ray = {ray.at(distance), ray.direction - normal * (2.0 * normal.dot(ray.direction))};
  }
}

// Radiance of the point by brute force. Directions in proportion to their cosine are even in the
// unit disc on the wall; along each of many lines across it what is seen changes at few points,
// which bisection finds.
Rgb by_directions(const MirrorCase& c, int reflections) {
  constexpr int lines = 2000, steps = 400;
  const std::vector<Surface> surfaces = list_surfaces(c.scene);
  const Vec3 x = c.normal.cross(Vec3(0.28, 0.6, 0.75)).normalized();  // aslant to all edges
  const Vec3 y = c.normal.cross(x);
  Rgb sum(0.0);
  for (int line = 0; line < lines; ++line) {
    const double v = (2.0 * line + 1.0) / lines - 1.0;
    const double end = std::sqrt(1.0 - v * v);
    const auto seen = [&](double u) {
      const double cosine = std::sqrt(std::max(0.0, 1.0 - u * u - v * v));
      return seen_after(reflections, surfaces, {c.point, x * u + y * v + c.normal * cosine});
    };
    double begin = -end, last = -end;
    Rgb value = seen(last);
    for (int i = 1; i <= steps; ++i) {
      const double next = end * (2.0 * i / steps - 1.0);
      const Rgb next_value = seen(next);
      if (next_value != value) {
        double low = last, high = next;
        for (int k = 0; k < 40; ++k) {
          const double half = (low + high) / 2.0;
          (seen(half) == value ? low : high) = half;
        }
        sum += value * (low - begin);
        begin = low;
        value = next_value;
      }
      last = next;
    }
    sum += value * (end - begin);
  }
  return sum * (wall_albedo / pi * 2.0 / lines);
}

// Of that; sums over a lamp's points err by less.
constexpr double accuracy = 3e-4;

// A wall of the size 2 r around the point, which the camera sees from `eye`, before other things.
MirrorCase mirror_case(const std::string& name, const std::vector<Shape>& things, const Vec3& point,
                       const Vec3& normal, const Vec3& eye, double r = 0.25) {
  MirrorCase c{name, {}, point, normal};
  const Vec3 side = (std::abs(normal.y) < 0.5 ? Vec3(0, 1, 0) : Vec3(0, 0, 1)).cross(normal);
  const Vec3 x = side.normalized() * r, y = normal.cross(x);
  c.scene.shapes = things;
  c.scene.shapes.push_back(parallelogram(point - x - y, x * 2.0, y * 2.0, diffuse(wall_albedo)));
  c.scene.camera = camera(eye, point, pinpoint);
  return c;
}

// Irradiance from what of a polygon of radiance 1 is above the horizon and within the pyramid over
// the window's edges.
double lambert_through(std::vector<Vec3> lamp, const std::vector<Vec3>& window,
                       const MirrorCase& c) {
  const Vec3& p = c.point;
  lamp = part_beyond(lamp, c.normal, c.normal.dot(p));
  for (size_t i = 0; i < window.size(); ++i) {
    const Vec3& corner = window[(i + 2) % window.size()];
    Vec3 inwards = (window[i] - p).cross(window[(i + 1) % window.size()] - p);
    if (inwards.dot(corner - p) < 0.0) inwards = -inwards;
    lamp = part_beyond(lamp, inwards, inwards.dot(p));
  }
  return lamp.size() < 3 ? 0.0 : lambert(lamp, p, c.normal);
}

// Irradiance from a flat lamp of radiance 1 by way of a flat mirror: from its mirror image, as far
// as the mirror is a window onto it. What of the lamp is behind the mirror has no image.
double by_flat_mirror(const Polygon& lamp, const Polygon& mirror, bool two_sided,
                      const MirrorCase& c) {
  Vec3 m = mirror.normal();
  const Vec3& q = mirror.corners[0];
  if (m.dot(c.point - q) < 0.0) {
    if (!two_sided) return 0.0;
    m = -m;
  }
  const auto image = [&](const Vec3& v) { return v - m * (2.0 * m.dot(v - q)); };
  if (lamp.normal().dot(image(c.point) - lamp.corners[0]) <= 0.0) return 0.0;
  std::vector<Vec3> corners = part_beyond(lamp.corners, m, m.dot(q));
  std::transform(corners.begin(), corners.end(), corners.begin(), image);
  return lambert_through(corners, mirror.corners, c);
}

// Every flat lamp, straight and in every flat mirror, none of them in another's way.
MirrorCase flat(MirrorCase c) {
  const auto each_face = [&](const auto& visit) {
    for (const Shape& shape : c.scene.shapes) {
      for (const Polygon& face : std::get<Mesh>(shape.geometry)) visit(shape, face);
    }
  };
  each_face([&](const Shape& lamp, const Polygon& face) {
    if (!lamp.is_lamp()) return;
    const Rgb light = lamp.radiance * (wall_albedo / pi);
    if (face.normal().dot(c.point - face.corners[0]) > 0.0) {
      c.direct += light * lambert_through(face.corners, {}, c);
    }
    each_face([&](const Shape& mirror, const Polygon& window) {
      if (mirror.bsdf.kind == Bsdf::Kind::diffuse) return;
      c.by_mirror +=
          light * mirror.bsdf.reflectance * by_flat_mirror(face, window, mirror.bsdf.two_sided, c);
    });
  });
  return c;
}

Bsdf tinted_mirror(bool two_sided = false) {
  return {Bsdf::Kind::conductor, Rgb(0.9, 0.7, 0.5), two_sided};
}

Shape turned_over(Shape shape) {
  for (Polygon& face : std::get<Mesh>(shape.geometry)) {
    std::reverse(face.corners.begin(), face.corners.end());
  }
  return shape;
}

// A mirror cut into triangles, as faces in files are.
Shape fan(const std::vector<Vec3>& corners, const Bsdf& bsdf) {
  Mesh mesh;
  for (size_t i = 2; i < corners.size(); ++i) {
    mesh.push_back({{corners[0], corners[i - 1], corners[i]}});
  }
  return {"fan", mesh, bsdf, Rgb(0.0)};
}

const Vec3 origin(0, 0, 0), x_axis(1, 0, 0), y_axis(0, 1, 0), z_axis(0, 0, 1);

// A lamp that shines up, beside and above the point, and mirrors above them.
std::vector<MirrorCase> flat_mirrors() {
  const Vec3 eye(-0.1, 0.2, -0.4), aslant(0.6, 0.8, 0);
  const Bsdf black = diffuse(0.0), tinted = tinted_mirror();
  const Shape rectangle = parallelogram({0.5, 0.2, -0.5}, z_axis, x_axis, black, 2.0);
  const Shape triangle = polygon({{0.6, 0.2, -0.5}, {0.8, 0.3, 0.6}, {1.7, 0.2, 0.1}}, black, 3.0);
  const Shape ceiling = parallelogram({-9, 1, -9}, x_axis * 18, z_axis * 18, tinted);
  const Shape sloping = parallelogram({-9, -0.5, -9}, {18, 3.4, 0}, {0, 1.3, 18}, tinted);
  const Shape window = parallelogram({0.3, 1, -0.1}, {0.35, 0, 0.05}, {0.1, 0, 0.45}, tinted);
  const std::vector<Vec3> pentagon{
      {0.2, 1, -0.2}, {0.6, 1, -0.25}, {0.75, 1, 0}, {0.5, 1, 0.25}, {0.25, 1, 0.2}};
  const Shape two_sided = fan(pentagon, tinted_mirror(true));
  // Corners are the same bits in all faces, so that the boxes are solids.
  Mesh faces;
  for (const Shape& side : room({-0.1875, -0.1875, -0.3125}, {0.3125, 0.1875, 0.3125}, tinted)) {
    faces.push_back(std::get<Mesh>(turned_over(side).geometry)[0]);
    for (Vec3& v : faces.back().corners) {
      v = Vec3(0.8 * v.x - 0.6 * v.y + 0.5, 0.6 * v.x + 0.8 * v.y + 1.1, v.z);
    }
  }
  const Shape box{"box", faces, tinted, Rgb(0.0)};
  Mesh halves;  // of a box's sides, as most files have them
  for (const Shape& side : room({0.125, 1, -0.375}, {0.75, 1.5, 0.25}, tinted)) {
    const auto c = std::get<Mesh>(turned_over(side).geometry)[0].corners;
    halves.push_back({{c[0], c[1], c[2]}});
    halves.push_back({{c[0], c[2], c[3]}});
  }
  const Shape box_of_triangles{"box", halves, tinted, Rgb(0.0)};
  const auto make = [&](const std::string& name, const std::vector<Shape>& things,
                        const Vec3& normal = y_axis) {
    return flat(mirror_case(name, things, origin, normal, eye));
  };
  // Above the mirror it has no image, nor is it seen.
  const Shape upright = parallelogram({0.6, 0.6, -0.5}, z_axis, {0.4, 0.9, 0}, black, 2.0);
  MirrorCase through = make("lamp_through_the_mirror", {upright, ceiling});
  const auto& corners = std::get<Mesh>(upright.geometry)[0].corners;
  through.direct =
      Rgb(2.0 * wall_albedo / pi * lambert_through(part_beyond(corners, -y_axis, -1), {}, through));
  return {make("rectangle_in_a_mirror", {rectangle, ceiling}),
          make("triangle_in_a_mirror", {triangle, ceiling}, aslant),
          make("rectangle_in_a_sloping_mirror", {rectangle, sloping}),
          make("rectangle_in_a_window", {rectangle, window}, aslant),
          make("triangle_in_a_triangle",
               {triangle, polygon({{0.3, 1.1, -0.2}, {0.8, 0.9, 0}, {0.4, 1, 0.35}}, tinted)}),
          make("rectangle_in_five_corners", {rectangle, fan(pentagon, tinted)}),
          make("rectangle_in_a_box", {rectangle, box}),
          make("rectangle_in_a_box_of_triangles", {rectangle, box_of_triangles}),
          make("rectangle_in_a_faceted_ball",
               {rectangle, icosphere({0.4, 1.2, 0.1}, 0.4, 0, tinted)}, aslant),
          make("two_lamps_in_two_mirrors",
               {rectangle, window,
                parallelogram({0.1, 0.6, -1.2}, {0.8, 0, 0}, {0, -0.4, 0.2}, black, 5.0),
                parallelogram({-0.3, 1.2, -0.3}, {0.4, 0, 0}, {0, 0.1, 0.4}, tinted)}),
          through,
          make("back_of_a_two_sided_mirror", {rectangle, turned_over(two_sided)}),
          make("front_of_a_two_sided_mirror", {rectangle, two_sided}),
          make("back_of_a_mirror", {rectangle, turned_over(ceiling)}),
          make("back_of_a_lamp", {turned_over(triangle), ceiling})};
}

// A mirror and a lamp that stand on the floor and touch at the angle, beside the point.
MirrorCase corner(const std::string& name, double angle, double from_edge) {
  const Vec3 along(std::sin(angle), 0, -std::cos(angle));  // the lamp, from the edge
  const Vec3 middle(std::sin(angle / 2), 0, -std::cos(angle / 2));
  return flat(mirror_case(name,
                          {parallelogram(origin, y_axis, along, diffuse(0.0), 2.0),
                           parallelogram({0, 0, -2}, y_axis, z_axis * 2.0, tinted_mirror())},
                          middle * from_edge, y_axis, middle * 0.6 + y_axis * 0.1));
}

// A spherical lamp straight and in a large mirror above it: E = pi L sin^2(theta) cos(tilt), twice.
MirrorCase sphere_in_a_mirror() {
  const Vec3 center(1.2, 0.45, 0.1), image(1.2, 1.55, 0.1);
  constexpr double radius = 0.4;
  MirrorCase c =
      mirror_case("sphere_in_a_mirror",
                  {sphere(center, radius, diffuse(0.0), 2.0),
                   parallelogram({-9, 1, -9}, x_axis * 18, z_axis * 18, tinted_mirror())},
                  origin, y_axis, {-0.1, 0.2, -0.4});
  const auto radiance = [](const Vec3& v) {
    return wall_albedo * 2.0 * radius * radius / v.dot(v) * v.normalized().y;
  };
  c.direct = Rgb(radiance(center));
  c.by_mirror = tinted_mirror().reflectance * radiance(image);
  return c;
}

// Irradiance from a parallelogram of radiance 1 by way of a sphere that shows all of it. The lamp's
// points are seen as if at a distance whose square is (a + b + 2ab / (R cos t)) times (a + b + 2ab
// cos t / R), for the lengths a and b before and after the reflection at the angle t (Mitchell and
// Hanrahan 1992).
double by_ball(const Polygon& lamp, const Sphere& ball, const MirrorCase& c) {
  constexpr int n = 60;
  const auto& corners = lamp.corners;
  const Vec3 x = corners[1] - corners[0], y = corners[3] - corners[0];
  const Vec3 to_point = c.point - ball.center;
  const auto angle = [](const Vec3& u, const Vec3& v) {
    return std::atan2(u.cross(v).length(), u.dot(v));
  };
  double sum = 0.0;
  for (int i = 0; i < n * n; ++i) {
    const int row = i / n, column = i % n;
    const Vec3 on_lamp = corners[0] + x * ((column + 0.5) / n) + y * ((row + 0.5) / n);
    const Vec3 to_lamp = on_lamp - ball.center;
    const Vec3 first = to_point.normalized();
    const Vec3 second = (to_lamp - first * first.dot(to_lamp)).normalized();
    Vec3 normal, met;
    double low = 0.0, high = angle(to_point, to_lamp);
    for (int k = 0; k < 40; ++k) {
      const double half = (low + high) / 2.0;
      normal = first * std::cos(half) + second * std::sin(half);
      met = ball.center + normal * ball.radius;
      (angle(normal, c.point - met) < angle(normal, on_lamp - met) ? low : high) = half;
    }
    const double a = (c.point - met).length(), b = (on_lamp - met).length();
    const double cosine = normal.dot(c.point - met) / a;
    const double squared_distance = (a + b + 2.0 * a * b / (ball.radius * cosine)) *
                                    (a + b + 2.0 * a * b * cosine / ball.radius);
    sum +=
        c.normal.dot(met - c.point) / a * lamp.normal().dot(met - on_lamp) / b / squared_distance;
  }
  return sum * x.cross(y).length() / (n * n);
}

MirrorCase lamp_in_a_ball(const std::string& name, const Shape& lamp, const Vec3& normal) {
  const Shape ball = sphere({0.8, 0.5, 0}, 0.4, tinted_mirror());
  MirrorCase c = mirror_case(name, {lamp, ball}, origin, normal, {-0.1, 0.2, -0.4}, 0.1);
  const Polygon& face = std::get<Mesh>(lamp.geometry)[0];
  const Rgb light = lamp.radiance * (wall_albedo / pi);
  if (face.normal().dot(c.point - face.corners[0]) > 0.0) {
    c.direct = light * lambert_through(face.corners, {}, c);
  }
  c.by_mirror = light * ball.bsdf.reflectance * by_ball(face, std::get<Sphere>(ball.geometry), c);
  return c;
}

// Nothing but brute force knows these.
std::vector<MirrorCase> numeric_cases() {
  const Bsdf black = diffuse(0.0);
  std::vector<MirrorCase> all{
      mirror_case(
          "sphere_in_a_ball",
          {sphere({0.8, 0.5, 0}, 0.4, tinted_mirror()), sphere({0.3, 0.85, 0.3}, 0.25, black, 4.0)},
          origin, y_axis, {-0.1, 0.2, -0.4}, 0.1),
      mirror_case("ball_before_a_lamp",
                  {sphere({0.5, 0.4, 0}, 0.3, tinted_mirror()),
                   parallelogram({1, -1, 1}, {0, 2, 0}, {0, 0, -2}, black, 2.0),
                   parallelogram({-0.6, 0.2, 1}, {0, 0, -2}, {0, 2, 0}, black, 2.0)},
                  origin, y_axis, {-0.2, 0.1, -0.2}, 0.1),
      // The lamp turns its back to the point, which sees it in the bowl around them.
      mirror_case("lamp_in_a_bowl",
                  {sphere({0, 0, 0}, 1.0, tinted_mirror(true)),
                   parallelogram({0.1, 0, -0.2}, {0, 0, 0.4}, {0.4, 0, 0}, black, 2.0)},
                  {0, -0.4, 0.1}, Vec3(0.28, 0.96, 0), {-0.3, -0.25, 0}, 0.1),
      mirror_case(
          "sphere_in_a_bowl",
          {sphere({0, 0, 0}, 1.0, tinted_mirror(true)), sphere({0.2, 0.1, 0.3}, 0.15, black, 2.0)},
          {-0.1, -0.4, -0.1}, y_axis, {-0.4, -0.25, 0}, 0.1)};
  for (MirrorCase& c : all) c.is_solved = false;
  return all;
}

const std::vector<MirrorCase>& mirror_cases() {
  static const std::vector<MirrorCase> cases = [] {
    std::vector<MirrorCase> all = flat_mirrors();
    all.push_back(corner("corner", pi / 2, 0.03));
    all.push_back(corner("acute_corner", pi / 3, 0.01));
    all.push_back(sphere_in_a_mirror());
    const Bsdf black = diffuse(0.0);
    all.push_back(lamp_in_a_ball(
        "hidden_lamp_in_a_ball",
        parallelogram({0.15, 0.3, 0.5}, {0, 0, -1}, {0, 0.8, 0}, black, 4.0), y_axis));
    // Faces down, so that it lights the point, too.
    all.push_back(lamp_in_a_ball(
        "lamp_in_a_ball", parallelogram({-1.2, 1.3, -0.9}, {1.5, 0.1, 0}, {0, 0, 1.8}, black, 4.0),
        Vec3(0.6, 0.8, 0)));
    for (const MirrorCase& c : numeric_cases()) all.push_back(c);
    return all;
  }();
  return cases;
}

// Each case lies elsewhere: as it was written, turned, or turned, far away and of another size.
Scene placed(Scene scene, int number) {
  if (number % 3 == 0) return scene;
  scene = tilted(scene);
  if (number % 3 == 1) return scene;
  const double scale = number % 2 == 0 ? 300.0 : 0.002;
  const auto move = [&](Vec3& v) { v = (v + Vec3(40, -70, 20)) * scale; };
  move(scene.camera.origin);
  for (Shape& shape : scene.shapes) {
    if (auto* ball = std::get_if<Sphere>(&shape.geometry)) {
      move(ball->center);
      ball->radius *= scale;
      continue;
    }
    for (Polygon& face : std::get<Mesh>(shape.geometry)) std::ranges::for_each(face.corners, move);
  }
  return scene;
}

TEST(MirrorCases, AreMetByBruteForce) {
  for (const MirrorCase& c : mirror_cases()) {
    if (!c.is_solved) continue;
    const Rgb by_mirror = by_directions(c, 1), direct = by_directions(c, 0);
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(by_mirror[i], c.by_mirror[i], accuracy * c.by_mirror[i] + 4e-6) << c.name;
      EXPECT_NEAR(direct[i], c.direct[i], accuracy * c.direct[i] + 4e-6) << c.name;
    }
  }
}

// One channel alone, unlike measure().
Measurement measure_channel(const Film& film, int channel) {
  const std::vector<float> means = film.mean(), variances = film.variance();
  double mean = 0.0, variance = 0.0;
  for (size_t i = size_t(channel); i < means.size(); i += 3) {
    mean += double{means[i]};
    variance += double{variances[i]};
  }
  const double pixels = static_cast<double>(means.size()) / 3.0;
  return {mean / pixels, std::sqrt(variance) / pixels};
}

class MirroredLight : public testing::TestWithParam<std::tuple<Combination, int>> {};

// A sample that meets the lamp by chance is worth no more than M, the albedo times the brightest
// lamp, so that its variance is at most M times the mean, less the squared mean. The balance
// heuristic with a second way to draw it adds half of the squared mean at most (Veach 1997, theorem
// 9.2). Six standard deviations of an estimate of the error from 256 pixels with four replicates
// each are 15 %.
TEST_P(MirroredLight, IsMetWithinItsErrorWhichIsNotLargerThanThatOfChance) {
  const auto& [combination, number] = GetParam();
  const auto& [method, sampler, precision] = combination;
  const MirrorCase& c = mirror_cases()[size_t(number)];
  const Rgb direct = c.is_solved ? c.direct : by_directions(c, 0);
  const Rgb by_mirror = c.is_solved ? c.by_mirror : by_directions(c, 1);
  const Scene scene = placed(c.scene, number);
  double brightest = 0.0;
  for (const Shape& shape : scene.shapes) {
    brightest = std::max(brightest, shape.radiance.x * wall_albedo);
  }
  struct Part {
    BounceRange bounces;
    Rgb radiance;
    int64_t samples;
  };
  for (const Part& part : {Part{{1, 1}, direct, 256}, Part{{2, 2}, by_mirror, 2048},
                           Part{{1, 2}, direct + by_mirror, 512}}) {
    const Settings settings{.method = method,
                            .sampler = sampler,
                            .precision = precision,
                            .seed = 1,
                            .bounces = part.bounces};
    const int64_t samples = part.samples / (method == Method::plain ? 8 : 1);
    const Film film = render_film(scene, settings, {0, samples});
    for (int channel = 0; channel < 3; ++channel) {
      const Measurement m = measure_channel(film, channel);
      const double expected = part.radiance[channel];
      EXPECT_NEAR(m.mean, expected, 4.5 * m.standard_error + accuracy * expected)
          << part.bounces.first << " to " << part.bounces.last
          << " bounces: " << (m.mean / expected - 1.0) * 100.0 << " % off, standard error "
          << m.standard_error / expected * 100.0 << " %";
      if (part.bounces.first == 1) continue;
      const double pixels = double{1} * scene.camera.width * scene.camera.height;
      const double of_chance = std::sqrt(brightest * expected / (pixels * double(samples)));
      EXPECT_LE(m.standard_error, 1.15 * of_chance);
    }
  }
}

std::string mirror_name_of(const testing::TestParamInfo<MirroredLight::ParamType>& info) {
  const auto& [combination, number] = info.param;
  return name_of(combination) + mirror_cases()[size_t(number)].name;
}

INSTANTIATE_TEST_SUITE_P(
    All, MirroredLight,
    testing::Combine(all_combinations, testing::Range(0, static_cast<int>(mirror_cases().size()))),
    mirror_name_of);

INSTANTIATE_TEST_SUITE_P(
    Plain, MirroredLight,
    testing::Combine(plain_combination, testing::Range(0, static_cast<int>(mirror_cases().size()))),
    mirror_name_of);

const Settings plain{.method = Method::plain,
                     .sampler = Sampler::independent,
                     .precision = Precision::float64,
                     .bounces = {}};

// A convex lamp that reflects lights nothing of itself, and nothing else is there: it looks as it
// emits on its front, and black on its back. Another lamp in its plane does not light it, either.
TEST(ConvexLamp, LooksAsItEmits) {
  const Bsdf white = diffuse(0.9, true);
  Scene plates;
  plates.shapes = {parallelogram({-9, -9, 0}, {9, 0, 0}, {0, 18, 0}, white, 2.0),
                   polygon({{0, -9, 0}, {9, -9, 0}, {9, 9, 0}}, white, 2.0),
                   polygon({{0, -9, 0}, {9, 9, 0}, {0, 9, 0}}, white, 2.0)};
  Scene cube, ball, facets;
  for (Shape& side : room({-1, -1, -1}, {1, 1, 1}, white, 2.0)) {
    auto& face = std::get<Mesh>(side.geometry)[0];
    std::reverse(face.corners.begin(), face.corners.end());
    cube.shapes.push_back(side);
  }
  ball.shapes = {sphere({0, 0, 0}, 1.0, white, 2.0)};
  facets.shapes = {icosphere({0, 0, 0}, 1.0, 2, white, 2.0)};
  for (Scene scene : {plates, cube, ball, facets}) {
    for (const bool is_outside : {true, false}) {
      // Through the inside of a closed lamp its backs are seen.
      const bool is_flat = scene.shapes[0].id == "parallelogram" && scene.shapes.size() == 3;
      const Vec3 eye = is_outside ? Vec3(0.4, 0.5, 2.2) : is_flat ? Vec3(0, 0, -2) : Vec3(0, 0, 0);
      scene.camera = camera(eye, {0.1, 0.1, 0}, is_outside ? 20.0 : 100.0);
      for (const Method method : {Method::bsdf, Method::nee, Method::mis}) {
        for (const Precision precision : {Precision::float32, Precision::float64}) {
          const Settings settings{.method = method, .precision = precision, .bounces = {}};
          const std::vector<float> mean = render_film(tilted(scene), settings, {0, 64}).mean();
          const float expected = is_outside ? 2.0f : 0.0f;
          EXPECT_EQ(mean, std::vector<float>(mean.size(), expected))
              << scene.shapes[0].id << int(method) << int(precision) << is_outside;
        }
      }
      // The plain path tracer does not know that a surface can't light itself: its light passes the
      // lamp's plane by rounding alone.
      for (const float value : render_film(tilted(scene), plain, {0, 4}).mean()) {
        EXPECT_NEAR(value, is_outside ? 2.0f : 0.0f, 1e-20f) << scene.shapes[0].id;
      }
    }
  }
}

// A furnace shines the same everywhere inside, also where a camera outside looks into it through
// the backs of its walls. Without that it sees the backs, which are black.
TEST(Furnace, ShinesThroughTheBacksOfItsWalls) {
  Case c = furnace("furnace_from_outside", 0.5, true);
  c.scene.camera = camera({-3.0, 3.5, -4.0}, {0.0, 0.2, 0.0}, 14.0);
  for (const bool is_tilted : {false, true}) {
    Scene scene = is_tilted ? tilted(c.scene) : c.scene;
    for (const Precision precision : {Precision::float32, Precision::float64}) {
      for (const Method method : {Method::bsdf, Method::nee, Method::mis}) {
        for (const Sampler sampler : {Sampler::independent, Sampler::sobol}) {
          const Settings settings{.method = method,
                                  .sampler = sampler,
                                  .precision = precision,
                                  .seed = 1,
                                  .bounces = {}};
          scene.camera.sees_through_backs = false;
          const std::vector<float> backs = render_film(scene, settings, {0, 16}).mean();
          EXPECT_EQ(backs, std::vector<float>(backs.size(), 0.0f));
          scene.camera.sees_through_backs = true;
          const Film film = render_film(scene, settings, {0, 4096});
          const Measurement m = measure(film);
          EXPECT_LE(m.standard_error, 1e-3 * c.radiance);
          EXPECT_NEAR(m.mean, c.radiance, 4.0 * m.standard_error + 1e-6 * c.radiance);
          // No pixel is left out: each is within seven standard errors of a pixel, all of them
          // known together, because four replicates tell little of one.
          const std::vector<float> mean = film.mean();
          const double pixel = m.standard_error * std::sqrt(static_cast<double>(mean.size()) / 3.0);
          for (const float value : mean) EXPECT_NEAR(value, c.radiance, 7.0 * pixel);
        }
      }
    }
  }
}

TEST(UnlitScene, IsExactlyBlack) {
  Scene scene;
  scene.shapes = room({-1, -1, -1}, {1, 1, 1}, diffuse(0.9));
  scene.shapes.push_back(sphere({0, 0, 0}, 0.3, mirror(0.9)));
  scene.camera = camera({-0.7, 0.6, -0.8}, {0, 0, 0}, 60.0);
  std::vector<Settings> all{plain};
  for (const Method method : {Method::bsdf, Method::nee, Method::mis}) {
    all.push_back({.method = method, .bounces = {}});
  }
  for (const Settings& settings : all) {
    const Film film = render_film(scene, settings, {0, 64});
    EXPECT_EQ(film.mean(), std::vector<float>(film.mean().size(), 0.0f));
    EXPECT_EQ(film.variance(), std::vector<float>(film.mean().size(), 0.0f));
  }
}

TEST(EmptyScene, IsExactlyBlack) {
  Scene scene;
  scene.camera = camera({0, 0, 0}, {0, 0, 1}, 60.0);
  const Film film = render_film(scene, {.bounces = {}}, {0, 8});
  EXPECT_EQ(film.mean(), std::vector<float>(film.mean().size(), 0.0f));
}

TEST(Lambert, AgreesWithTheFactorOfAParallelRectangleOverItsCorner) {
  const double x = 0.7;  // sides over height
  const double y = 1.9;
  const double rx = std::sqrt(1 + x * x);
  const double ry = std::sqrt(1 + y * y);
  const double factor = (x / rx * std::atan(y / rx) + y / ry * std::atan(x / ry)) / (2 * pi);
  const std::vector<Vec3> lamp{{0, 1, 0}, {x, 1, 0}, {x, 1, y}, {0, 1, y}};
  EXPECT_NEAR(lambert(lamp, {0, 0, 0}, {0, 1, 0}), pi * factor, 1e-14);
}

}  // namespace
}  // namespace plumb::test
