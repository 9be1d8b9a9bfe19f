// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "cli/film_image.h"
#include "cli/interrupt.h"
#include "cli/names.h"
#include "cli/progress_line.h"
#include "cli/scene_options.h"
#include "compare/baseline_tests.h"
#include "compare/comparison.h"
#include "compare/report.h"
#include "renderer/render.h"
#include "scene_files/scene_reader.h"

namespace plumb::cli {
namespace {

struct Options {
  std::vector<std::string> scenes{scene_folder() / "cornell/scene.xml",
                                  scene_folder() / "seed/scene.xml",
                                  scene_folder() / "spheres/scene.xml"};
  std::vector<std::string> faults;
  std::string reference = "plumbline.exr";
  double seconds = 60.0;
};

// With fewer, all replicates may have missed a caustic, and claim that there is no noise.
constexpr int64_t fewest_samples = 16;

// Renders go on until the true change is known well enough, even if the fault was found before.
constexpr int64_t converged_samples = 1024;

// A scene with its picture and the sides of its shapes.
struct HealthyScene {
  Scene scene;
  Picture reference;
  Regions regions;

  HealthyScene(const std::string& file, const std::string& picture) : scene(read_scene(file)) {
    const auto beside = std::filesystem::path(file).replace_filename(picture);
    reference = read_picture("reference", {beside.string()}, "");
    scene.camera.width = reference.image.width;
    scene.camera.height = reference.image.height;
    RegionMask mask = region_mask(scene, RegionKind::side);
    regions = {std::move(mask.names), std::move(mask.regions)};
  }
};

struct Verdicts {
  Comparison comparison;
  BaselineTests baselines;
};

// Whoever looks again and again has many chances of a false alarm: the first look, step 0, gets
// half of them, the next one a quarter, and so on.
Verdicts judge(const Film& film, const HealthyScene& healthy, size_t step) {
  Picture test = to_picture("test", film);
  Picture reference = healthy.reference;
  const auto channels = match(test, reference, {}, false);
  if (!reference.knows_noise()) throw ImageError("the reference doesn't tell its noise");
  const Window whole{0, 0, film.width(), film.height()};
  Judgement judgement;
  judgement.tolerance.value = 0.0;
  judgement.false_alarm /= std::exp2(step + 1);
  return {compare(test, reference, channels, whole, healthy.regions, judgement),
          test_by_baselines(test, reference, static_cast<double>(film.samples_per_pixel()))};
}

// What the fault does to the whole and to the region that it changes most, in two cells.
std::string true_change(const Comparison& comparison) {
  const Finding* worst = nullptr;
  double most = -1.0;
  for (const Finding& f : comparison.regions) {
    const double change = std::abs(f.estimate.difference / f.estimate.reference);
    if (f.channel == "all" && change > most) most = change, worst = &f;
  }
  const std::string whole = relative_difference(comparison.image.back().estimate);
  if (worst == nullptr) return whole + " | ";
  return fmt::format("{} | {}: {}", whole, worst->name, relative_difference(worst->estimate));
}

class Plantings {
 public:
  Plantings(const Options& options, const HealthyScene& healthy)
      : options_(options), healthy_(healthy) {}

  // A row of the table; empty if interrupted. The healthy render comes first.
  std::string run(Fault fault, ProgressLine& line) {
    Scene scene = healthy_.scene;
    Settings settings{.seed = 1, .bounces = scene.request.bounces};  // references have seed 0
    if (fault == Fault::none) settings.precision = fitting_precision(scene);  // others want float
    plant(fault, scene, settings);
    Film film(scene.camera.width, scene.camera.height);
    double seconds = 0.0;
    std::string found;
    for (size_t step = 0; true; ++step) {
      const int64_t goal = fewest_samples << step;
      // The first samples take what they take: of fewer all may have missed the same light.
      constexpr double endless = std::numeric_limits<double>::infinity();
      const double left = step == 0 ? endless : options_.seconds - seconds;
      const Limits limits{{film.samples_per_pixel(), goal}, left};
      seconds += render(scene, settings, limits, film, {}, &stop_requested).wall_seconds;
      if (stop_requested) return "";
      line.show(fmt::format("{}, {}: {} spp", scene.name, fault_name(fault), goal));
      const std::string seen = look(fault, spoil(fault, film, scene, settings), seconds, step);
      if (found.empty()) found = seen;
      const bool is_known = !found.empty() && goal >= converged_samples;
      if (is_known || film.samples_per_pixel() < goal || seconds >= options_.seconds) break;
    }
    if (found.empty()) {
      found = fmt::format("not found | with {} spp | in {:.3g} s | {}", film.samples_per_pixel(),
                          seconds, baseline_cells_);
    }
    return fmt::format(
        "| {} | {} | {} | {} |", scene.name, fault_name(fault),
        true_change(judge(spoil(fault, film, scene, settings), healthy_, 0).comparison), found);
  }

 private:
  // The cells that tell how the fault was found, if it is.
  std::string look(Fault fault, const Film& film, double seconds, size_t step) {
    const auto [comparison, baselines] = judge(film, healthy_, step);
    const bool is_different = comparison.verdict == Verdict::different;
    if (fault == Fault::none) healthy_looks_.push_back({baselines, is_different});
    const auto& [healthy, is_healthy_different] =
        healthy_looks_[std::min(step, healthy_looks_.size() - 1)];
    const auto word = [](bool differs, bool healthy_differs) {
      if (!differs) return "same";
      return healthy_differs ? "different, as the healthy" : "different";
    };
    baseline_cells_ =
        fmt::format("{} | {}", word(baselines.rmse, healthy.rmse), word(baselines.z, healthy.z));
    const bool says_nothing = is_healthy_different && fault != Fault::none;
    if (!is_different || says_nothing) return "";
    return fmt::format("{} | {} spp | {:.2g} s | {}", clearest_difference(comparison),
                       film.samples_per_pixel(), seconds, baseline_cells_);
  }

  const Options& options_;
  const HealthyScene& healthy_;
  struct HealthyLook {
    BaselineTests baselines;
    bool is_different;
  };
  std::vector<HealthyLook> healthy_looks_;  // with 16, 32, ... samples
  std::string baseline_cells_;              // what the baseline tests have said last, two cells
};

std::vector<Fault> faults_that_show(const Scene& scene) {
  const bool has_glass = std::ranges::any_of(
      scene.shapes, [](const Shape& shape) { return shape.bsdf.kind == Bsdf::Kind::dielectric; });
  std::vector<Fault> those;
  for (const FaultDescription& known : faults()) {
    if (!known.is_set_up && (has_glass || !known.is_of_glass)) those.push_back(known.fault);
  }
  return those;
}

int run(const Options& options) {
  std::vector<Fault> named;
  for (const std::string& name : options.faults) named.push_back(parse_fault(name));
  std::vector<HealthyScene> scenes;
  for (const std::string& scene : options.scenes) scenes.emplace_back(scene, options.reference);

  listen_for_interrupts();
  ProgressLine line;
  fmt::print(
      "| scene | fault | changes the whole by | most, of regions | named | at | after | RMSE | "
      "z-test |"
      "\n|---|---|---|---|---|---|---|---|---|\n");
  for (const HealthyScene& healthy : scenes) {
    Plantings plantings(options, healthy);
    std::vector<Fault> wanted = named.empty() ? faults_that_show(healthy.scene) : named;
    wanted.insert(wanted.begin(), Fault::none);
    for (const Fault fault : wanted) {
      const std::string row = plantings.run(fault, line);
      if (row.empty()) return 128 + stop_signal;
      fmt::print("{}\n", row);
      std::fflush(stdout);
    }
  }
  return 0;
}

}  // namespace

void add_power(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<Options>();
  CLI::App& command = *app.add_subcommand("power", "Tell how soon 'compare' finds planted faults");
  add_option(command, "SCENE", "", options->scenes,
             "Scene files (default: cornell, seed, spheres)");
  add_option(command, "--fault", "NAME", options->faults,
             "Only these of 'plumb faults' (default: all bugs, those\n"
             "of glass where there is glass)")
      ->check(refused_by(parse_fault));
  add_option(command, "--reference", "FILE", options->reference,
             "Healthy picture with its noise, in or from the scene's\n"
             "folder (default: plumbline.exr)");
  add_option(command, "--time", "SECONDS", options->seconds, number(1e-3, 1e9),
             "Time of rendering for each fault, after the first 16\n"
             "samples (default: 60)");
  command.footer(R"(Examples:
  plumb power
  plumb power reference_scenes/seed/scene.xml --fault tangent-frame
  plumb power scene.xml --reference healthy.exr --time 10

Samples are doubled from 16 on until the averages over the image, the sides of
shapes, blocks or pixels tell that picture and reference differ, tolerance 0.
Ctrl-C keeps the rows that are finished. Exit codes: 0 done, 2 trouble,
130 interrupted.)");
  command.callback([=, &exit_code] { exit_code = run(*options); });
}

}  // namespace plumb::cli
