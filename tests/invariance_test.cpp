// SPDX-License-Identifier: Apache-2.0

// A picture does not depend on how large the scene is or where it lies, and no light leaks.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "scene_files/scene_reader.h"
#include "tests/test_scenes.h"

namespace plumb::test {
namespace {

// Every point p becomes p * scale + offset.
Scene moved(Scene scene, double scale, const Vec3& offset) {
  scene.camera.origin = scene.camera.origin * scale + offset;
  for (Shape& shape : scene.shapes) {
    if (auto* ball = std::get_if<Sphere>(&shape.geometry)) {
      *ball = {ball->center * scale + offset, ball->radius * scale};
      continue;
    }
    for (Polygon& face : std::get<Mesh>(shape.geometry)) {
      for (Vec3& corner : face.corners) corner = corner * scale + offset;
    }
  }
  return scene;
}

struct Difference {
  double mean = 0.0;  // of the pictures' means, relative
  double rms = 0.0;   // of the pixels, relative to the mean
};

Difference compare(const Film& a, const Film& b) {
  const std::vector<float> x = a.mean();
  const std::vector<float> y = b.mean();
  double sum = 0.0;
  double difference = 0.0;
  double squares = 0.0;
  for (size_t i = 0; i < x.size(); ++i) {
    const double d = double{x[i]} - double{y[i]};
    sum += double{x[i]};
    difference += d;
    squares += d * d;
  }
  const auto n = static_cast<double>(x.size());
  return {difference / sum, std::sqrt(squares / n) / (sum / n)};
}

class Invariance : public testing::TestWithParam<std::tuple<const char*, Precision>> {
 protected:
  static Scene scene() {
    Scene scene =
        read_scene(std::string(PLUMB_SCENES "/") + std::get<0>(GetParam()) + "/scene.xml");
    scene.camera.width = scene.camera.height = 64;
    return scene;
  }

  static Film film(const Scene& scene) {
    return render_film(scene, {.precision = std::get<1>(GetParam()), .bounces = {}}, {0, 64});
  }
};

// The scene is brought to the same place before it is rounded to float, so the same paths are
// followed but for those few whose hit or miss hangs on the last bit.
constexpr double largest_mean = 1e-4;
constexpr double largest_rms = 2e-3;

TEST_P(Invariance, Scale) {
  const Film usual = film(scene());
  for (const double scale : {1e-3, 1e3, 0.37}) {
    const Difference d = compare(usual, film(moved(scene(), scale, Vec3(0.0))));
    EXPECT_LE(std::abs(d.mean), largest_mean) << scale;
    EXPECT_LE(d.rms, largest_rms) << scale;
  }
}

TEST_P(Invariance, Place) {
  const Film usual = film(scene());
  for (const double distance : {556.0, 5.56e6}) {
    const Vec3 offset(1.001 * distance, -distance / 3.0, 0.3 * distance);
    const Difference d = compare(usual, film(moved(scene(), 1.0, offset)));
    EXPECT_LE(std::abs(d.mean), largest_mean) << distance;
    EXPECT_LE(d.rms, largest_rms) << distance;
  }
}

INSTANTIATE_TEST_SUITE_P(All, Invariance,
                         testing::Combine(testing::Values("cornell", "seed"),
                                          testing::Values(Precision::float32, Precision::float64)),
                         [](const auto& test) {
                           return std::string(std::get<0>(test.param)) +
                                  (std::get<1>(test.param) == Precision::float32 ? "_float"
                                                                                 : "_double");
                         });

// A large mesh hangs below a tree of boxes; the same faces, each a shape of its own, do not. Two
// balls through each other, one a mirror, and a lamp that is a third.
TEST(Tree, FindsWhatTestingEveryFaceFinds) {
  Scene tree;
  tree.shapes = room({-1.5, -1, -1.5}, {1.5, 1.5, 1.5}, diffuse(0.6));
  tree.shapes.push_back(icosphere({0.2, -0.3, 0.1}, 0.6, 3, diffuse(0.7)));
  tree.shapes.push_back(icosphere({0.7, -0.1, 0.3}, 0.5, 2, mirror(0.9)));
  tree.shapes.push_back(icosphere({-0.6, 0.7, 0.3}, 0.25, 1, diffuse(0.4), 5.0));
  tree.camera = camera({-0.7, 0.6, -1.3}, {0.2, -0.2, 0.1}, 70.0, 48);
  Scene list = tree;
  list.shapes.clear();
  for (const Shape& shape : tree.shapes) {
    for (const Polygon& face : std::get<Mesh>(shape.geometry)) {
      list.shapes.push_back({shape.id, Mesh{face}, shape.bsdf, shape.radiance});
    }
  }
  for (const Precision precision : {Precision::float32, Precision::float64}) {
    for (const Method method : {Method::bsdf, Method::mis}) {
      const Settings settings{.method = method, .precision = precision, .bounces = {}};
      EXPECT_EQ(render_film(tree, settings, {0, 16}).mean(),
                render_film(list, settings, {0, 16}).mean())
          << int(method) << int(precision);
    }
  }
}

// A dark room inside a bright one: whatever light is seen has come through the walls, where they
// meet at edges and corners.
TEST(Leaks, AClosedRoomIsDarkInABrightWorld) {
  for (const Precision precision : {Precision::float32, Precision::float64}) {
    for (const Method method : {Method::bsdf, Method::nee, Method::mis}) {
      for (const double turn : {0.0, 0.6}) {
        Scene scene;
        const auto turned = [turn](const Vec3& v) {
          return Vec3(std::cos(turn) * v.x - std::sin(turn) * v.z, v.y,
                      std::sin(turn) * v.x + std::cos(turn) * v.z);
        };
        scene.shapes = room({-1, -1, -1}, {1, 1.5, 1}, diffuse(0.9, true));
        for (Shape& wall : scene.shapes) {
          for (Vec3& corner : std::get<Mesh>(wall.geometry)[0].corners) corner = turned(corner);
        }
        const std::vector<Shape> world = room({-4, -4, -4}, {4, 4, 4}, diffuse(0.0), 1e6);
        scene.shapes.insert(scene.shapes.end(), world.begin(), world.end());
        scene.camera = camera({0, 0, 0}, {1, -1, 1}, 100.0, 64);
        const Film film =
            render_film(scene, {.method = method, .precision = precision, .bounces = {}}, {0, 256});
        EXPECT_EQ(measure(film).mean, 0.0) << int(method) << int(precision) << turn;
      }
    }
  }
}

}  // namespace
}  // namespace plumb::test
