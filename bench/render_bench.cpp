// Speed and accuracy of the renderer's methods and samplers on the reference scenes. Columns:
//
//   Msamples/s, Mrays/s   shadow rays are rays too
//   relMSE                mean of (x - r)^2 / (r^2 + 0.01) over channels and pixels at 64 samples
//   per
//                         pixel, against a picture r of 4096 whose own noise is subtracted; pixels
//                         that see a lamp directly are left out
//   relMSE*s              the same times the seconds that it took: variance x time
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <hwy/targets.h>

#include <map>
#include <string>
#include <vector>

#include "renderer/film.h"
#include "renderer/render.h"
#include "renderer/scene_reader.h"
#include "renderer/trace.h"

namespace plumb {
namespace {

constexpr int64_t samples_per_pixel = 64;
constexpr int renders = 7;

Film draw(const Scene& scene, const Settings& settings, int64_t samples, Cost& cost) {
  Film film(scene.camera.width, scene.camera.height);
  cost = render(scene, settings, {.samples = {0, samples}}, film);
  return film;
}

struct Reference {
  Scene scene;
  std::vector<float> mean;
  std::vector<float> variance;
  std::vector<bool> sees_lamp;  // a value for each of mean's
};

const Reference& reference(const std::string& name) {
  static std::map<std::string, Reference> references;
  if (const auto found = references.find(name); found != references.end()) return found->second;
  Reference& r = references[name];
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

double relative_mse(const Film& film, const Reference& r) {
  const std::vector<float> mean = film.mean();
  double sum = 0.0;
  double count = 0.0;
  for (size_t i = 0; i < mean.size(); ++i) {
    if (r.sees_lamp[i]) continue;
    const double truth = double{r.mean[i]};
    const double difference = double{mean[i]} - truth;
    sum += (difference * difference - double{r.variance[i]}) / (truth * truth + 1e-2);
    count += 1.0;
  }
  return sum / count;
}

void measure(benchmark::State& state, const std::string& name, const Settings& settings) {
  const Reference& r = reference(name);
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
    error += relative_mse(film, r) / renders;
  }
  state.counters["Msamples/s"] = static_cast<double>(total.samples) / 1e6 / total.wall_seconds;
  state.counters["Mrays/s"] = static_cast<double>(total.rays) / 1e6 / total.wall_seconds;
  state.counters["relMSE"] = error;
  state.counters["relMSE*s"] = error * total.wall_seconds / renders;
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
      const auto value = [&](const char* name) { return run.counters.at(name).value; };
      const std::string& row = run.run_name.function_name;
      fmt::print("| {} | {:.1f} | {:.0f} | {:.2e} | {:.2e} |\n", row, value("Msamples/s"),
                 value("Mrays/s"), value("relMSE"), value("relMSE*s"));
      rates_[row] = value("Msamples/s");
    }
    std::fflush(stdout);
  }

  void Finalize() override {
    const auto all = rates_.find("cornell/mis/sobol");
    const auto one = rates_.find("cornell/mis/sobol/1 thread");
    if (all == rates_.end() || one == rates_.end()) return;
    fmt::print("\nAll threads do {:.2f} times what one does.\n", all->second / one->second);
  }

 private:
  std::map<std::string, double> rates_;
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
