// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "cli/film_image.h"
#include "cli/interrupt.h"
#include "cli/list_renderers.h"
#include "cli/names.h"
#include "cli/progress_line.h"
#include "cli/scene_options.h"
#include "cli/trial.h"
#include "scene_files/method.h"
#include "scene_files/precision.h"

namespace plumb::cli {
namespace {

namespace fs = std::filesystem;

constexpr double false_alarm = 1e-3;  // the chance that noise alone makes anything biased

struct Options {
  std::string folder = scene_folder() / "stress";
  std::vector<std::string> scenes;
  std::vector<std::string> methods{"bsdf", "nee", "mis", "default", "radiosity"};
  std::vector<std::string> programs;
  std::optional<double> seconds;
  std::optional<int64_t> spp;
};

// Who tries to render the scenes.
struct Contestant {
  std::string name;
  Settings settings;
  std::optional<OtherRenderer> renderer = {};  // none: the settings are for our own
  bool is_default = false;                     // method and precision are those that fit the scene
  bool is_radiosity = false;
};

struct Attempt {
  std::string name;
  Assessment assessment;
  std::optional<SampleTail> tail;
  std::string refusal;  // why there is no assessment
};

struct TriedScene {
  std::string scene;
  std::vector<Attempt> rows;  // of as many contestants as there was time for
};

// Nothing for what is no method of the path tracer.
const Words<std::optional<Method>> contestant_words{
    {"bsdf", Method::bsdf},   {"nee", Method::nee}, {"mis", Method::mis},
    {"plain", Method::plain}, {"default", {}},      {"radiosity", {}}};

fs::path scene_file(const Options& options, const std::string& name) {
  return fs::path(options.folder) / (name + ".xml");
}

void check_scene(const Options& options, const std::string& name) {
  if (fs::exists(scene_file(options, name))) return;
  refuse(name, fmt::format("one of {}", fmt::join(scene_names_in(options.folder), ", ")));
}

void add_options(CLI::App& command, Options& options) {
  const auto add = [&](const std::string& name, auto& target, const char* value,
                       const std::string& help, auto refused) {
    add_option(command, name, value, target, help)->delimiter(',')->check(refused);
  };
  add_option(command, "--folder", "DIR", options.folder,
             "Where the scenes are (default: reference_scenes/stress)");
  add("--scene", options.scenes, "NAME,...", "Only these scenes, by name; can be repeated",
      refused_by([&](const std::string& name) { check_scene(options, name); }));
  add("--methods", options.methods, "M,...",
      "Of bsdf, nee, mis, radiosity and default, which is\n"
      "what 'render' takes for the scene (default: all)",
      refused_by(one_of(contestant_words)));
  const std::string words = list_renderers([](const OtherRenderer& r) { return r.word; });
  add("--with", options.programs, "PROGRAM,...",
      "Other programs too: " + words + ",\nor FILE.toml (docs/renderers.md)",
      refused_by(other_renderer));
  add_option(command, "--time", "SECONDS", options.seconds, number(1e-3, 1e6),
             "For each method on each scene (default: 10)");
  add_option(command, "--spp", "N", options.spp, number<int64_t>(1, largest_sample),
             "Samples per pixel of our methods, at most");
}

void fit(Settings& settings, const Scene& scene) {
  if (chance_suffices(scene)) settings.method = Method::bsdf;
  if (!needs_double(scene).empty()) settings.precision = Precision::float64;
}

std::vector<Contestant> list_contestants(const Options& options) {
  std::vector<Contestant> contestants;
  for (const std::string& method : options.methods) {
    if (method == "default") {
      contestants.push_back({method, {.bounces = {}}, {}, true});
      continue;
    }
    if (method == "radiosity") {
      contestants.push_back({.name = method, .settings = {}, .is_radiosity = true});
      continue;
    }
    for (const Precision precision : {Precision::float32, Precision::float64}) {
      contestants.push_back(
          {method + " " + to_word(precision, precision_words),
           {.method = one_of(method_words)(method), .precision = precision, .bounces = {}}});
    }
  }
  for (const std::string& program : options.programs) {
    contestants.push_back({.name = program, .settings = {}, .renderer = other_renderer(program)});
  }
  return contestants;
}

std::vector<StressScene> read_scenes(const Options& options) {
  std::vector<fs::path> files;
  for (const std::string& name : options.scenes) files.push_back(scene_file(options, name));
  if (files.empty()) files = scene_files_in(options.folder);
  return {files.begin(), files.end()};
}

// Nothing after an interrupt.
std::optional<Attempt> try_out(const Contestant& contestant, const StressScene& stress,
                               const Picture& truth, const Limits& limits, double alarm,
                               ProgressLine& line) {
  const std::string title = fmt::format("{}, {}", stress.scene.name, contestant.name);
  line.show(title);
  const Watcher watcher{[&](const std::string&) { line.show(title); }, stop_requested};
  Attempt row{contestant.name, {}, {}, ""};
  try {
    const std::optional<Trial> trial =
        contestant.renderer
            ? try_renderer(*contestant.renderer, stress.scene, stress.file, limits.seconds, watcher)
        : contestant.is_radiosity
            ? try_radiosity(stress.scene, stop_requested)
            : try_method(stress.scene, contestant.settings, limits, stop_requested);
    if (!trial) return {};
    if (contestant.renderer) row.name = trial->program;
    row.assessment = assess(*trial, truth, alarm);
    row.tail = trial->tail;
  } catch (const std::exception& error) {
    if (!contestant.renderer && !contestant.is_radiosity) throw;
    row.refusal = error.what();
    std::ranges::replace(row.refusal, '\n', ' ');
  }
  return row;
}

std::string verdict(const Attempt& row) {
  if (!row.refusal.empty()) return "-";
  const double seconds = row.assessment.seconds_to_one_percent;
  switch (row.assessment.outcome) {
    case Outcome::holds: return "holds";
    case Outcome::noisy:
      if (seconds < 7200.0) return fmt::format("noisy: 1 % in {:.0f} min", seconds / 60.0);
      if (seconds < 172800.0) return fmt::format("noisy: 1 % in {:.0f} h", seconds / 3600.0);
      return fmt::format("noisy: 1 % in {:.0f} days", seconds / 86400.0);
    case Outcome::biased: return "**biased**";
    case Outcome::breaks: return "**breaks**";
  }
  return "";
}

void print_scene(const TriedScene& tried) {
  const auto& [scene, rows] = tried;
  double least = std::numeric_limits<double>::infinity();
  for (const Attempt& row : rows) {
    if (row.assessment.is_right()) least = std::min(least, row.assessment.cost);
  }
  for (const Attempt& row : rows) {
    if (!row.refusal.empty()) {
      fmt::print("| {} | {} | {} | | | | | {} |\n", scene, row.name, row.refusal, verdict(row));
      continue;
    }
    const Assessment& assessment = row.assessment;
    fmt::print("| {} | {} | {:+.3f} ± {:.3f} % | {} | {} | {} |\n", scene, row.name,
               100.0 * assessment.bias, 100.0 * assessment.error,
               assessment.is_right() && std::isfinite(assessment.cost)
                   ? fmt::format("{:.2g}", least / assessment.cost)
                   : "",
               row.tail ? fmt::format("{:.0f} % | {:.2g} | {}", 100.0 * row.tail->fireflies,
                                      row.tail->kurtosis, row.tail->unfit)
                        : " | | ",
               verdict(row));
  }
}

void print_verdicts(const std::vector<TriedScene>& scenes) {
  std::vector<std::string> heads;
  for (const TriedScene& tried : scenes) {
    heads.resize(std::max(heads.size(), tried.rows.size()));
    for (size_t i = 0; i < tried.rows.size(); ++i) {
      const Attempt& row = tried.rows[i];
      // Who refuses a scene has not said its version.
      if (heads[i].empty() || row.refusal.empty()) heads[i] = row.name;
    }
  }
  fmt::print("\n| scene | {} |\n|---|", fmt::join(heads, " | "));
  for (size_t i = 0; i < heads.size(); ++i) fmt::print("---|");
  for (const TriedScene& tried : scenes) {
    fmt::print("\n| {} |", tried.scene);
    for (const Attempt& row : tried.rows) fmt::print(" {} |", verdict(row));
  }
  fmt::print("\n");
}

int run(const Options& options) {
  const std::vector<Contestant> contestants = list_contestants(options);
  const std::vector<StressScene> scenes = read_scenes(options);
  Limits limits;
  limits.samples.last = options.spp.value_or(largest_sample);
  if (options.seconds || !options.spp) limits.seconds = options.seconds.value_or(10.0);
  const double alarm = false_alarm / static_cast<double>(scenes.size() * contestants.size());
  listen_for_interrupts();
  fmt::print("plumb {}, {}, {} s for each.\n", PLUMB_VERSION, host(0), limits.seconds);
  fmt::print("\n| scene | by | bias | efficiency | fireflies | kurtosis | unfit | verdict |\n");
  fmt::print("|---|---|---|---|---|---|---|---|\n");
  ProgressLine line;
  bool has_failed = false;
  std::vector<TriedScene> finished;
  for (const StressScene& stress : scenes) {
    line.show(stress.scene.name);
    const Picture truth = stress.find_truth(limits, stop_requested);
    TriedScene& tried = finished.emplace_back(stress.scene.name);
    for (Contestant contestant : contestants) {
      if (stop_requested) break;
      if (contestant.is_default) fit(contestant.settings, stress.scene);
      const auto row = try_out(contestant, stress, truth, limits, alarm, line);
      if (!row) break;
      const bool is_said = stress.beyond_float &&
                           contestant.settings.precision == Precision::float32 &&
                           !contestant.is_default;
      has_failed |=
          !contestant.renderer && !is_said && row->refusal.empty() && !row->assessment.is_right();
      tried.rows.push_back(*row);
    }
    print_scene(tried);
    std::fflush(stdout);
    if (stop_requested) break;
  }
  if (finished.size() > 1) print_verdicts(finished);
  if (stop_signal != 0) return 128 + stop_signal;
  return has_failed ? 1 : 0;
}

}  // namespace

void add_stress(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<Options>();
  CLI::App& command =
      *app.add_subcommand("stress", "Try methods on scenes that are made to defeat them");
  add_options(command, *options);
  command.footer(R"(Examples:
  plumb stress
  plumb stress --scene slit,caustic --methods nee,mis --time 30
  plumb stress --with cycles,povray,mitsuba --time 2 > table.md

Prints Markdown; docs/stability.md says what the columns mean. The verdicts on
several scenes come once more at the end, a line for each. Ctrl-C prints what is
finished.
Exit codes: 0 done, 1 a method of ours is biased or breaks where that is not
known, 2 trouble, 130 interrupted.)");
  command.callback([=, &exit_code] { exit_code = run(*options); });
}

}  // namespace plumb::cli
