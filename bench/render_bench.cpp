// SPDX-License-Identifier: Apache-2.0

// Speed and accuracy of the renderer's methods and samplers, and of other path tracers, on the
// reference scenes. Columns:
//
//   Msamples/s, Mrays/s   shadow rays are rays too
//   relMSE                mean of (x - r)^2 / (r^2 + 0.01) over channels and pixels at 64 samples
//                         per pixel, against a picture r of 4096 whose own noise is subtracted;
//                         pixels that see a lamp directly are left out
//   relMSE*s              the same times the seconds that it took: variance x time
#include <fmt/format.h>

#include <atomic>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "images/relative_error.h"
#include "images/rgb.h"
#include "other_renderers/runner.h"
#include "renderer/film.h"
#include "renderer/render.h"
#include "renderer/trace.h"
#include "scene_files/scene_reader.h"

namespace plumb {
namespace {

constexpr int samples_per_pixel = 64;
constexpr int renders = 7;
constexpr int seeds = 4;  // of other programs

Film draw(const Scene& scene, const Settings& settings, int64_t samples, Cost& cost) {
  Film film(scene.camera.width, scene.camera.height);
  cost = render(scene, settings, {.samples = {0, samples}}, film);
  return film;
}

struct Truth {
  Scene scene;
  std::vector<float> mean;
  std::vector<float> variance;
  std::vector<bool> sees_lamp;  // a value for each of mean's
};

const Truth& truth(const std::string& name) {
  static std::map<std::string, Truth> truths;
  if (const auto found = truths.find(name); found != truths.end()) return found->second;
  Truth& r = truths[name];
  Cost cost;
  r.scene = read_scene(PLUMB_SCENES "/" + name + "/scene.xml");
  const Film film = draw(r.scene, {.seed = 1u << 30, .bounces = {}}, 4096, cost);
  r.mean = film.mean();
  r.variance = film.variance();
  for (const float emitted : draw(r.scene, {.bounces = {0, 0}}, 64, cost).mean()) {
    r.sees_lamp.push_back(emitted > 0.0f);
  }
  return r;
}

double relative_mse(const std::vector<float>& mean, const Truth& r) {
  double sum = 0.0;
  double count = 0.0;
  for (size_t i = 0; i < mean.size(); ++i) {
    if (r.sees_lamp[i]) continue;
    const auto expected = double{r.mean[i]};
    const double difference = double{mean[i]} - expected;
    sum += relative_square(difference * difference - double{r.variance[i]}, expected);
    count += 1.0;
  }
  return sum / count;
}

struct Result {
  double samples_per_second = 0.0;
  double rays_per_second = 0.0;  // 0: not known
  double error = 0.0;            // relMSE
  double variance_time = 0.0;
};

Result measure(const std::string& scene, Settings settings) {
  const Truth& r = truth(scene);
  Cost cost, total;
  draw(r.scene, settings, samples_per_pixel, cost);  // to warm up
  double error = 0.0;
  for (settings.seed = 0; settings.seed < renders; ++settings.seed) {
    const Film film = draw(r.scene, settings, samples_per_pixel, cost);
    total.wall_seconds += cost.wall_seconds;
    total.samples += cost.samples;
    total.rays += cost.rays;
    error += relative_mse(film.mean(), r) / renders;
  }
  return {static_cast<double>(total.samples) / total.wall_seconds,
          static_cast<double>(total.rays) / total.wall_seconds, error,
          error * total.wall_seconds / renders};
}

// All samples of all seeds are in one picture, so that variance x time is that of one.
Result measure_other(const std::string& scene, const OtherRenderer& renderer) {
  const Truth& r = truth(scene);
  const std::atomic<bool> never{false};
  const Reference reference = render_reference(
      renderer, r.scene, PLUMB_SCENES "/" + scene + "/scene.xml",
      {.samples_per_pixel = samples_per_pixel, .seeds = seeds, .bounces = {}},
      std::filesystem::temp_directory_path() / "render_bench.log", {[](const auto&) {}, never});
  const double samples = static_cast<double>(r.mean.size()) / 3.0 * reference.samples_per_pixel;
  const double error = seeds * relative_mse(rgb_of(reference.image), r);
  return {samples / reference.wall_seconds, 0.0, error, error * reference.wall_seconds / seeds};
}

// A table that can stand in a document as it is.
class Table {
 public:
  // Only the rows whose names hold `wanted`.
  explicit Table(const std::string& wanted) : wanted_(wanted) {
    fmt::print("256x256, {} samples per pixel, {}\n\n", samples_per_pixel, trace_target());
    fmt::print("| scene/method/sampler | Msamples/s | Mrays/s | relMSE | relMSE x s |\n");
    fmt::print("|---|---|---|---|---|\n");
  }

  void add(const std::string& row, const std::function<Result()>& measure_row) {
    if (row.find(wanted_) == std::string::npos) return;
    try {
      const Result result = measure_row();
      const double rays = result.rays_per_second / 1e6;
      fmt::print("| {} | {:.2f} | {} | {:.2e} | {:.2e} |\n", row, result.samples_per_second / 1e6,
                 rays > 0.0 ? fmt::format("{:.0f}", rays) : "", result.error, result.variance_time);
      results_[row] = result;
    } catch (const std::runtime_error& problem) {
      fmt::print("| {} | {} |||||\n", row, problem.what());
    }
    std::fflush(stdout);
  }

  void compare() const {
    fmt::print("\n");
    for (const auto& [row, result] : results_) {
      const auto ours = results_.find(row.substr(0, row.find('/')) + "/mis/sobol");
      if (ours == results_.end() || row == ours->first) continue;
      fmt::print("{}: {:.2f} times the samples/s of {}, {:.3g} times less variance x time\n",
                 ours->first, ours->second.samples_per_second / result.samples_per_second, row,
                 result.variance_time / ours->second.variance_time);
    }
  }

 private:
  std::string wanted_;
  std::map<std::string, Result> results_;
};

void add_rows(Table& table, const std::vector<OtherRenderer>& others) {
  const auto add = [&](const std::string& row, const std::string& scene, const Settings& settings) {
    table.add(row, [&] { return measure(scene, settings); });
  };
  const std::map<std::string, Method> methods{
      {"bsdf", Method::bsdf}, {"nee", Method::nee}, {"mis", Method::mis}};
  const std::map<std::string, Sampler> samplers{{"independent", Sampler::independent},
                                                {"sobol", Sampler::sobol}};
  for (const std::string scene : {"cornell", "seed"}) {
    for (const auto& [method_name, method] : methods) {
      for (const auto& [sampler_name, sampler] : samplers) {
        add(scene + "/" + method_name + "/" + sampler_name, scene,
            {.method = method, .sampler = sampler, .bounces = {}});
      }
    }
  }
  for (const std::string scene : {"spheres", "metals"}) {
    add(scene + "/mis/sobol", scene, {.bounces = {}});
  }
  for (const std::string scene : {"cornell", "seed", "spheres", "metals"}) {
    for (const OtherRenderer& renderer : others) {
      if (!renderer.has_samples) continue;
      table.add(scene + "/" + renderer.name, [&] { return measure_other(scene, renderer); });
    }
  }
  add("cornell/mis/sobol/double", "cornell", {.precision = Precision::float64, .bounces = {}});
  add("cornell/mis/sobol/1 thread", "cornell", {.bounces = {}, .threads = 1});
}

}  // namespace
}  // namespace plumb

// Takes a part of the names of the rows that are wanted, else all are; and descriptions of other
// renderers (docs/renderers.md), which end in .toml.
int main(int argc, char** argv) {
  std::vector<plumb::OtherRenderer> others = plumb::other_renderers();
  std::string wanted;
  for (const std::string& argument : std::vector<std::string>(argv + 1, argv + argc)) {
    if (argument.ends_with(".toml")) {
      others.push_back(plumb::other_renderer(argument));
    } else {
      wanted = argument;
    }
  }
  plumb::Table table(wanted);
  plumb::add_rows(table, others);
  table.compare();
}
