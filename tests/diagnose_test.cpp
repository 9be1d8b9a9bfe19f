// SPDX-License-Identifier: Apache-2.0

// What may be relied on when a picture is diagnosed: the set-ups are what they say, the statistics
// hold on pictures made of numbers, and `plumb diagnose` names what was planted and nothing else.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <random>
#include <set>
#include <sstream>

#include "cli/diagnosis.h"
#include "cli/suspects.h"
#include "compare/explanation.h"
#include "faults/faults.h"
#include "scene_files/scene_reader.h"
#include "tests/plumb_command.h"
#include "tests/test_scenes.h"

namespace plumb::test {
namespace {

constexpr int side = 16;

Scene small(const std::string& name) {
  Scene scene = read_scene(std::string(PLUMB_SCENES "/") + name + "/scene.xml");
  scene.camera.width = scene.camera.height = side;
  return scene;
}

Film film_of(Scene scene, Fault fault, std::optional<double> number = {}) {
  Settings settings{.seed = 1, .bounces = {}};
  plant(fault, scene, settings, number);
  return spoil(fault, render_film(scene, settings, {0, 16}), scene, settings, number);
}

// Set-ups

TEST(SetUps, ChangeThePictureButWhereTheyCantBeSeen) {
  // The scenes are square, and one-sided already.
  const std::vector<Fault> unseen{Fault::fov_axis, Fault::one_sided_walls};
  const Scene seed = small("seed");
  const Scene cornell = small("cornell");
  for (const FaultDescription& row : faults()) {
    if (!row.is_set_up) continue;
    const Scene& scene = row.fault == Fault::other_diagonal ? cornell : seed;
    const bool is_seen = std::ranges::count(unseen, row.fault) == 0;
    EXPECT_EQ(film_of(scene, row.fault).mean() != film_of(scene, Fault::none).mean(), is_seen)
        << row.name;
  }
  Scene wide = seed;
  wide.camera.height /= 2;
  EXPECT_NE(film_of(wide, Fault::fov_axis).mean(), film_of(wide, Fault::none).mean());
}

TEST(SetUps, TurnedTwiceArePicturesAsBefore) {
  const Scene scene = small("seed");
  const Film film = film_of(scene, Fault::none);
  for (const Fault fault : {Fault::flipped, Fault::mirrored}) {
    const Film once = spoil(fault, film, scene, {});
    EXPECT_NE(once.mean(), film.mean());
    const std::vector<float> first = film.mean(), twice = spoil(fault, once, scene, {}).mean();
    for (size_t i = 0; i < twice.size(); ++i) {
      EXPECT_FLOAT_EQ(twice[i], first[i]);  // but for the rounding of sums
    }
  }
  const std::vector<float> before = film.mean(), after = film_of(scene, Fault::flipped).mean();
  EXPECT_FLOAT_EQ(after[0], before[size_t{side} * (side - 1) * 3]);
}

// White is R = G = B in all of them; what is the same everywhere stays so.
TEST(SetUps, KeepWhatTheyShould) {
  const Scene scene = small("seed");
  Film grey(side, side);
  grey.add_sums(0, 1, std::vector<float>(size_t{side} * side * 3, 0.5F), 1.0);
  for (const Fault fault :
       {Fault::rec2020_primaries, Fault::p3_primaries, Fault::acescg_primaries,
        Fault::mitchell_filter, Fault::blurred, Fault::smeared, Fault::denoised, Fault::clipped}) {
    for (const float value : spoil(fault, grey, scene, {}).mean()) EXPECT_NEAR(value, 0.5F, 1e-4);
  }
}

// The codes of 0.5 are 188 of sRGB and 186 of gamma 2.2.
TEST(SetUps, EncodeThePictureAndNotItsReplicates) {
  const Scene scene = small("seed");
  Film film(side, side);
  film.add_sums(0, 1, std::vector<float>(size_t{side} * side * 3, 0.2F), 1.0);
  film.add_sums(1, 1, std::vector<float>(size_t{side} * side * 3, 0.8F), 1.0);
  for (const auto& [fault, code] :
       {std::pair{Fault::srgb_encoded, 187.5F}, {Fault::gamma_encoded, 186.1F}}) {
    const Film encoded = spoil(fault, film, scene, {});
    EXPECT_NEAR(encoded.mean()[0] * 255.0F, code, 0.1F);
    EXPECT_GT(encoded.variance()[0], 0.0F);
  }
}

// The lamps are dimmed, and the picture is brightened by as much.
TEST(SetUps, ClampAtTheirLevel) {
  const Scene scene = small("seed");
  const std::vector<float> healthy = film_of(scene, Fault::none).mean();
  const std::vector<float> high = film_of(scene, Fault::clamp_indirect, 1024.0).mean();
  const std::vector<float> low = film_of(scene, Fault::clamp_indirect, 0.125).mean();
  double lost = 0.0;
  for (size_t i = 0; i < healthy.size(); ++i) {
    EXPECT_NEAR(high[i], healthy[i], 1e-3 * double{healthy[i]});  // rounding
    lost += double{healthy[i]} - double{low[i]};
  }
  EXPECT_GT(lost, 0.0);
}

TEST(SetUps, SplitAQuadAlongItsOtherDiagonal) {
  Scene scene;
  const Vec3 a(0, 0, 0), b(1, 0, 0), c(1, 1, 0), d(0, 1, 1);
  scene.shapes = {{"quad", Mesh{{{a, b, c}}, {{a, c, d}}}, diffuse(0.5)}};
  Settings settings{.bounces = {}};
  plant(Fault::other_diagonal, scene, settings);
  const Mesh& mesh = std::get<Mesh>(scene.shapes[0].geometry);
  EXPECT_EQ(mesh[0].corners, (std::vector{a, b, d}));
  EXPECT_EQ(mesh[1].corners, (std::vector{b, c, d}));
}

// Before a wall there is a lamp that turns its back to the camera. With the near plane between them
// it is as if one saw through that back: the lamp shines on.
TEST(SetUps, CutWhatIsNearOffFromTheCameraAlone) {
  Scene scene;
  scene.shapes = {parallelogram({-0.5, -0.5, 1}, {1, 0, 0}, {0, 1, 0}, diffuse(0.0), 1.0),
                  parallelogram({-4, -4, 2}, {0, 8, 0}, {8, 0, 0}, diffuse(0.5))};
  scene.camera = camera({0, 0, 0}, {0, 0, 1}, 90.0, side);
  const std::vector<float> healthy = film_of(scene, Fault::none).mean();
  const std::vector<float> cut = film_of(scene, Fault::near_clipped, 0.5).mean();
  scene.camera.sees_through_backs = true;
  const std::vector<float> open = film_of(scene, Fault::none).mean();
  for (size_t i = 0; i < cut.size(); ++i) EXPECT_NEAR(cut[i], open[i], 1e-4);
  constexpr size_t middle = 3 * (side / 2 * side + side / 2);
  EXPECT_EQ(healthy[middle], 0.0F);
  EXPECT_GT(cut[middle], 0.05F);
}

// What the camera sees of lamps and their light stays sharp, and mirrors show what they did.
TEST(SetUps, SmearOnlyTheIndirectLightOfMatteSurfaces) {
  Scene scene = small("seed");
  const auto is_changed = [&](size_t pixel) {
    const std::vector<float> before = film_of(scene, Fault::none).mean();
    const std::vector<float> after = film_of(scene, Fault::smeared_indirect).mean();
    return std::abs(after[3 * pixel] - before[3 * pixel]) > 1e-4F * before[3 * pixel];
  };
  constexpr size_t wall = 4 * side + 8, steel = 12 * side + 5;
  EXPECT_TRUE(is_changed(wall));
  EXPECT_FALSE(is_changed(steel));
  const Settings direct{.seed = 1, .bounces = {0, 1}};
  const Film film = render_film(scene, direct, {0, 16});
  const std::vector<float> before = film.mean();
  const std::vector<float> after = spoil(Fault::smeared_indirect, film, scene, direct).mean();
  for (size_t i = 0; i < before.size(); ++i) EXPECT_FLOAT_EQ(after[i], before[i]);
}

// A wall of albedo 0.5, and a mirror that shows it; both in the dark, and looked at from behind,
// too.
TEST(SetUps, AddAmbientLightWhereMatteSurfacesAreSeen) {
  Scene scene;
  scene.shapes = {parallelogram({-9, -9, 2}, {0, 18, 0}, {18, 0, 0}, diffuse(0.5))};
  scene.camera = camera({0, 0, 0}, {0, 0, 1}, 30.0, side);
  const auto expect = [&](double radiance) {
    for (const float value : film_of(scene, Fault::ambient, 0.2).mean()) {
      EXPECT_FLOAT_EQ(value, static_cast<float>(radiance));
    }
  };
  expect(0.2 * 0.5);
  Polygon& wall = std::get<Mesh>(scene.shapes[0].geometry)[0];
  std::reverse(wall.corners.begin(), wall.corners.end());
  expect(0.0);
  scene.shapes[0].bsdf.two_sided = true;
  expect(0.2 * 0.5);
  Bsdf mirror{.kind = Bsdf::Kind::conductor, .reflectance = Rgb(0.8)};
  scene.shapes.push_back(parallelogram({-1, -1, 1}, {0, 2, 0}, {2, 0, 0}, mirror));
  scene.shapes[0] = parallelogram({-9, -9, -2}, {18, 0, 0}, {0, 18, 0}, diffuse(0.5));
  expect(0.8 * 0.2 * 0.5);
}

// The table

TEST(FaultTable, NamesEachFaultOnce) {
  std::set<std::string> names;
  for (const FaultDescription& row : faults()) {
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    EXPECT_EQ(&description(row.fault), &row);
    for (const std::string* text : {&row.text, &row.made, &row.met, &row.shows}) {
      EXPECT_FALSE(text->empty()) << row.name;
    }
  }
}

// Pictures of numbers

constexpr int large = 64;

// Of 1 plus what `change` says, with independent normal noise of this deviation.
Picture numbers(
    uint64_t seed, double deviation,
    const std::function<double(int, int)>& change = [](int, int) { return 0.0; }) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0.0, 1.0);
  Picture picture{"test", {large, large, {"R", "G", "B"}, {}, {}}, {}, {}, {}};
  for_each_pixel({0, 0, large, large}, [&](int x, int y) {
    for (int c = 0; c < 3; ++c) {
      picture.image.values.push_back(
          static_cast<float>(1.0 + change(x, y) + deviation * noise(random)));
    }
  });
  return picture;
}

// The mean square of 64 * 64 * 3 second differences scatters by 2 % of itself, each block's by 15
// %.
TEST(Explanation, KnowsNoiseByNeighboursBesideASlope) {
  Picture test = numbers(1, 0.1, [](int x, int y) { return 0.02 * x - 0.01 * y; });
  Picture reference = numbers(2, 0.0);
  match(test, reference, {"R", "G", "B"}, false);
  tell_noise_by_neighbours(test, reference);
  double sum = 0.0;
  for (const float variance : test.file_variances) sum += double{variance};
  EXPECT_NEAR(sum / double(test.file_variances.size()), 0.01, 5 * 0.0002);
}

TEST(Explanation, KnowsAFactor) {
  Picture test = numbers(1, 0.1, [](int x, int) { return 0.27 + 0.01 * 1.27 * x; });
  Picture model = numbers(2, 0.0, [](int x, int) { return 0.01 * x; });
  match(test, model, {"R", "G", "B"}, false);
  tell_noise_by_neighbours(test, model);
  const auto factor = Yardstick(test, model).best_factor(test, model);
  EXPECT_NEAR(factor.value, 1.27, 5 * factor.error);
  EXPECT_LT(factor.error, 1e-3);  // 0.1 / 1.3 in each of 12,288 values
}

TEST(Explanation, SeesSharedNoiseThroughAChange) {
  const auto wave = [](int x, int y) { return 0.2 * std::sin(0.1 * x) * std::cos(0.1 * y); };
  Picture test = numbers(1, 0.1, wave), model = numbers(2, 0.0);
  match(test, model, {"R", "G", "B"}, false);
  EXPECT_LT(shared_noise(test, model).sure(), 0.1);
  Image& image = test.image;
  for (size_t i = 0; i + 3 < image.values.size(); ++i) {
    image.values[i] = (image.values[i] + image.values[i + 3]) / 2.0F;
  }
  EXPECT_GT(shared_noise(test, model).sure(), 0.2);
}

// Like paths that meet a lamp by chance: one pixel in fifty has met it, and the others are black,
// where the model has a wave. The squares of 18,000 values' differences scatter by 5 % of
// themselves.
TEST(Explanation, TakesRareLightForNoNoiseThatIsShared) {
  const auto wave = [](int x, int y) { return 0.5 * std::sin(0.1 * x) * std::cos(0.1 * y); };
  Picture test = numbers(1, 0.0), model = numbers(2, 0.0, wave);
  std::mt19937_64 random(3);
  std::bernoulli_distribution is_met(0.02);
  for (float& value : test.image.values) value = is_met(random) ? 50.0F : 0.0F;
  match(test, model, {"R", "G", "B"}, false);
  EXPECT_LT(shared_noise(test, model).sure(), 0.1);
}

// A factor or an offset shifts all differences to one side, and still they tell of a filter.
TEST(Explanation, SeesSharedNoiseBesideAnOffset) {
  Picture test = numbers(1, 0.1, [](int, int) { return 5.0; }), model = numbers(2, 0.0);
  Image& image = test.image;
  for (size_t i = 0; i + 3 < image.values.size(); ++i) {
    image.values[i] = (image.values[i] + image.values[i + 3]) / 2.0F;
  }
  match(test, model, {"R", "G", "B"}, false);
  EXPECT_GT(shared_noise(test, model).sure(), 0.2);
}

TEST(Explanation, LeavesAsMuchAsNoiseOfWhatIsExplained) {
  const auto change = [](int x, int) { return x < 20 ? 0.1 : 0.0; };
  Picture test = numbers(1, 0.1, change), reference = numbers(2, 0.0),
          model = numbers(3, 0.0, change);
  match(test, reference, {"R", "G", "B"}, false);
  match(test, model, {"R", "G", "B"}, false);
  tell_noise_by_neighbours(test, model);
  const Yardstick yardstick(test, reference);
  for (const int cell : {1, 8}) {
    const double values = 3.0 * large * large / cell / cell;
    EXPECT_NEAR(yardstick.squares(test, model, cell), values, 5 * std::sqrt(2 * values));
    EXPECT_NEAR(yardstick.noise(test, cell), values, 5 * std::sqrt(2 * values));
    EXPECT_GT(yardstick.squares(test, reference, cell), values + 10 * std::sqrt(2 * values));
  }
}

// Of 1 plus a change, grey, with normal noise that it tells; where it says so, light is missed.
Picture telling(
    uint64_t seed, double deviation, const std::function<double(int, int)>& change,
    const std::function<bool(int, int)>& misses = [](int, int) { return false; }) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0.0, deviation);
  Picture picture{"test",
                  {large, large, {"R", "G", "B", "variance.R", "variance.G", "variance.B"}, {}, {}},
                  {},
                  {},
                  {}};
  for_each_pixel({0, 0, large, large}, [&](int x, int y) {
    const double value = 1.0 + change(x, y) + noise(random);
    const bool is_lit = !misses(x, y);
    for (int c = 0; c < 3; ++c) picture.image.values.push_back(is_lit ? float(value) : 0.5F);
    for (int c = 0; c < 3; ++c) {
      picture.image.values.push_back(is_lit ? float(deviation * deviation) : 0.0F);
    }
  });
  return picture;
}

double towards(Picture test, Picture reference, Picture model) {
  match(test, model, {"R", "G", "B"}, false);
  match(test, reference, {"R", "G", "B"}, false);
  return Yardstick(test, reference).towards(test, reference, model);
}

const auto unchanged = [](int, int) { return 0.0; };
const auto slightly = [](int x, int y) { return (x / 8 + y / 8) % 2 == 0 ? 0.015 : -0.015; };
const auto in_one_block = [](int x, int y) { return x < 8 && y < 8; };

// A block's average has an error of 0.1 / 8: changed by 0.015, each is 1.2 errors away, all 64 of
// them 9.6.
TEST(Explanation, SeesWhatIsSmallEverywhereInItsDirection) {
  const Picture test = telling(1, 0.1, slightly), reference = telling(2, 0.01, unchanged),
                model = telling(3, 0.02, slightly);
  EXPECT_NEAR(towards(test, reference, model), 9.6, 4.0);
  Picture a = test, b = reference;
  match(a, b, {"R", "G", "B"}, false);
  const Regions none{{}, std::vector<int>(size_t{large} * large, -1)};
  EXPECT_FALSE(agreement(a, b, none, 1e-3, false).is_refuted);
}

// The deviation of 400 numbers is known to 3.5 %; the greatest of their amounts passes 4.5 once in
// 350 times, but for the seeds that are fixed here.
TEST(Explanation, IsNotDrawnInADirectionByNoise) {
  for (const auto& change : {std::function<double(int, int)>(slightly), {unchanged}}) {
    double sum = 0.0, squares = 0.0, most = 0.0;
    constexpr int count = 400;
    for (uint64_t i = 0; i < count; ++i) {
      const double t = towards(telling(3 * i, 0.1, unchanged), telling(3 * i + 1, 0.01, unchanged),
                               telling(3 * i + 2, 0.02, change));
      sum += t;
      squares += t * t;
      most = std::max(most, t);
    }
    EXPECT_LT(std::sqrt(squares / count - std::pow(sum / count, 2.0)), 1.1);
    EXPECT_LT(sum / count, 0.15);
    EXPECT_LT(most, 4.5);
  }
}

// Averages over 3 x 3 pixels tell a ninth of the variance, but those of blocks have nearly all of
// it.
TEST(Explanation, IsNotDrawnInADirectionByNoiseThatPixelsShare) {
  const auto to_the_left = [](int x, int) { return x < large / 2 ? 0.015 : -0.015; };
  double most = 0.0;
  for (uint64_t seed = 0; seed < 400; ++seed) {
    Picture test = telling(3 * seed, 0.1, unchanged);
    const Image sharp = test.image;
    for_each_pixel({1, 1, large - 2, large - 2}, [&](int x, int y) {
      for (size_t c = 0; c < 6; ++c) {
        double sum = 0.0;
        for_each_pixel({x - 1, y - 1, 3, 3}, [&](int u, int v) {
          sum += double{sharp.values[sharp.pixel(u, v) * 6 + c]};
        });
        test.image.values[sharp.pixel(x, y) * 6 + c] = static_cast<float>(sum / (c < 3 ? 9 : 81));
      }
    });
    most = std::max(most, towards(test, telling(3 * seed + 1, 0.01, unchanged),
                                  telling(3 * seed + 2, 0.02, to_the_left)));
  }
  EXPECT_LT(most, 4.5);
}

TEST(Explanation, IsNotDrawnInADirectionByOneBlock) {
  const auto darker = [](int x, int y) { return in_one_block(x, y) ? -0.5 : 0.0; };
  EXPECT_LT(towards(telling(1, 0.1, unchanged, in_one_block), telling(2, 0.01, unchanged),
                    telling(3, 0.01, darker)),
            4.5);
}

// Four deviations of a Gaussian, in whole blocks of 8.
TEST(Suspects, AreJudgedBySquaresAsWideAsTheirNoiseIsShared) {
  using cli::side_without_shared_noise;
  EXPECT_EQ(side_without_shared_noise({{{Fault::five_bounces}}}), 1);
  EXPECT_EQ(side_without_shared_noise({{{Fault::gaussian_filter}}}), 8);
  EXPECT_EQ(side_without_shared_noise({{{Fault::smeared_indirect}}}), 32);
  EXPECT_EQ(side_without_shared_noise({{{Fault::five_bounces}, {Fault::smeared, 2.5}}}), 16);
}

// That noise hides what is left is no reason to claim what explains next to nothing.
TEST(Suspects, AreNotClaimedIfTheyExplainLittle) {
  cli::Diagnosis diagnosis{.reference = Film(8, 8)};
  diagnosis.healthy.is_refuted = true;
  diagnosis.suspects.push_back({.plantings = {{Fault::two_sided_walls}}, .explained = 0.1});
  EXPECT_TRUE(contains(to_text(diagnosis, 0.01),
                       "too noisy to tell what: `two-sided-walls` comes first, but explains 10 %"));
  diagnosis.suspects.front().explained = 0.6;
  EXPECT_TRUE(contains(to_text(diagnosis, 0.01), "same as the reference with `two-sided-walls`"));
  diagnosis.suspects.front().agreement.within = 3.0;
  EXPECT_TRUE(contains(to_text(diagnosis, 0.01), "comes first, but explains 60 %"));
  diagnosis.suspects.front().explained = 0.95;
  EXPECT_TRUE(contains(to_text(diagnosis, 0.01), "like the reference with `two-sided-walls`"));
}

// Margins are wide where neighbours seem to share noise, which a wrong model's rest makes them do.
TEST(Suspects, AreRefutedByWhatIsBetterAndIsRefutedItself) {
  const auto judged = [](Fault fault, double pixels, bool is_refuted) {
    return cli::Suspect{.plantings = {{fault}},
                        .pixels = pixels,
                        .pixels_error = 2.0,
                        .agreement = {.is_refuted = is_refuted, .rest = ""}};
  };
  std::vector<cli::Suspect> suspects{judged(Fault::gaussian_filter, 100.0, true),
                                     judged(Fault::smeared, 119.0, false),
                                     judged(Fault::blurred, 121.0, false)};
  refute_what_is_worse(suspects, &cli::Suspect::pixels, &cli::Suspect::pixels_error);
  EXPECT_FALSE(suspects[1].agreement.is_refuted);
  EXPECT_TRUE(suspects[2].agreement.is_refuted);
  EXPECT_EQ(suspects[2].agreement.rest, "more than with `gaussian-filter`");
}

// The command

class Diagnose : public PlumbCommand {
 protected:
  Result diagnose(const std::string& arguments) const { return plumb("diagnose " + arguments); }

  void render(const std::string& arguments) const {
    const Result result =
        plumb("render " + cornell + " --size 32x32 --spp 1024 --seed 5 -o test.exr " + arguments);
    ASSERT_EQ(result.exit_code, 0) << result.output;
  }

  const std::string cornell = PLUMB_SCENES "/cornell/scene.xml";
};

TEST_F(Diagnose, SaysNothingOfARightPicture) {
  render("");
  const Result result = diagnose("test.exr " + cornell + " --tolerance 20%");
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_TRUE(contains(result.output, "same as the reference, to ")) << result.output;
  EXPECT_TRUE(contains(result.output, "nothing to diagnose")) << result.output;
  const Result strict = diagnose("test.exr " + cornell + " --tolerance 0.01%");
  EXPECT_EQ(strict.exit_code, 3) << strict.output;
  EXPECT_TRUE(contains(strict.output, "inconclusive: no difference")) << strict.output;
}

// Neither of few samples nor of lamps that are met by chance.
TEST_F(Diagnose, TakesNoisyPicturesForUnfiltered) {
  for (const char* how : {"--spp 1", "--spp 1 --method bsdf", "--spp 16 --method bsdf"}) {
    plumb("render " + cornell + " --size 96x96 --seed 5 -o test.exr " + how);
    const Result result = diagnose("test.exr " + cornell);
    EXPECT_EQ(result.exit_code, 3) << how << result.output;
    EXPECT_FALSE(contains(result.output, "share noise")) << how << result.output;
    EXPECT_TRUE(
        contains(result.output, "too noisy to tell anything of some parts: it takes about "))
        << how << result.output;
  }
}

TEST_F(Diagnose, NamesWhatIsWrong) {
  for (const auto& [made, name] :
       {std::pair{"--fault five-bounces", "`five-bounces`"},
        {"--bounces 0:2", "`five-bounces` (2)"},
        {"--fault gamma-reflectance", "`gamma-reflectance`"},
        {"--fault exposure", "`exposure` (3.14"},
        {"--fault near-clipped", "`near-clipped`"},
        {"--fault smeared-indirect", "`smeared-indirect`"},
        {"--fault ambient", "`ambient`, to "},
        {"--fault even-lamp", "`even-lamp`"},
        {"--fault gamma-decoded", "`gamma-decoded`"},
        {"--fault srgb-decoded", "`srgb-decoded`"},
        {"--bounces 0:3 --fault mirrored", "`five-bounces` (3) and `mirrored`"}}) {
    render(made);
    const Result result = diagnose("test.exr " + cornell + " --tolerance 20%");
    EXPECT_EQ(result.exit_code, 1) << made << result.output;
    EXPECT_TRUE(contains(result.output, std::string("same as the reference with ") + name))
        << made << result.output;
  }
}

// A picture that tells nothing of itself, of a scene that no table knows.
// No region or pixel of this small picture shows it beyond doubt.
TEST_F(Diagnose, NamesWhatOnlyItsDirectionShows) {
  ASSERT_EQ(plumb("render " + cornell +
                  " --size 64x64 --spp 64 --seed 77 --fault gaussian-filter -o test.exr")
                .exit_code,
            0);
  const Result result = diagnose("test.exr " + cornell);
  EXPECT_EQ(result.exit_code, 1) << result.output;
  EXPECT_TRUE(
      contains(result.output, "standard errors, seen all together in what `gaussian-filter`"))
      << result.output;
  EXPECT_TRUE(contains(result.output, "like the reference with `gaussian-filter`"))
      << result.output;
}

TEST_F(Diagnose, CallsTheUnknownUnknown) {
  std::ifstream file(PLUMB_SCENES "/seed/scene.xml");
  std::stringstream text;
  text << file.rdbuf();
  std::string other = text.str();
  other.replace(other.find("x=\"142\""), 7, "x=\"200\"");  // the matte sphere
  std::ofstream(folder / "other.xml") << other;
  plumb("render other.xml --size 32x32 --spp 1024 --seed 5 -o test.exr");
  const Result result = diagnose("test.exr " PLUMB_SCENES "/seed/scene.xml -o why");
  EXPECT_EQ(result.exit_code, 1) << result.output;
  EXPECT_TRUE(contains(result.output, "none of these")) << result.output;
  EXPECT_TRUE(contains(result.output, "another version of the scene")) << result.output;
  for (const char* name : {"difference.png", "suspect.png", "rest.png"}) {
    EXPECT_TRUE(std::filesystem::exists(folder / "why" / name)) << name;
  }
}

TEST_F(Diagnose, RefusesWhatIsNoPicture) {
  std::ofstream(folder / "empty.exr") << "";
  for (const std::string picture : {"missing.exr", "empty.exr"}) {
    EXPECT_EQ(diagnose(picture + " " + cornell).exit_code, 2);
  }
}

// `make faults` writes the tables.
TEST_F(Diagnose, ListOfFaultsIsThatOfTheDocument) {
  std::ifstream file(PLUMB_SCENES "/../docs/faults.md");
  std::stringstream document;
  document << file.rdbuf();
  const Result list = plumb("faults");
  EXPECT_EQ(list.exit_code, 0);
  EXPECT_TRUE(contains(document.str(), list.output));
}

}  // namespace
}  // namespace plumb::test
