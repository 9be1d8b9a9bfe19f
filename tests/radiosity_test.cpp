// SPDX-License-Identifier: Apache-2.0

// Radiosity meets closed forms, keeps energy, and agrees with path tracing, with which it shares
// nothing but the scene model.
#include "radiosity/radiosity.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "radiosity/elements.h"
#include "radiosity/eye.h"
#include "radiosity/faces.h"
#include "radiosity/solution.h"
#include "scene_files/scene_reader.h"
#include "tests/test_scenes.h"

namespace plumb::radiosity {
namespace {

using test::diffuse;
using test::parallelogram;
using test::polygon;

constexpr double pi = std::numbers::pi;
constexpr size_t enough = size_t{1} << 30;
const Work quiet{[](const std::string&) {}, nullptr};

Scene scene_of(std::vector<Shape> shapes) {
  Scene scene;
  scene.camera = test::camera({0.1, -0.2, 0.3}, {0.4, 0.5, -0.6}, 70.0);
  scene.shapes = std::move(shapes);
  return scene;
}

// A floor of unit size around the origin, whose middle looks up.
Shape unit_floor(const Bsdf& bsdf = diffuse(0.5)) {
  return parallelogram({-0.5, -0.5, 0.0}, {1, 0, 0}, {0, 1, 0}, bsdf);
}

// A black square of side 2 above it, which shines down.
Shape lamp(double height = 1.0) {
  return parallelogram({-1, -1, height}, {0, 2, 0}, {2, 0, 0}, diffuse(0.0), 1.0);
}

// The form factor from a point to a parallel rectangle, a corner of which is straight above, with
// sides of a and b times its height.
double corner_factor(double a, double b) {
  const double x = std::sqrt(1.0 + a * a), y = std::sqrt(1.0 + b * b);
  return (a / x * std::atan(b / x) + b / y * std::atan(a / y)) / (2.0 * pi);
}

// Irradiance / pi at a point of the first face.
double arriving(const std::vector<Shape>& shapes, const Vec3& point = Vec3(0.0)) {
  const Faces faces(scene_of(shapes));
  Eye eye(faces);
  eye.move_to(0, point);
  return eye.direct().x;
}

// The mean of what arrives over the first face, by Gauss points of 2^depth parts.
double mean_arriving(const std::vector<Shape>& shapes, int depth) {
  const Faces faces(scene_of(shapes));
  Eye eye(faces);
  std::vector<Element> parts{Element(faces, 0, faces[0].outline.corners)};
  for (int i = 0; i < depth; ++i) {
    std::vector<Element> halves;
    for (const Element& part : parts) {
      for (const Element& half : part.halves(faces)) halves.push_back(half);
    }
    parts = halves;
  }
  double sum = 0.0, area = 0.0;
  for (const Element& part : parts) {
    for (size_t q = 0; q < size_t(part.points); ++q) {
      eye.move_to(0, part.point[q]);
      sum += eye.direct().x * part.area[q];
      area += part.area[q];
    }
  }
  return sum / area;
}

Picture draw_level(const Scene& scene, int level) {
  return draw(scene, {.bounces = scene.request.bounces, .level = level, .most_bytes = enough},
              quiet);
}

double mean_of(const Picture& picture) {
  return std::accumulate(picture.rgb.begin(), picture.rgb.end(), 0.0) / double(picture.rgb.size());
}

TEST(FormFactor, MeetsTheFormulaOfARectangleAboveACorner) {
  for (const double a : {1e-6, 0.01, 0.3, 1.0, 7.0, 1e4}) {
    for (const double b : {1e-6, 0.2, 1.0, 30.0}) {
      Convex rectangle;
      for (const Vec3& c : {Vec3(0, 0, 1), {0, b, 1}, {a, b, 1}, {a, 0, 1}}) rectangle.add(c);
      // Rounding of directions, over the size of what is seen.
      EXPECT_NEAR(form_factor({0, 0, 1}, rectangle) / corner_factor(a, b), 1.0,
                  1e-13 + 1e-16 / std::min({a, b, 1.0}))
          << a << " x " << b;
    }
  }
}

// Howell's catalogue, C-11 and C-14, for squares.
TEST(FormFactor, BetweenPlatesIsThatOfTheCatalogue) {
  const double parallel = 2.0 / pi *
                          (std::log(2.0 / std::sqrt(3.0)) +
                           2.0 * std::sqrt(2.0) * std::atan(1.0 / std::sqrt(2.0)) - pi / 2.0);
  const double perpendicular =
      (pi / 2.0 - std::sqrt(2.0) * std::atan(1.0 / std::sqrt(2.0)) + 0.25 * std::log(0.75)) / pi;
  const Shape above = parallelogram({-0.5, -0.5, 1}, {0, 1, 0}, {1, 0, 0}, diffuse(0.0), 1.0);
  const Shape beside = parallelogram({-0.5, -0.5, 0}, {0, 1, 0}, {0, 0, 1}, diffuse(0.0), 1.0);
  EXPECT_NEAR(mean_arriving({unit_floor(), above}, 10), parallel, 2e-9);
  // At the common edge it falls from 1/2 with the distance's root's slope: that is cut in parts.
  EXPECT_NEAR(mean_arriving({unit_floor(), beside}, 14), perpendicular, 1e-5);
}

TEST(FormFactor, IsReciprocal) {
  const std::vector<Vec3> small{{0.1, 0.3, 1.0}, {0.2, 0.9, 1.2}, {0.8, 0.4, 0.9}};
  const Shape floor = unit_floor(), triangle = polygon(small, diffuse(0.5));
  Shape shining_floor = floor, shining_triangle = triangle;
  shining_floor.radiance = shining_triangle.radiance = Rgb(1.0);
  const double area = (small[1] - small[0]).cross(small[2] - small[0]).length() / 2.0;
  const double down = mean_arriving({floor, shining_triangle}, 10);
  const double up = mean_arriving({triangle, shining_floor}, 10);
  EXPECT_GT(down, 0.01);
  EXPECT_NEAR(down, up * area, 1e-9);
}

TEST(Visibility, HoldsInHardCases) {
  const Bsdf black = diffuse(0.0);
  const double whole = 4.0 * corner_factor(1, 1), half = whole / 2.0;
  // At half the height, what is half as large hides as much.
  const Shape left = parallelogram({-0.5, -0.5, 0.5}, {0.5, 0, 0}, {0, 1, 0}, black);
  const Shape right = parallelogram({0, -0.5, 0.5}, {0.5, 0, 0}, {0, 1, 0}, black);
  const Shape turned = parallelogram({-0.5, 0.5, 0.5}, {0.5, 0, 0}, {0, -1, 0}, black);
  const auto strip = [&](double x, double width) {
    return parallelogram({x, -3, 0.5}, {width, 0, 0}, {0, 6, 0}, black);
  };
  const auto wall = [&](double x, double low, double high) {
    return parallelogram({x, -3, low}, {0, 6, 0}, {0, 0, high - low}, black);
  };
  const auto strip_factor = [](double from, double to) {  // of the lamp from x to x
    return 2.0 * (corner_factor(to, 1) - corner_factor(from, 1));
  };
  const struct {
    const char* name;
    std::vector<Shape> obstacles;
    double expected;
  } cases[] = {
      {"nothing", {}, whole},
      {"half", {left}, half},
      {"its back", {turned}, half},
      {"twice the same", {left, left, turned}, half},
      {"nested", {left, parallelogram({-0.4, -0.1, 0.6}, {0.1, 0, 0}, {0, 0.1, 0}, black)}, half},
      {"two that touch", {left, right}, 0.0},
      {"two that overlap", {strip(-1, 1.1), strip(-0.1, 1.1)}, 0.0},
      {"in the lamp's plane", {parallelogram({-2, -2, 1}, {4, 0, 0}, {0, 4, 0}, black)}, whole},
      {"in the lamp's plane, turned",
       {parallelogram({-2, -2, 1}, {0, 4, 0}, {4, 0, 0}, black)},
       whole},
      {"touches the lamp", {wall(1, 0.5, 1)}, whole},
      {"hangs from the lamp's middle, seen edge on", {wall(0, 0.5, 1)}, whole},
      {"through the lamp: beyond it nothing counts",
       {polygon({{0, -9, 0.5}, {2, -9, 2.5}, {2, 9, 2.5}, {0, 9, 0.5}}, black)},
       whole - strip_factor(0, 0.5)},
      {"just behind the lamp",
       {parallelogram({-2, -2, 1 + 1e-6}, {4, 0, 0}, {0, 4, 0}, black)},
       whole},
      {"just before the lamp",
       {parallelogram({-2, -2, 1 - 1e-6}, {4, 0, 0}, {0, 4, 0}, black)},
       0.0},
      {"in the floor's plane", {parallelogram({-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, black)}, whole},
      {"through the floor", {wall(0.5, -1, 3)}, whole - strip_factor(0.5, 1)},
      {"thin",
       {strip(-1e-8, 1e-8), strip(0.2, 1e-7)},
       whole - strip_factor(0, 2e-8) - strip_factor(0.4, 0.4 + 2e-7)},
      {"through each other",
       {polygon({{-0.5, -9, 0.4}, {-0.5, 9, 0.4}, {0, 9, 0.6}, {0, -9, 0.6}}, black),
        polygon({{-0.5, -9, 0.6}, {-0.5, 9, 0.6}, {0, 9, 0.4}, {0, -9, 0.4}}, black)},
       half},
  };
  for (const auto& c : cases) {
    std::vector<Shape> shapes{unit_floor(), lamp()};
    shapes.insert(shapes.end(), c.obstacles.begin(), c.obstacles.end());
    // Closer than 1e-13 of the scene's size things touch, and it is ten times as large as the lamp.
    EXPECT_NEAR(arriving(shapes), c.expected, 2e-12) << c.name;
  }
}

// Polygons that are a shape each bound no solid, so that all of them are looked at.
TEST(Visibility, OfASolidIsThatOfAllItsPolygons) {
  // Inside is the front: low z, low x, low y, high z, high x, high y.
  const auto box = [](const Vec3& low, const Vec3& high) {
    std::vector<Shape> sides = test::room(low, high, diffuse(0.0));
    for (Shape& side : sides) {
      auto& corners = std::get<Mesh>(side.geometry)[0].corners;
      std::reverse(corners.begin(), corners.end());
    }
    return sides;
  };
  const auto without = [&](std::vector<Shape> sides, std::initializer_list<int> which) {
    for (const int i : which) sides[size_t(i)].geometry = Mesh();
    std::erase_if(sides, [](const Shape& side) { return std::get<Mesh>(side.geometry).empty(); });
    return sides;
  };
  const auto standing = box({-0.3, -0.2, 0}, {0.1, 0.2, 0.4});
  const auto floating = box({-0.3, -0.2, 0.2}, {0.1, 0.2, 0.6});
  Scene turned = scene_of(floating);
  turned = test::tilted(turned);
  const struct {
    const char* name;
    std::vector<Shape> sides;
    size_t solids;
  } cases[] = {
      {"stands", standing, 1},
      {"stands, without a bottom", without(standing, {0}), 1},
      {"floats", floating, 1},
      {"floats, and is seen into from below", without(floating, {0}), 1},
      {"open to a side", without(floating, {1}), 1},
      {"open below and above: no solid", without(floating, {0, 3}), 0},
      {"open to two sides: no solid", without(floating, {1, 2}), 0},
      {"inside out: no solid", test::room({-0.3, -0.2, 0.2}, {0.1, 0.2, 0.6}, diffuse(0.0)), 0},
      {"tilted", turned.shapes, 1},
      {"through the floor", box({-0.3, -0.2, -0.3}, {0.1, 0.2, 0.4}), 1},
      {"through the lamp", box({-0.3, -0.2, 0.5}, {0.1, 0.2, 1.4}), 1},
      {"all is inside of it", box({-2, -2, -1}, {2, 2, 2}), 1},
      {"all but a part of the lamp is inside of it", box({-2, -2, -1}, {0.3, 2, 2}), 1},
  };
  for (const auto& c : cases) {
    std::vector<Shape> apart{unit_floor(), lamp()}, joined = apart;
    joined.push_back(c.sides[0]);
    auto& mesh = std::get<Mesh>(joined[2].geometry);
    for (const Shape& side : c.sides) apart.push_back(side);
    for (size_t i = 1; i < c.sides.size(); ++i) {
      mesh.push_back(std::get<Mesh>(c.sides[i].geometry)[0]);
    }
    EXPECT_EQ(Faces(scene_of(joined)).solids().size(), c.solids) << c.name;
    for (const double x : {-0.4, -0.3, -0.1, 0.1, 0.25, 0.5}) {
      for (const double y : {-0.3, 0.0, 0.2}) {
        EXPECT_NEAR(arriving(joined, {x, y, 0}), arriving(apart, {x, y, 0}), 2e-12)
            << c.name << ", " << x << ", " << y;
      }
    }
  }
}

// A floor is cut along what stands on it. Within a column of many sides that leaves a piece with as
// many corners.
TEST(Elements, MakeUpAFaceWithAColumnOfManySidesOnIt) {
  constexpr int sides = 40;
  const auto corner = [](int i, double height) {
    const double angle = 2.0 * pi * i / sides;
    return Vec3(0.4 * std::cos(angle), 0.4 * std::sin(angle), height);
  };
  Shape column{"column", Mesh{}, diffuse(0.5), Rgb(0.0)};
  for (int i = 0; i < sides; ++i) {
    std::get<Mesh>(column.geometry)
        .push_back({{corner(i, 0), corner(i + 1, 0), corner(i + 1, 0.3), corner(i, 0.3)}});
  }
  const Faces faces(scene_of({unit_floor(), column}));
  double within = 0.0, area = 0.0;
  for (const Element& part : parts_of(faces, 0, true)) {
    area += part.whole;
    if (part.center.length() < 0.4 * std::cos(pi / sides)) within += part.whole;
  }
  EXPECT_NEAR(area, 1.0, 1e-12);
  EXPECT_NEAR(within, 0.5 * sides * 0.16 * std::sin(2.0 * pi / sides), 1e-12);
}

// A closed room of surfaces that all emit what they don't reflect: nothing but radiance 1 keeps the
// balance of energy, bounce by bounce. All form factors of a point then add up to 1, whatever
// stands in between: a sheet with two emitting sides, another one that goes through it, a rug on
// the floor.
TEST(Energy, IsKeptInClosedRooms) {
  std::vector<Shape> empty = test::room({-1, -1, -1}, {1, 1, 1}, diffuse(0.0)), full = empty;
  const auto add = [&](const Vec3& corner, const Vec3& x, const Vec3& y) {
    full.push_back(parallelogram(corner, x, y, diffuse(0.0)));
  };
  add({-0.5, -0.4, -0.3}, {0.7, 0.2, 0.1}, {0.1, 0.2, 0.6});
  add({-0.5, -0.4, -0.3}, {0.1, 0.2, 0.6}, {0.7, 0.2, 0.1});
  add({-0.4, 0.5, -0.5}, {0.8, -0.9, 0.6}, {0.2, 0.1, 0.7});
  add({-0.4, 0.5, -0.5}, {0.2, 0.1, 0.7}, {0.8, -0.9, 0.6});
  add({0.2, 0.1, -1}, {0.5, 0.1, 0}, {0, 0.4, 0});
  for (auto shapes : {empty, full}) {
    for (Shape& shape : shapes) {
      shape.bsdf.reflectance = Rgb(0.3, 0.6, 0.9);
      shape.radiance = Rgb(1.0) - shape.bsdf.reflectance;
    }
    const Faces faces(scene_of(shapes));
    const Elements elements(faces, enough);
    const Solution solution(elements, Resolution::level(0), {}, nullptr, nullptr, enough, quiet);
    Eye eye(faces);
    for (size_t face = 0; face < faces.list().size(); ++face) {
      const auto& corners = faces[face].outline.corners;
      eye.move_to(face, corners[0] * 0.3 + corners[1] * 0.45 + corners[2] * 0.25);
      const Rgb arriving = eye.direct() + solution.gather(eye);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(arriving[c], 1.0, 1e-10) << face << ", channel " << c;
    }
  }
}

TEST(Radiosity, MeetsScenesThatStressPathTracers) {
  const struct {
    const char* name;
    double radiance;
  } cases[] = {{"ceiling_lamp", 0.39686329},
               {"grazing_lamp", 0.39738751},
               {"edge_on_lamp", 0.10366525},
               {"edge_pixel", 0.5},
               {"coplanar", 1.0},
               {"touching_box", 1.0},
               {"corner_camera", 1.0}};
  for (const auto& c : cases) {
    const Picture picture =
        draw_level(read_scene(std::string(PLUMB_SCENES "/stress/") + c.name + ".xml"), 1);
    EXPECT_NEAR(mean_of(picture), c.radiance, (2e-7 + picture.error) * c.radiance) << c.name;
    EXPECT_LT(picture.error, 1e-3) << c.name;
  }
}

// A room with a lamp, a block, and a triangle that is matte on both sides.
Scene small_room() {
  std::vector<Shape> shapes = test::room({-1, -1, -1}, {1, 1, 1}, diffuse(0.6));
  shapes[0].bsdf.reflectance = Rgb(0.8, 0.3, 0.1);
  shapes[4].bsdf.reflectance = Rgb(0.1, 0.7, 0.3);
  shapes.push_back(parallelogram({-0.3, 0.97, -0.3}, {0.5, 0, 0}, {0, 0, 0.6}, diffuse(0.2), 5.0));
  Shape block = parallelogram({0.1, -1, 0.1}, {0.5, 0, 0}, {0, 0.6, 0}, diffuse(0.7, true));
  shapes.push_back(block);
  shapes.push_back(parallelogram({0.1, -1, 0.1}, {0, 0.6, 0}, {0, 0, 0.6}, diffuse(0.7, true)));
  shapes.push_back(parallelogram({0.1, -0.4, 0.1}, {0.5, 0, 0}, {0, 0, 0.6}, diffuse(0.7, true)));
  shapes.push_back(
      polygon({{-0.8, -0.9, -0.5}, {-0.3, -0.7, 0.4}, {-0.6, 0.1, 0.2}}, diffuse(0.5, true)));
  Scene scene;
  scene.shapes = shapes;
  scene.camera = test::camera({0.2, 0.1, -0.95}, {0, -0.3, 0.5}, 80.0, 16);
  return scene;
}

// With what shares no code with it but the scene model. Within four standard errors, and the
// error that radiosity claims.
void expect_agreement(const Scene& scene, const BounceRange& bounces, Method method,
                      int64_t samples) {
  Scene drawn = scene;
  drawn.request.bounces = bounces;
  const Picture picture = draw_level(drawn, 1);
  const plumb::Settings settings{.method = method,
                                 .sampler = Sampler::independent,
                                 .precision = Precision::float64,
                                 .seed = 1,
                                 .bounces = bounces};
  const test::Measurement traced = test::measure(test::render_film(scene, settings, {0, samples}));
  EXPECT_NEAR(mean_of(picture), traced.mean,
              4.0 * traced.standard_error + picture.image_floor * traced.mean)
      << "bounces from " << bounces.first << ", method " << int(method);
}

TEST(Radiosity, AgreesWithPathTracingBounceByBounce) {
  for (const BounceRange& bounces : {BounceRange{0, 0}, {1, 1}, {2, 2}, {3, 5}, {}}) {
    expect_agreement(small_room(), bounces, Method::mis, 1024);
  }
  expect_agreement(small_room(), {}, Method::plain, 64);
}

// A screen and a lamp on a floor ten thousand times as large: elements have to be as fine as what
// stands there, for else their points miss the light below the lamp, at every resolution.
TEST(Radiosity, AgreesWithPathTracingOfSmallThingsOnAHugeFloor) {
  Scene scene;
  scene.shapes = {parallelogram({-5000, 0, 5000}, {10000, 0, 0}, {0, 0, -10000}, diffuse(0.5)),
                  parallelogram({-0.5, 0, 0}, {1, 0, 0}, {0, 1, 0}, diffuse(0.7)),
                  parallelogram({-0.5, 2, 1}, {1, 0, 0}, {0, 0, 1}, diffuse(0.0), 10.0)};
  scene.camera = test::camera({1, 1, 3}, {0, 0.3, 0}, 40.0);
  const Picture picture = draw_level(scene, 1);
  EXPECT_LT(picture.image_floor, 1e-3);
  EXPECT_LT(picture.block_floor, 1e-2);
  expect_agreement(scene, {2, 2}, Method::mis, 4096);
}

TEST(Radiosity, AgreesWithPathTracingInTheCornellBox) {
  Scene scene = read_scene(PLUMB_SCENES "/cornell/scene.xml");
  scene.camera.width = scene.camera.height = 24;
  expect_agreement(scene, {}, Method::mis, 1024);
}

TEST(Radiosity, ErrorsFallByHalfOrMoreInTheCornellBox) {
  Scene scene = read_scene(PLUMB_SCENES "/cornell/scene.xml");
  scene.camera.width = scene.camera.height = 24;
  const Picture first = draw_level(scene, 1), second = draw_level(scene, 2);
  EXPECT_LT(first.error, 0.002);
  EXPECT_LT(second.error, first.error / 2.0);
}

TEST(Radiosity, EndsAtTheWantedError) {
  const Picture picture =
      draw(small_room(), {.bounces = {}, .error = 0.003, .most_bytes = enough}, quiet);
  EXPECT_LE(picture.error, 0.003);
  EXPECT_EQ(picture.why_ended, "");
}

TEST(Radiosity, TakesFromACoarserSolutionWhatItWouldComputeItself) {
  const Faces faces(small_room());
  Elements elements(faces, enough);
  auto coarse = std::make_unique<Solution>(elements, Resolution::level(0), BounceRange(), nullptr,
                                           nullptr, enough, quiet);
  elements.refine(coarse->unevenness(), Resolution::level(0).unevenness);
  const Resolution finer = Resolution::level(1);
  const Solution alone(elements, finer, {}, nullptr, nullptr, enough, quiet);
  const Solution helped(elements, finer, {}, nullptr, std::move(coarse), enough, quiet);
  EXPECT_EQ(alone.links(), helped.links());
  Eye eye(faces);
  for (size_t face = 0; face < faces.list().size(); ++face) {
    const auto& corners = faces[face].outline.corners;
    eye.move_to(face, corners[0] * 0.3 + corners[1] * 0.45 + corners[2] * 0.25);
    EXPECT_EQ(alone.gather(eye), helped.gather(eye)) << face;
  }
}

TEST(Radiosity, HasTheSameBitsOnAnyNumberOfThreads) {
  std::vector<float> one, three;
  for (std::vector<float>* rgb : {&one, &three}) {
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                      rgb == &one ? 1 : 3);
    *rgb = draw_level(small_room(), 1).rgb;
  }
  EXPECT_EQ(one, three);
}

TEST(Radiosity, GivesTheCoarserPictureWhenItIsStopped) {
  std::atomic<bool> stop = false;
  int pictures = 0;
  const Work work{[&](const std::string& phase) {
                    if (phase == "pixels, 0 %") ++pictures;
                    stop = pictures == 3;
                  },
                  &stop};
  const Picture picture =
      draw(small_room(), {.bounces = {}, .level = 5, .most_bytes = enough}, work);
  const Picture coarser = draw_level(small_room(), 1);
  EXPECT_EQ(picture.why_ended, "interrupted");
  EXPECT_EQ(picture.rgb, coarser.rgb);
  EXPECT_EQ(picture.error, coarser.error);
  EXPECT_GT(picture.block_floor, 0.0);
}

TEST(Radiosity, RefusesWhatDoesNotFitIntoMemoryWithTheNumberOfElements) {
  const auto message_of = [](size_t bytes) -> std::string {
    try {
      draw(small_room(), {.bounces = {}, .most_bytes = bytes}, quiet);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message_of(size_t{1} << 16).find("elements don't fit"), std::string::npos);
  EXPECT_NE(message_of(size_t{1} << 21).find(" elements with "), std::string::npos);
}

// What may stand between each two of its faces is more than all of their elements.
TEST(Radiosity, RefusesMeshesOfTooManyFacesForTheMemory) {
  Scene scene = small_room();
  scene.shapes.push_back(test::icosphere({0, 0, 0}, 0.2, 3, diffuse(0.5)));
  try {
    draw(scene, {.bounces = {}, .most_bytes = size_t{1} << 24}, quiet);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("1295 faces"), std::string::npos) << error.what();
  }
}

TEST(Radiosity, IsStoppedBeforeAnyPicture) {
  std::atomic<bool> stop = false;
  const Work work{[&](const std::string& phase) { stop = stop || phase.starts_with("views"); },
                  &stop};
  const Picture picture = draw(small_room(), {.bounces = {}, .most_bytes = enough}, work);
  EXPECT_EQ(picture.why_ended, "interrupted");
  EXPECT_EQ(picture.level, -1);
}

TEST(Radiosity, RefusesAllButMattePolygonsByName) {
  Scene scene = small_room();
  Shape ball = test::sphere({0, 0, 0}, 0.1, diffuse(0.5));
  ball.id = "ball";
  Shape steel = unit_floor(test::mirror(0.9)), gold = unit_floor(test::metal(Rgb(0.2), Rgb(3.0))),
        pane = unit_floor(test::glass(1.5));
  steel.id = "steel";
  gold.id = "gold";
  pane.id = "pane";
  for (const Shape& shape : {ball, steel, gold, pane}) scene.shapes.push_back(shape);
  scene.sky = Rgb(0.1);
  scene.points.push_back({Vec3(0.0), Rgb(1.0)});
  scene.camera.filter = {.kind = Filter::Kind::tent, .size = 1.0};
  try {
    draw_level(scene, 1);
    FAIL();
  } catch (const std::invalid_argument& error) {
    for (const char* part : {"'ball' is a sphere", "'steel' is a mirror", "'gold' is of metal",
                             "'pane' is of glass", "a sky", "point lamps", "filter"}) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << part;
    }
  }
}

TEST(Radiosity, RefusesLightThatNeverFades) {
  std::vector<Shape> shapes = test::room({-1, -1, -1}, {1, 1, 1}, diffuse(1.0));
  shapes[0].radiance = Rgb(1.0);
  EXPECT_THROW(draw_level(scene_of(shapes), 1), std::runtime_error);
}

}  // namespace
}  // namespace plumb::radiosity
