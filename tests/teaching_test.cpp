// SPDX-License-Identifier: Apache-2.0

// Classical radiosity, as it is taught: constant patches, their whole matrix of form factors, and
// the ways to solve it.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "radiosity/elements.h"
#include "radiosity/eye.h"
#include "radiosity/faces.h"
#include "radiosity/solution.h"
#include "radiosity/teaching/exchange.h"
#include "radiosity/teaching/film.h"
#include "radiosity/teaching/form_factors.h"
#include "radiosity/teaching/patch_picture.h"
#include "radiosity/teaching/patches.h"
#include "scene_files/scene_reader.h"
#include "tests/test_scenes.h"

namespace plumb::radiosity::teaching {
namespace {

using test::diffuse;
using test::parallelogram;

constexpr double pi = std::numbers::pi;
constexpr size_t many = 10000;
const Work quiet{[](const std::string&) {}, nullptr};

Scene scene_of(std::vector<Shape> shapes) {
  Scene scene;
  scene.camera = test::camera({0.1, -0.2, 0.3}, {0.4, 0.5, -0.6}, 70.0, 16);
  scene.shapes = std::move(shapes);
  return scene;
}

// A closed room with a lamp for a ceiling, and a sheet in it that is matte on both sides.
Scene room_with_sheet() {
  std::vector<Shape> shapes = test::room({-1, -1, -1}, {1, 1, 1}, diffuse(0.6));
  shapes[0].bsdf.reflectance = Rgb(0.8, 0.3, 0.1);
  shapes[2].radiance = Rgb(1.0, 2.0, 3.0);
  shapes.push_back(
      parallelogram({-0.4, 0.5, -0.5}, {0.8, -0.9, 0.6}, {0.2, 0.1, 0.7}, diffuse(0.5, true)));
  return scene_of(shapes);
}

// Two plates of unit size, face to face at a distance of 1.
Scene plates() {
  return scene_of({parallelogram({-0.5, -0.5, 0}, {1, 0, 0}, {0, 1, 0}, diffuse(0.5)),
                   parallelogram({-0.5, -0.5, 1}, {0, 1, 0}, {1, 0, 0}, diffuse(0.5))});
}

struct Room {
  Faces faces;
  Patches patches;
  FormFactors raw;
  Exchange exchange;

  Room(const Scene& scene, size_t count)
      : faces(scene),
        patches(Patches::of_about(faces, count, true, many)),
        raw(form_factors(patches, quiet)),
        exchange(patches, raw, quiet) {}
};

double farthest(const Light& a, const Light& b) {
  double most = 0.0;
  for (size_t i = 0; i < a.size(); ++i) most = std::max(most, (a[i] - b[i]).length());
  return most;
}

TEST(FormFactors, OfARowAddUpToOneInAClosedRoom) {
  const Room room(room_with_sheet(), 200);
  for (size_t i = 0; i < room.patches.size(); ++i) {
    EXPECT_NEAR(room.raw.row_sum(i), 1.0, 1e-13);
    EXPECT_NEAR(room.exchange.factors.row_sum(i), 1.0, 1e-13);
  }
}

TEST(FormFactors, AreMadeReciprocalByLittle) {
  const Room room(room_with_sheet(), 200);
  const auto& areas = room.exchange.areas;
  const double before = lack_of_reciprocity(room.raw, areas);
  EXPECT_GT(before, 1e-4);
  EXPECT_LT(before, 0.03);
  EXPECT_LT(lack_of_reciprocity(room.exchange.factors, areas), 1e-15);
}

// Howell's catalogue, C-11.
TEST(FormFactors, BetweenFacingPlatesIsThatOfTheCatalogue) {
  const double expected = 2.0 / pi *
                          (std::log(2.0 / std::sqrt(3.0)) +
                           2.0 * std::sqrt(2.0) * std::atan(1.0 / std::sqrt(2.0)) - pi / 2.0);
  double before = 1.0;
  for (const size_t count : {8, 32, 128}) {
    const Room room(plates(), count);
    double sum = 0.0;
    for (size_t i = 0; i < room.patches.size() / 2; ++i) {
      sum += room.exchange.areas[i] * room.exchange.factors.row_sum(i);
    }
    // Four Gauss points: an order of 4 in the patches' sides.
    EXPECT_LT(std::abs(sum - expected), before / 12.0) << count;
    before = std::abs(sum - expected);
  }
  EXPECT_LT(before, 1e-5);
}

TEST(Hemicube, ComesCloserWithItsResolution) {
  const Room room(room_with_sheet(), 200);
  const size_t patch = room.patches.size() / 2;
  const Element& of = room.patches[patch];
  const std::vector<double> exact = point_factors(room.patches, of.face, of.center);
  double before = 1.0;
  for (const int resolution : {16, 64, 256}) {
    const auto found = Hemicube(room.patches, patch, resolution).factors(exact.size());
    double error = 0.0;
    for (size_t i = 0; i < exact.size(); ++i) error += std::abs(found[i] - exact[i]);
    EXPECT_LT(error, before / 3.0) << resolution;
    before = error;
  }
  EXPECT_LT(before, 0.01);
}

// Each surface reflects and emits the same: then there is the same light everywhere, E / (1 - rho).
TEST(Exchange, IsUniformInACubeWhoseInnerFacesAreAlike) {
  std::vector<Shape> shapes =
      test::room({-1, -1, -1}, {1, 1, 1}, {.reflectance = Rgb(0.2, 0.5, 0.9)});
  for (Shape& shape : shapes) shape.radiance = Rgb(1.0, 2.0, 3.0);
  const Room room(scene_of(shapes), 100);
  const Light light = room.exchange.light();
  const Light expected(light.size(), Rgb(1.25, 4.0, 30.0));
  EXPECT_LT(farthest(light, expected), 1e-10);
  const Rgb radius = room.exchange.spectral_radius();
  EXPECT_LT((radius - Rgb(0.2, 0.5, 0.9)).length(), 1e-12);
}

TEST(Exchange, HasOneSolutionWhicheverWayItIsFound) {
  const Room room(room_with_sheet(), 150);
  const Exchange& exchange = room.exchange;
  const Light expected = exchange.light();
  Light jacobi = exchange.emission, seidel = exchange.emission;
  Shooting shooting(exchange);
  for (int sweep = 0; sweep < 100; ++sweep) exchange.jacobi(jacobi);
  for (int sweep = 0; sweep < 50; ++sweep) exchange.gauss_seidel(seidel);
  for (size_t shot = 0; shot < 30 * exchange.size(); ++shot) shooting.shoot();
  EXPECT_LT(farthest(jacobi, expected), 1e-10);
  EXPECT_LT(farthest(seidel, expected), 1e-10);
  EXPECT_LT(farthest(shooting.light(), expected), 1e-10);
}

TEST(Exchange, KeepsTheBalanceOfEnergy) {
  const Room room(room_with_sheet(), 150);
  const Light light = room.exchange.light();
  // What is not reflected of what arrives is absorbed: (1 - rho) F B, of every patch.
  Rgb emitted(0.0), absorbed(0.0);
  for (size_t i = 0; i < light.size(); ++i) {
    Rgb arriving(0.0);
    for (size_t j = 0; j < light.size(); ++j) {
      arriving += light[j] * room.exchange.factors.row(i)[j];
    }
    emitted += room.exchange.emission[i] * room.exchange.areas[i];
    absorbed += (Rgb(1.0) - room.exchange.reflectance[i]) * arriving * room.exchange.areas[i];
  }
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(absorbed[c] / emitted[c], 1.0, 1e-12);
}

TEST(Exchange, TakesNoMoreThanTheLargestReflectanceIntoTheNextBounce) {
  const Room room(room_with_sheet(), 150);
  const Rgb radius = room.exchange.spectral_radius(), bound = room.exchange.bound();
  EXPECT_EQ(bound, Rgb(0.8, 0.6, 0.6));
  for (int c = 0; c < 3; ++c) {
    EXPECT_LT(radius[c], bound[c]);
    EXPECT_GT(radius[c], 0.5 * bound[c]);
  }
  const BounceRange late{50, 50}, next{51, 51};
  const double fading = room.exchange.power(room.exchange.light(next)) /
                        room.exchange.power(room.exchange.light(late));
  EXPECT_NEAR(fading, std::max({radius.x, radius.y, radius.z}), 1e-3);
}

TEST(Exchange, RefusesLightThatNeverFades) {
  std::vector<Shape> shapes = test::room({-1, -1, -1}, {1, 1, 1}, diffuse(1.0));
  shapes[0].radiance = Rgb(1.0);
  const Room room(scene_of(shapes), 6);
  EXPECT_THROW(room.exchange.light(), std::runtime_error);
}

TEST(Shooting, IsCloserAtFirstWithTheAmbientTerm) {
  const Room room(room_with_sheet(), 150);
  const Light exact = room.exchange.light();
  Shooting shooting(room.exchange);
  for (int shot = 0; shot < 5; ++shot) {
    const double without = room.exchange.error(shooting.light(), exact);
    EXPECT_LT(room.exchange.error(shooting.with_ambient(), exact), 0.5 * without) << shot;
    shooting.shoot();
  }
}

// Patches are constant, so that they are off by their size; their mean over a face is better by an
// order.
TEST(Patches, ComeCloserToLinearElementsWithTheirNumber) {
  const Scene scene = read_scene(PLUMB_SCENES "/goral/scene.xml");
  const Faces faces(scene);
  Elements elements(faces, many);
  const Solution first(elements, Resolution::level(0), {}, nullptr, nullptr, size_t{1} << 30,
                       quiet);
  elements.refine(first.unevenness(), Resolution::level(0).unevenness);
  const Solution linear(elements, Resolution::level(1), {}, nullptr, nullptr, size_t{1} << 30,
                        quiet);
  Eye eye(faces);
  double sum = 0.0, area = 0.0;  // over the floor
  std::vector<double> errors, mean_errors;
  const auto radiance = [&](const Element& patch, size_t q) {
    eye.move_to(patch.face, patch.point[q]);
    return (faces[patch.face].reflectance * (eye.direct() + linear.gather(eye))).x;
  };
  const Patches fine(faces, 0.03 * faces.size(), true, many);
  for (const Element& patch : fine.list()) {
    if (patch.face != 0) continue;
    for (size_t q = 0; q < size_t(patch.points); ++q) {
      sum += patch.area[q] * radiance(patch, q);
      area += patch.area[q];
    }
  }
  for (const double radius : {0.25, 0.125, 0.0625}) {
    const Patches patches(faces, radius * faces.size() / 2.0, true, many);
    const Light light = Exchange(patches, form_factors(patches, quiet), quiet).light();
    double squares = 0.0, mean = 0.0;
    for (size_t i = 0; i < patches.size(); ++i) {
      const Element& patch = patches[i];
      if (patch.face != 0) continue;
      mean += light[i].x * patch.whole;
      for (size_t q = 0; q < size_t(patch.points); ++q) {
        squares += patch.area[q] * std::pow(light[i].x - radiance(patch, q), 2);
      }
    }
    errors.push_back(std::sqrt(squares / area) / (sum / area));
    mean_errors.push_back(std::abs(mean - sum) / sum);
  }
  for (size_t k = 1; k < errors.size(); ++k) {
    EXPECT_NEAR(std::log2(errors[k - 1] / errors[k]), 1.0, 0.2) << k;
    EXPECT_GT(std::log2(mean_errors[k - 1] / mean_errors[k]), 1.6) << k;
  }
}

TEST(Patches, AreCutWhereABlockStandsAndNotIfThatIsLeftOut) {
  const Faces faces(read_scene(PLUMB_SCENES "/cornell/scene.xml"));
  // None of the floor is half below a block: all of its corners are covered, or none inside.
  const auto half_below = [&](const Patches& patches) {
    const std::vector<Vec3> foot{{130, 0, 65}, {82, 0, 225}, {240, 0, 272}, {290, 0, 114}};
    const auto is_below = [&](const Vec3& p) {
      bool is_inside = true;
      for (size_t i = 0; i < 4; ++i) {
        const Vec3 along = foot[(i + 1) % 4] - foot[i], to = p - foot[i];
        is_inside = is_inside && along.cross(to).y > 1e-6 * along.length2();
      }
      return is_inside;
    };
    return std::ranges::count_if(patches.list(), [&](const Element& patch) {
      const auto below = std::ranges::count_if(
          patch.outline(), [&](const Vec3& c) { return is_below(c + (patch.center - c) * 1e-3); });
      return patch.face == 0 && below > 0 && below < patch.size;
    });
  };
  EXPECT_EQ(half_below(Patches::of_about(faces, 300, true, many)), 0);
  EXPECT_GT(half_below(Patches::of_about(faces, 300, false, many)), 5);
}

TEST(Patches, HaveTVerticesWhereLargeMeetSmall) {
  const auto count = [](const Patches& patches) {
    return std::ranges::count(patches.has_t_vertex(), true);
  };
  // A cube's faces are halved alike; what stands on the floor cuts it into unequal parts.
  const Faces plain(scene_of(test::room({-1, -1, -1}, {1, 1, 1}, diffuse(0.5))));
  EXPECT_EQ(count(Patches::of_about(plain, 100, true, many)), 0);
  const Faces cornell(read_scene(PLUMB_SCENES "/cornell/scene.xml"));
  EXPECT_GT(count(Patches::of_about(cornell, 300, true, many)), 10);
}

TEST(Patches, AreInterpolatedLinearlyAlongTheirEdges) {
  const Faces faces(plates());
  const Patches patches = Patches::of_about(faces, 8, true, many);
  const Element& patch = patches[0];
  for (const double part : {0.0, 0.25, 1.0}) {
    const auto weights =
        patches.weights(0, patch.corners[0] * (1.0 - part) + patch.corners[1] * part);
    EXPECT_NEAR(weights[0], 1.0 - part, 1e-5);
    EXPECT_NEAR(weights[1], part, 1e-5);
  }
  const auto middle = patches.weights(0, patch.center);
  for (size_t k = 0; k < 4; ++k) EXPECT_NEAR(middle[k], 0.25, 1e-12);
}

TEST(Film, ShowsTheLightOfPatches) {
  const Scene scene = room_with_sheet();
  const Room room(scene, 100);
  const Film film(room.patches, scene.camera, quiet);
  const Light one(room.patches.size(), Rgb(0.25, 0.5, 0.75));
  const auto flat = film.flat(one), smooth = film.smooth(one);
  ASSERT_EQ(flat.size(), size_t(3 * scene.camera.width * scene.camera.height));
  for (size_t i = 0; i < flat.size(); ++i) {
    EXPECT_NEAR(flat[i], 0.25 * double(i % 3 + 1), 1e-6);
    EXPECT_NEAR(smooth[i], flat[i], 1e-6);
  }
}

TEST(PatchPicture, AgreesWithLinearElementsBounceByBounce) {
  const Scene scene = room_with_sheet();
  for (const BounceRange& bounces : {BounceRange{1, 1}, {2, 2}, {}}) {
    const Settings settings{.bounces = bounces, .level = 0, .most_bytes = size_t{1} << 30};
    const Picture flat = draw_patches(scene, settings, quiet), exact = draw(scene, settings, quiet);
    double flat_sum = 0.0, sum = 0.0;
    for (size_t i = 0; i < flat.rgb.size(); ++i) {
      flat_sum += double{flat.rgb[i]};
      sum += double{exact.rgb[i]};
    }
    EXPECT_NEAR(flat_sum / sum, 1.0, flat.image_floor) << bounces.first;
    EXPECT_LT(flat.image_floor, 0.02);
    EXPECT_LT(flat.error, 0.1);
  }
}

TEST(PatchPicture, GivesTheCoarserOneWhenItIsStopped) {
  std::atomic<bool> stop = false;
  int phases = 0;
  const Work work{[&](const std::string& phase) {
                    if (phase == "form factors, 0 %") stop = ++phases == 2;
                  },
                  &stop};
  const Picture picture =
      draw_patches(room_with_sheet(), {.bounces = {}, .most_bytes = size_t{1} << 30}, work);
  EXPECT_EQ(picture.level, 0);
  EXPECT_EQ(picture.why_ended, "interrupted");
}

TEST(PatchPicture, RefusesAMatrixThatDoesNotFitIntoMemory) {
  try {
    draw_patches(room_with_sheet(), {.bounces = {}, .most_bytes = size_t{1} << 16}, quiet);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("more than 90 patches"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace plumb::radiosity::teaching
