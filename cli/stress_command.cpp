#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "cli/interrupt.h"
#include "cli/names.h"
#include "cli/progress_line.h"
#include "cli/stress_scenes.h"
#include "cli/trial.h"
#include "renderer/scene_reader.h"

namespace plumb::cli {
namespace {

constexpr double false_alarm = 1e-3;  // the chance that noise alone makes anything biased

struct Options {
  std::string list = "reference_scenes/stress/stress.toml";
  std::vector<std::string> scenes;
  std::vector<std::string> methods{"bsdf", "nee", "mis"};
  std::vector<std::string> programs;
  std::optional<double> seconds;
  std::optional<int64_t> spp;
};

// Somebody who tries to render the scenes.
struct Contestant {
  std::string name;
  Settings settings;
  std::optional<Program> program;
};

struct Row {
  std::string contestant;
  Assessment assessment;
  std::optional<Tail> tail;
  double cost = 0.0;    // relative mean square error times seconds
  std::string refusal;  // why there is no assessment
};

void add_options(CLI::App& command, Options& options) {
  command.add_option("--list", options.list, "The scenes and their oracles")
      ->type_name("FILE")
      ->capture_default_str();
  command.add_option("--scene", options.scenes, "Only these (default: all)")->type_name("S");
  command.add_option("--methods", options.methods, "Of bsdf, nee, mis (default: all)")
      ->type_name("M")
      ->delimiter(',');
  command.add_option("--with", options.programs, "Other programs: cycles, povray, mitsuba")
      ->type_name("P")
      ->delimiter(',');
  add_option(command, "--time", "SECONDS", options.seconds, number(1e-3, 1e6),
             "For each method on each scene (default: 10)");
  add_option(command, "--spp", "N", options.spp, number<int64_t>(1, largest_sample),
             "Samples per pixel of our methods at most");
}

std::vector<Contestant> list_contestants(const Options& options) {
  std::vector<Contestant> contestants;
  for (const std::string& method : options.methods) {
    for (const auto& [word, precision] : precision_words) {
      const Settings settings{
          .method = one_of(method_words)(method), .precision = precision, .bounces = {}};
      contestants.push_back({method + " " + word, settings, {}});
    }
  }
  for (const std::string& program : options.programs) {
    contestants.push_back({program, {}, one_of(program_words)(program)});
  }
  return contestants;
}

std::vector<StressScene> choose_scenes(const Options& options) {
  std::vector<StressScene> all = read_stress_scenes(options.list);
  for (const std::string& name : options.scenes) {
    if (std::ranges::count(all, name, &StressScene::name) == 0) {
      throw std::invalid_argument(fmt::format("--scene: {} has no '{}'", options.list, name));
    }
  }
  std::erase_if(all, [&](const StressScene& stress) {
    return !options.scenes.empty() && std::ranges::count(options.scenes, stress.name()) == 0;
  });
  return all;
}

// Nothing after an interrupt.
std::optional<Row> try_out(const Contestant& contestant, const Scene& scene,
                           const StressScene& stress, const Picture& truth, const Limits& limits,
                           double alarm, ProgressLine& line) {
  const Watcher watcher{[&](const std::string& text) { line.show(text); }, stop_requested};
  Row row{contestant.name, {}, {}, 0.0, ""};
  try {
    const std::optional<Trial> trial =
        contestant.program
            ? try_program(scene, stress.file, *contestant.program, limits, watcher)
            : try_method(scene, contestant.settings, limits, stop_requested);
    if (!trial) return {};
    row.assessment = assess(*trial, truth, alarm);
    row.tail = trial->tail;
    row.cost = row.assessment.square * trial->seconds;
  } catch (const std::exception& error) {
    if (!contestant.program) throw;
    row.refusal = error.what();
  }
  return row;
}

std::string duration(double seconds) {
  if (seconds < 120.0) return fmt::format("{:.0f} s", seconds);
  if (seconds < 7200.0) return fmt::format("{:.0f} min", seconds / 60.0);
  if (seconds < 172800.0) return fmt::format("{:.0f} h", seconds / 3600.0);
  return fmt::format("{:.0f} days", seconds / 86400.0);
}

std::string verdict(const Row& row) {
  if (!row.refusal.empty()) return "-";
  switch (row.assessment.outcome) {
    case Outcome::holds: return "holds";
    case Outcome::noisy:
      return "noisy: 1 % in " + duration(row.assessment.seconds_to_one_percent);
    case Outcome::biased: return "**biased**";
    case Outcome::breaks: return "**breaks**";
  }
  return "";
}

bool is_right(const Row& row) {
  return row.refusal.empty() && row.assessment.outcome <= Outcome::noisy;
}

void print_details(const Row& row, double least_cost) {
  const Assessment& a = row.assessment;
  if (!row.refusal.empty()) {
    fmt::print("| {} | {} | | | | | - |\n", row.contestant, row.refusal);
    return;
  }
  std::string tail = "| | |";
  if (row.tail) {
    tail = fmt::format("{:.0f} % | {:.2g} | {} |", 100.0 * row.tail->fireflies, row.tail->kurtosis,
                       row.tail->unfit);
  }
  const std::string where = a.where.empty() ? "" : ", " + a.where;
  const std::string efficiency = is_right(row) ? fmt::format("{:.2g}", least_cost / row.cost) : "";
  fmt::print("| {} | {:+.3f} ± {:.3f} % | {} | {} {}{} |\n", row.contestant, 100.0 * a.bias,
             100.0 * a.error, efficiency, tail, verdict(row), where);
}

void print_scene(const StressScene& stress, const std::vector<Row>& rows) {
  fmt::print("\n### {}\n\n{}.\n\n", stress.name(), stress.idea);
  fmt::print("| | bias | efficiency | fireflies | kurtosis | unfit | verdict |\n");
  fmt::print("|---|---|---|---|---|---|---|\n");
  double least = std::numeric_limits<double>::infinity();
  for (const Row& row : rows) {
    if (is_right(row)) least = std::min(least, row.cost);
  }
  for (const Row& row : rows) print_details(row, least);
}

using Results = std::vector<std::pair<StressScene, std::vector<Row>>>;

void print_verdicts(const Results& results, const std::vector<Contestant>& contestants) {
  std::vector<std::string> names{"scene"};
  for (const Contestant& contestant : contestants) names.push_back(contestant.name);
  fmt::print("\n### All\n\n| {} |\n", fmt::join(names, " | "));
  for (size_t i = 0; i < names.size(); ++i) fmt::print("|---");
  fmt::print("|\n");
  for (const auto& [stress, rows] : results) {
    std::vector<std::string> cells{stress.name()};
    for (const Row& row : rows) cells.push_back(verdict(row));
    fmt::print("| {} |\n", fmt::join(cells, " | "));
  }
}

bool fails_unsaid(const StressScene& stress, const Contestant& contestant, const Row& row) {
  const bool is_said =
      stress.beyond_float && contestant.settings.precision == Precision::float32;
  return !contestant.program && !is_said && row.assessment.outcome >= Outcome::biased;
}

int run(const Options& options) {
  const std::vector<Contestant> contestants = list_contestants(options);
  const std::vector<StressScene> scenes = choose_scenes(options);
  Limits limits;
  limits.samples.last = options.spp.value_or(largest_sample);
  if (options.seconds || !options.spp) limits.seconds = options.seconds.value_or(10.0);
  const double alarm = false_alarm / static_cast<double>(scenes.size() * contestants.size());
  listen_for_interrupts();
  ProgressLine line;
  Results results;
  bool has_failed = false;
  for (const StressScene& stress : scenes) {
    const Scene scene = read_scene(stress.file);
    line.show(fmt::format("{}: the truth", stress.name()));
    const Picture truth = find_truth(stress, scene.camera, limits, stop_requested);
    std::vector<Row> rows;
    for (const Contestant& contestant : contestants) {
      if (stop_requested) break;
      line.show(fmt::format("{}: {}", stress.name(), contestant.name));
      const auto row = try_out(contestant, scene, stress, truth, limits, alarm, line);
      if (!row) break;
      has_failed |= fails_unsaid(stress, contestant, *row);
      rows.push_back(*row);
    }
    if (rows.empty()) break;
    print_scene(stress, rows);
    results.emplace_back(stress, rows);
  }
  print_verdicts(results, contestants);
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
  plumb stress --scene slit --scene caustic --methods nee,mis --time 30
  plumb stress --with cycles,povray,mitsuba --time 2 > table.md

Prints Markdown; docs/stability.md says what the columns mean. Ctrl-C prints
what is finished.
Exit codes: 0 done, 1 a method of ours is biased or breaks where it was not
said before, 2 trouble, 130 interrupted.)");
  command.callback([=, &exit_code] { exit_code = run(*options); });
}

}  // namespace plumb::cli
