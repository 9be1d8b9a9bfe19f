// SPDX-License-Identifier: Apache-2.0

// Random small scenes, in which all methods, samplers and precisions must agree: what nobody has
// thought of. With each capability of the renderer the scenes grow by it.
//
// PLUMB_DIFFERENTIAL_SCENES=N tries N scenes of each kind, and with PLUMB_DIFFERENTIAL_MITSUBA=1
// Mitsuba draws them, too (make differential).
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "other_renderers/runner.h"
#include "scene_files/scene_reader.h"
#include "tests/test_scenes.h"

namespace plumb::test {
namespace {

namespace fs = std::filesystem;

constexpr int size = 24;
constexpr int block = 8;

// Writes scenes as text, so that other programs draw them, too.
class RandomScene {
 public:
  RandomScene(uint64_t seed, fs::path folder) : random_(seed), folder_(std::move(folder)) {}

  // A room with open sides, one to three lamps and one to four other things, everything anywhere:
  // through each other, through the walls, before the camera.
  fs::path write_room() {
    text_ = header(pick<std::string>({R"(<rfilter type="box"/>)", R"(<rfilter type="tent"/>)"}));
    wall(R"(<scale value="3"/><rotate x="1" angle="-90"/>)");
    if (chance(0.75)) wall(R"(<scale value="3"/><translate y="1.5" z="-2"/>)");
    if (chance(0.75)) wall(R"(<scale value="3"/><rotate x="1" angle="90"/><translate y="3.2"/>)");
    if (chance(0.75)) {
      wall(R"(<scale value="3"/><rotate y="1" angle="90"/><translate x="-2.2" y="1.5"/>)");
    }
    const int lamps = whole(1, 3);
    const int things = whole(1, 4);
    for (int i = 0; i < lamps; ++i) thing(bsdf(true), emitter(color(1, 8)));
    for (int i = 0; i < things; ++i) thing(bsdf(false), "");
    return save();
  }

  // A closed room in which everything, with an outside alone, reflects a and emits 1: radiance is
  // 1 / (1 - a) everywhere.
  fs::path write_furnace(double albedo) {
    text_ = header(R"(<rfilter type="box"/>)");
    const std::string grey =
        fmt::format(R"(<bsdf type="diffuse"><rgb name="reflectance" value="{}"/></bsdf>)", albedo);
    const std::string glow = emitter("1");
    text_ +=
        R"(<shape type="cube"><boolean name="flip_normals" value="true"/>)"
        R"(<transform name="to_world"><scale value="4"/><translate y="1.5" z="1"/></transform>)" +
        grey + glow + "</shape>";
    for (int i = whole(1, 5); i > 0; --i) {
      solid(grey, glow);
    }
    const std::string mirror = R"(<bsdf type="conductor"/>)";
    if (chance(0.5)) solid(mirror, "");
    return save();
  }

 private:
  double number(double low, double high) {
    return low + (high - low) * std::generate_canonical<double, 53>(random_);
  }
  int whole(int low, int high) { return low + static_cast<int>(number(0, high - low + 1)); }
  bool chance(double probability) { return number(0, 1) < probability; }
  template <typename T>
  T pick(const std::vector<T>& from) {
    return from[size_t(whole(0, static_cast<int>(from.size()) - 1))];
  }

  std::string color(double low, double high) {
    const double r = number(low, high), g = number(low, high), b = number(low, high);
    return fmt::format("{:.3f}, {:.3f}, {:.3f}", r, g, b);
  }
  static std::string emitter(const std::string& radiance) {
    return fmt::format(R"(<emitter type="area"><rgb name="radiance" value="{}"/></emitter>)",
                       radiance);
  }
  std::string bsdf(bool is_lamp) {
    if (is_lamp && chance(0.1)) return "";
    const bool is_matte = is_lamp || chance(0.75);
    const std::string tint = is_lamp && chance(0.4) ? "0" : color(is_matte ? 0.05 : 0.6, 0.9);
    const std::string plain = fmt::format(R"(<bsdf type="{}"><rgb name="{}" value="{}"/></bsdf>)",
                                          is_matte ? "diffuse" : "conductor",
                                          is_matte ? "reflectance" : "specular_reflectance", tint);
    return chance(0.5) ? R"(<bsdf type="twosided">)" + plain + "</bsdf>" : plain;
  }
  std::string header(const std::string& filter) {
    return fmt::format(
        R"(<scene version="3.0.0"><sensor type="perspective"><float name="fov" value="60"/>)"
        R"(<transform name="to_world"><lookat origin="{:.2f}, 1.5, 4.5" target="0, 1.4, 0" )"
        R"(up="0, 1, 0"/></transform><film type="hdrfilm"><integer name="width" value="{}"/>)"
        R"(<integer name="height" value="{}"/>{}</film></sensor>)",
        number(-0.8, 0.8), size, size, filter);
  }
  std::string place(double scale) {
    const double x = scale * number(0.4, 1), y = scale * number(0.4, 1), z = scale * number(0.4, 1);
    std::string turn;
    if (chance(0.7)) {
      Vec3 axis(number(-1, 1), number(-1, 1), number(-1, 1));
      axis.normalize();
      turn = fmt::format(R"(<rotate x="{:.15f}" y="{:.15f}" z="{:.15f}" angle="{:.2f}"/>)", axis.x,
                         axis.y, axis.z, number(0, 360));
    }
    return fmt::format(R"(<transform name="to_world"><scale x="{}" y="{}" z="{}"/>{})"
                       R"(<translate x="{:.3f}" y="{:.3f}" z="{:.3f}"/></transform>)",
                       x, y, z, turn, number(-1.5, 1.5), number(0.3, 2.7), number(-1.5, 1));
  }
  void shape(const std::string& type, const std::string& inside) {
    text_ += fmt::format("<shape type=\"{}\">{}</shape>\n", type, inside);
  }
  void wall(const std::string& steps) {
    shape("rectangle", fmt::format(R"(<transform name="to_world">{}</transform>)"
                                   R"(<bsdf type="twosided"><bsdf type="diffuse">)"
                                   R"(<rgb name="reflectance" value="{}"/></bsdf></bsdf>)",
                                   steps, color(0.05, 0.85)));
  }
  void thing(const std::string& surface, const std::string& glow) {
    const double kind = number(0, 1);
    if (kind < 0.35) return shape("rectangle", place(0.7) + surface + glow);
    if (kind < 0.5) return mesh("v -1 -1 0\nv 1 -1 0\nv 0.2 1 0\nf 1 2 3\n", surface, glow);
    if (kind < 0.6) {
      return mesh("v -1 -1 0\nv 1 -1 0\nv 0.4 0.9 0\nv -0.6 0.7 0\nf 1 2 3 4\n", surface, glow);
    }
    solid(surface, glow);
  }
  void solid(const std::string& surface, const std::string& glow) {
    const double kind = number(0, 1);
    if (kind < 0.3) return shape("cube", place(0.5) + surface + glow);
    if (kind < 0.5) return mesh(ball(), surface, glow);
    shape("sphere", fmt::format(R"(<point name="center" x="{:.3f}" y="{:.3f}" z="{:.3f}"/>)"
                                R"(<float name="radius" value="{:.3f}"/>{}{})",
                                number(-1.5, 1.5), number(0.3, 2.7), number(-1.5, 1),
                                number(0.15, 0.6), surface, glow));
  }
  void mesh(const std::string& obj, const std::string& surface, const std::string& glow) {
    const std::string name = fmt::format("mesh{}.obj", meshes_++);
    std::ofstream(folder_ / name) << obj;
    shape("obj", fmt::format(R"(<string name="filename" value="{}"/>)"
                             R"(<boolean name="face_normals" value="true"/>)",
                             name) +
                     place(0.6) + surface + glow);
  }
  // 20 faces, or 80, which hang below a tree.
  std::string ball() {
    std::string obj;
    int vertices = 0;
    const Shape faces = icosphere({0, 0, 0}, 1.0, whole(0, 1), {});
    for (const Polygon& face : std::get<Mesh>(faces.geometry)) {
      for (const Vec3& c : face.corners) obj += fmt::format("v {} {} {}\n", c.x, c.y, c.z);
      obj += fmt::format("f {} {} {}\n", vertices + 1, vertices + 2, vertices + 3);
      vertices += 3;
    }
    return obj;
  }
  fs::path save() const {
    std::ofstream(folder_ / "scene.xml") << text_ << "</scene>\n";
    return folder_ / "scene.xml";
  }

  std::mt19937_64 random_;
  fs::path folder_;
  std::string text_;
  int meshes_ = 0;
};

// Means and their variances over the whole picture or one of its blocks, R G B.
struct Pool {
  std::array<double, 3> sum{};
  std::array<double, 3> variance{};
};

struct Pools {
  Pool whole;
  std::array<Pool, (size / block) * (size / block)> blocks;
};

Pools pool(const std::vector<float>& mean, const std::vector<float>& variance) {
  Pools pools;
  for (size_t i = 0; i < mean.size(); ++i) {
    const size_t x = i / 3 % size, y = i / 3 / size;
    for (Pool* p : {&pools.whole, &pools.blocks[y / block * (size / block) + x / block]}) {
      p->sum[i % 3] += double{mean[i]};
      p->variance[i % 3] += double{variance[i]};
    }
  }
  return pools;
}

// By how many standard errors they differ, where they differ by more than a part of the value:
// that much variance is not seen by four replicates where lamps are small and seldom met.
double difference(const Pool& a, const Pool& b, double negligible) {
  double most = 0.0;
  for (size_t c = 0; c < 3; ++c) {
    const double d = std::abs(a.sum[c] - b.sum[c]);
    if (d <= negligible * std::abs(b.sum[c]) + 1e-9) continue;
    most = std::max(most, d / std::sqrt(a.variance[c] + b.variance[c] + 1e-30));
  }
  return most;
}

// A test of 60 scenes holds some 10,000 differences of blocks and 1,000 of pictures against each
// other; the chance that one of normal ones is as large is below 1e-4.
void expect_agreement(const Pools& a, const Pools& b, const std::string& what) {
  EXPECT_LT(difference(a.whole, b.whole, 0.0015), 5.5) << what;
  for (size_t i = 0; i < a.blocks.size(); ++i) {
    EXPECT_LT(difference(a.blocks[i], b.blocks[i], 0.01), 7.0) << what << ", block " << i;
  }
}

int scenes_to_try(int usual) {
  const char* asked = std::getenv("PLUMB_DIFFERENTIAL_SCENES");
  return asked == nullptr ? usual : std::atoi(asked);
}

class Differential : public testing::TestWithParam<int> {
 protected:
  Differential() {
    folder_ = fs::temp_directory_path() / fmt::format("plumb_differential_{}", getpid());
    fs::create_directories(folder_);
  }
  ~Differential() override {
    if (!HasFailure()) fs::remove_all(folder_);
  }

  static Pools draw(const Scene& scene, Settings settings, int64_t samples) {
    const Film film = render_film(scene, settings, {0, samples});
    return pool(film.mean(), film.variance());
  }

  void hold_against_mitsuba(const Scene& scene, const fs::path& file, const Pools& ours,
                            const std::string& what) const {
    const char* is_asked = std::getenv("PLUMB_DIFFERENTIAL_MITSUBA");
    if (is_asked == nullptr || *is_asked == '\0') return;
    const std::atomic<bool> stop{false};
    const Reference reference =
        render_reference(other_renderer("mitsuba"), scene, file,
                         {.samples_per_pixel = 1024, .seeds = 4, .first_seed = 1},
                         folder_ / "mitsuba.log", {[](const std::string&) {}, stop});
    std::vector<float> mean, variance;
    for (size_t i = 0; i < reference.image.values.size(); i += 6) {
      const float* v = &reference.image.values[i];
      mean.insert(mean.end(), v, v + 3);
      variance.insert(variance.end(), v + 3, v + 6);
    }
    expect_agreement(ours, pool(mean, variance), what + " Mitsuba");
  }

  static Settings plain(uint32_t seed) {
    return {.method = Method::plain,
            .sampler = Sampler::independent,
            .precision = Precision::float64,
            .seed = seed,
            .bounces = {}};
  }

  fs::path folder_;
};

constexpr Method methods[] = {Method::bsdf, Method::nee, Method::mis};
constexpr int parts = 4;  // run beside each other

TEST_P(Differential, MethodsSamplersAndPrecisionsAgree) {
  for (int i = GetParam(); i < scenes_to_try(60); i += parts) {
    const fs::path file = RandomScene(uint64_t(i), folder_).write_room();
    const Scene scene = read_scene(file);
    uint32_t seed = 0;
    const auto settings = [&](Method method, Precision precision) {
      const Sampler sampler = ++seed % 2 == 0 ? Sampler::sobol : Sampler::independent;
      return Settings{.method = method,
                      .sampler = sampler,
                      .precision = precision,
                      .seed = seed,
                      .bounces = {}};
    };
    const Pools truth = draw(scene, settings(Method::bsdf, Precision::float64), 4096);
    for (const Method method : methods) {
      for (const Precision precision : {Precision::float32, Precision::float64}) {
        const int64_t samples = method == Method::bsdf ? 2048 : 512;
        expect_agreement(
            draw(scene, settings(method, precision), samples), truth,
            fmt::format("scene {} method {} precision {}", i, int(method), int(precision)));
      }
    }
    expect_agreement(draw(scene, plain(++seed), 128), truth, fmt::format("scene {} plain", i));
    const Pools ours = draw(scene, settings(Method::mis, Precision::float64), 4096);
    hold_against_mitsuba(scene, file, ours, fmt::format("scene {}", i));
    if (HasFailure()) FAIL() << "the scene is kept: " << file;
  }
}

TEST_P(Differential, FurnacesAreEven) {
  for (int i = GetParam(); i < scenes_to_try(28); i += parts) {
    const double albedo = 0.3 + 0.6 * (i % 7) / 7.0;
    const fs::path file = RandomScene(uint64_t(1000 + i), folder_).write_furnace(albedo);
    const Scene scene = read_scene(file);
    Pools truth;
    truth.whole.sum.fill(size * size / (1.0 - albedo));
    for (Pool& b : truth.blocks) b.sum.fill(block * block / (1.0 - albedo));
    for (const Method method : methods) {
      for (const Precision precision : {Precision::float32, Precision::float64}) {
        const Settings settings{
            .method = method, .precision = precision, .seed = uint32_t(i), .bounces = {}};
        expect_agreement(
            draw(scene, settings, 256), truth,
            fmt::format("furnace {} method {} precision {}", i, int(method), int(precision)));
      }
    }
    expect_agreement(draw(scene, plain(uint32_t(i)), 64), truth,
                     fmt::format("furnace {} plain", i));
    if (HasFailure()) FAIL() << "the scene is kept: " << file;
  }
}

INSTANTIATE_TEST_SUITE_P(Part, Differential, testing::Range(0, parts));

}  // namespace
}  // namespace plumb::test
