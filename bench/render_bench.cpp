// Speed and accuracy of the renderer's methods and samplers, and of other path tracers, on the
// reference scenes. Columns:
//
//   Msamples/s, Mrays/s   shadow rays are rays too
//   relMSE                mean of (x - r)^2 / (r^2 + 0.01) over channels and pixels at 64 samples
//                         per pixel, against a picture r of 4096 whose own noise is subtracted;
//                         pixels that see a lamp directly are left out
//   relMSE*s              the same times the seconds that it took: variance x time
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <hwy/targets.h>

#include <atomic>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

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
    sum += (difference * difference - double{r.variance[i]}) / (expected * expected + 1e-2);
    count += 1.0;
  }
  return sum / count;
}

std::vector<float> rgb(const Image& image) {
  std::vector<float> values;
  for (size_t i = 0; i < image.values.size(); i += image.channels.size()) {
    values.insert(values.end(), &image.values[i], &image.values[i] + 3);
  }
  return values;
}

void measure(benchmark::State& state, const std::string& name, const Settings& settings) {
  const Truth& r = truth(name);
  Cost warm_up;
  draw(r.scene, settings, samples_per_pixel, warm_up);
  Cost total;
  double error = 0.0;
  uint32_t seed = 0;
  for (auto _ : state) {
    Settings seeded = settings;
    seeded.seed = seed++;
    Cost cost;
    const Film film = draw(r.scene, seeded, samples_per_pixel, cost);
    state.SetIterationTime(cost.wall_seconds);
    total.wall_seconds += cost.wall_seconds;
    total.samples += cost.samples;
    total.rays += cost.rays;
    error += relative_mse(film.mean(), r) / renders;
  }
  state.counters["Msamples/s"] = static_cast<double>(total.samples) / 1e6 / total.wall_seconds;
  state.counters["Mrays/s"] = static_cast<double>(total.rays) / 1e6 / total.wall_seconds;
  state.counters["relMSE"] = error;
  state.counters["relMSE*s"] = error * total.wall_seconds / renders;
}

// All samples of all seeds are in one picture, so that variance x time is that of one.
void measure_other(benchmark::State& state, const std::string& name,
                   const OtherRenderer& renderer) {
  const Truth& r = truth(name);
  const ReferenceSettings settings{
      .samples_per_pixel = samples_per_pixel, .seeds = seeds, .bounces = {}};
  const std::atomic<bool> never{false};
  for (auto _ : state) {
    try {
      const Reference reference =
          render_reference(renderer, r.scene, PLUMB_SCENES "/" + name + "/scene.xml", settings,
                           std::filesystem::temp_directory_path() / "render_bench.log",
                           {[](const std::string&) {}, never});
      state.SetIterationTime(reference.wall_seconds);
      const auto pixels = static_cast<double>(r.mean.size()) / 3.0;
      const double samples = pixels * reference.samples_per_pixel;
      const double error = seeds * relative_mse(rgb(reference.image), r);
      state.counters["Msamples/s"] = samples / 1e6 / reference.wall_seconds;
      state.counters["relMSE"] = error;
      state.counters["relMSE*s"] = error * reference.wall_seconds / seeds;
    } catch (const std::runtime_error& problem) {
      state.SetLabel(problem.what());  // what an error is called depends on the library's version
    }
  }
}

void add_row(const std::string& row, const std::string& scene, const Settings& settings) {
  const auto run = [=](benchmark::State& state) { measure(state, scene, settings); };
  benchmark::RegisterBenchmark(row.c_str(), run)->Iterations(renders)->UseManualTime();
}

void add_rows() {
  const std::map<std::string, Method> methods{
      {"bsdf", Method::bsdf}, {"nee", Method::nee}, {"mis", Method::mis}};
  const std::map<std::string, Sampler> samplers{{"independent", Sampler::independent},
                                                {"sobol", Sampler::sobol}};
  for (const char* scene : {"cornell", "seed"}) {
    for (const auto& [method_name, method] : methods) {
      for (const auto& [sampler_name, sampler] : samplers) {
        add_row(fmt::format("{}/{}/{}", scene, method_name, sampler_name), scene,
                {.method = method, .sampler = sampler, .bounces = {}});
      }
    }
  }
  for (const char* scene : {"cornell", "seed"}) {
    for (const OtherRenderer& renderer : other_renderers()) {
      if (!renderer.has_samples) continue;
      const auto run = [=, &renderer](benchmark::State& state) {
        measure_other(state, scene, renderer);
      };
      benchmark::RegisterBenchmark(fmt::format("{}/{}", scene, renderer.name).c_str(), run)
          ->Iterations(1)
          ->UseManualTime();
    }
  }
  add_row("cornell/mis/sobol/double", "cornell", {.precision = Precision::float64, .bounces = {}});
  add_row("cornell/mis/sobol/1 thread", "cornell", {.bounces = {}, .threads = 1});
}

// A table that can stand in a document as it is.
class TableReporter : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context&) override {
    fmt::print("256x256, {} samples per pixel, {}\n\n", samples_per_pixel, trace_target());
    fmt::print("| scene/method/sampler | Msamples/s | Mrays/s | relMSE | relMSE x s |\n");
    fmt::print("|---|---|---|---|---|\n");
    return true;
  }

  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      const std::string& row = run.run_name.function_name;
      if (run.counters.empty()) {
        fmt::print("| {} | {} |||||\n", row, run.report_label);
        continue;
      }
      const auto value = [&](const char* name, const char* format) {
        const auto counter = run.counters.find(name);
        return counter == run.counters.end()
                   ? ""
                   : fmt::format(fmt::runtime(format), counter->second.value);
      };
      fmt::print("| {} | {} | {} | {} | {} |\n", row, value("Msamples/s", "{:.2f}"),
                 value("Mrays/s", "{:.0f}"), value("relMSE", "{:.2e}"),
                 value("relMSE*s", "{:.2e}"));
      results_[row] = {run.counters.at("Msamples/s").value, run.counters.at("relMSE*s").value};
    }
    std::fflush(stdout);
  }

  void Finalize() override {
    fmt::print("\n");
    for (const auto& [row, result] : results_) {
      const auto ours = results_.find(row.substr(0, row.find('/')) + "/mis/sobol");
      if (ours == results_.end() || row == ours->first) continue;
      fmt::print("{}: {:.2f} times the samples/s of {}, {:.3g} times less variance x time\n",
                 ours->first, ours->second.rate / result.rate, row,
                 result.variance_time / ours->second.variance_time);
    }
  }

 private:
  struct Result {
    double rate;
    double variance_time;
  };
  std::map<std::string, Result> results_;
};

}  // namespace
}  // namespace plumb

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  plumb::add_rows();
  plumb::TableReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  return 0;
}
