// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "cli/commands.h"
#include "cli/names.h"
#include "cli/words.h"
#include "compare/gate.h"
#include "compare/judging.h"
#include "compare/maps.h"
#include "compare/update.h"
#include "images/printable.h"

namespace plumb::cli {
namespace {

namespace fs = std::filesystem;

const Words<MapKind> map_words{{"difference", MapKind::difference},
                               {"z", MapKind::z},
                               {"blocks", MapKind::blocks},
                               {"flip", MapKind::flip}};
const Words<FlipKind> flip_words{{"ldr", FlipKind::ldr}, {"hdr", FlipKind::hdr}};

struct Options : ComparisonTerms {
  std::string test, reference;
  std::vector<std::string> test_replicates, reference_replicates;
  std::string part, regions;
  std::string json, markdown, map;
  MapKind map_kind = MapKind::difference;
  Integers integers = Integers::linear;
  bool update = false;
  std::string gate, junit;
};

// "0.5%" of what is judged, or "0.002" in radiance; "0.1%" of the pixels, or "12" of them.
Amount parse_amount(const std::string& text) {
  if (!text.ends_with('%')) return {number(0.0, 1e30)(text), false};
  return {number(0.0, 1e6)(text.substr(0, text.size() - 1)) / 100.0, true};
}

// Adds "--name FILE" or the like.
template <typename Target>
CLI::Option* add_plain(CLI::App& command, const std::string& name, const std::string& value,
                       Target& target, const std::string& help) {
  return command.add_option(name, target, help)->type_name(value);
}

void add_judging(CLI::App& command, Options& options) {
  Judgement& judgement = options.judgement;
  add_plain(command, "TEST", "", options.test,
            "Picture to judge, in any format OpenImageIO reads, or a\nfolder of them");
  add_plain(command, "REFERENCE", "", options.reference, "Picture, or folder, to hold it against");
  add_option(command, "--tolerance", "T", judgement.tolerance, parse_amount,
             "Difference that doesn't matter: '0.5%' of the reference's\n"
             "own pixel, block, region or image, or '0.002' in radiance\n"
             "(default: 1%)");
  add_option(command, "--floor", "F", judgement.floor, parse_amount,
             "How wrong the pictures may be beside their known\n"
             "noise, as --tolerance; stands in for unknown noise\n"
             "(default: what the card.json beside REFERENCE says)");
  add_plain(command, "--replicates", "FILE", options.test_replicates,
            "Renders like TEST with other seeds: their mean is\n"
            "judged, and their scatter is its noise");
  add_plain(command, "--reference-replicates", "FILE", options.reference_replicates,
            "The same for REFERENCE");
  add_option(command, "--max-outliers", "N", judgement.max_outliers, parse_amount,
             "Pixels that may differ, such as those at a lamp's\n"
             "edge: '12', or '0.1%' of all (default: 0)");
  add_option(command, "--hard-limit", "T", judgement.hard_limit, parse_amount,
             "By how much these may differ, as --tolerance; no pixel\n"
             "may by more");
  add_option(command, "--false-alarms", "P", judgement.false_alarm, number(1e-12, 0.5),
             "Chance that noise alone makes the verdict 'different'\n(default: 0.001)");
}

void add_selecting(CLI::App& command, Options& options) {
  add_plain(command, "--regions", "MASK", options.regions,
            "Picture with a colour for each region; black is not\n"
            "compared, but in those of 'plumb render --aov', where it\n"
            "is an edge or nothing");
  add_option(command, "--crop", "X,Y,W,H", options.crop, parse_window, "Only these pixels");
  add_plain(command, "--channels", "NAMES", options.selection.channels,
            "Only these, such as R,G,B; with other names in REFERENCE:\n"
            "R=diffuse.R,G=diffuse.G (default: all)")
      ->delimiter(',');
  add_plain(command, "--layer", "NAME", options.selection.layer,
            "Only this layer's channels, such as ViewLayer.Combined;\n"
            "TEST=REFERENCE if the names differ")
      ->allow_extra_args(false);
  add_plain(command, "--part", "NAME", options.part,
            "Only this part of the files (subimage), by name or number;\n"
            "TEST=REFERENCE if they differ (default: all)");
  command.add_flag_callback(
      "--codes", [&] { options.integers = Integers::codes; },
      "Compare integers as stored, from 0 to 1: no transfer\nfunction is undone");
  command.add_flag("--other-scene", options.other_scene,
                   "Compare even if the pictures say that their scenes differ");
  command.add_flag("--negative", options.selection.negative, "Negative values are no error");
}

void add_reporting(CLI::App& command, Options& options) {
  Judgement& judgement = options.judgement;
  add_plain(command, "--json", "FILE", options.json, "All numbers; '-' for standard output alone");
  add_plain(command, "--markdown", "FILE", options.markdown, "What is printed otherwise");
  add_plain(
      command, "-o,--output", "FILE", options.map,
      "Picture of the differences: blue where the reference\nhas more, red where it has less");
  add_option(command, "--map", "KIND", options.map_kind, one_of(map_words),
             "What --output shows: difference (default), z (in standard\n"
             "deviations of a pixel), blocks (in those of 8x8 means)\n"
             "or flip (white 0, red 1)");
  add_option(command, "--flip", "RANGE", options.flip, one_of(flip_words),
             "Also tell how different they look: radiance from 0 to 1\n"
             "on a display (ldr), or at all exposures (hdr)");
  add_option(command, "--flip-mean", "M", judgement.flip_mean, number(0.0, 1.0),
             "Different if FLIP's mean is above this, such as 0.02");
  add_option(command, "--flip-p95", "M", judgement.flip_p95, number(0.0, 1.0),
             "The same for its 95th percentile");
  add_option(command, "--pixels-per-degree", "N", options.pixels_per_degree, number(1.0, 1000.0),
             "Of the display for FLIP (default: 67)");
  command.add_flag("--update", options.update,
                   "Write TEST as the new REFERENCE, in the format of its\n"
                   "name, unless they are the same");
}

void add_options(CLI::App& command, Options& options) {
  add_judging(command, options);
  add_selecting(command, options);
  add_reporting(command, options);
}

void write_text(const std::string& text, const std::string& file) {
  if (file.empty()) return;
  if (file == "-") return fmt::print("{}", text);
  write_file(file, text);
}

struct Result {
  Verdict verdict;
  std::string explanation, report;
  nlohmann::ordered_json json = {};
  std::string update = {};  // a line that names the file that was written
};

void write_reports(const Options& options, const Result& result) {
  std::string picture;  // for Markdown, as seen from its file
  if (!options.map.empty() && !options.markdown.empty()) {
    const fs::path folder = fs::absolute(options.markdown).parent_path();
    picture = fmt::format("\n![map]({})\n", fs::proximate(options.map, folder).string());
  }
  write_text(result.report + picture, options.markdown);
  write_text(result.json.dump(2) + "\n", options.json);
}

Picture read_side(const Options& options, const std::string& side, const std::string& part) {
  const bool is_test = side == "test";
  auto files = is_test ? options.test_replicates : options.reference_replicates;
  files.insert(files.begin(), is_test ? options.test : options.reference);
  return read_picture(side, files, part, options.integers);
}

// What the files tell of the same numbers in different words, such as "primaries".
std::vector<std::string> only_tags_that_differ(
    Options options, const std::map<std::string, std::string>& of_test,
    const std::map<std::string, std::string>& of_reference) {
  std::vector<std::string> names;
  for (const auto& [name, tag] : of_test) {
    if (of_reference.at(name) != tag) names.push_back(name);
  }
  if (names.empty()) return {};
  options.integers = Integers::codes;
  const auto [test_part, reference_part] = name_on_each_side(options.part);
  const Image a = read_side(options, "test", test_part).image;
  const Image b = read_side(options, "reference", reference_part).image;
  return a.channels == b.channels && a.values == b.values ? names : std::vector<std::string>();
}

// What can be drawn of pictures of other sizes: their difference, black being where one ends.
void draw_sizes(const Options& options, Picture test, Picture reference) {
  const int width = std::max(test.image.width, reference.image.width);
  const int height = std::max(test.image.height, reference.image.height);
  reframe(test, {0, 0, width, height});
  reframe(reference, {0, 0, width, height});
  test.image.left = reference.image.left;
  test.image.top = reference.image.top;
  match(test, reference, options.selection);
  write_image(draw_map(MapKind::difference, test, reference, {0, 0, width, height}), options.map);
}

bool have_one_size(const Image& a, const Image& b) {
  return a.width == b.width && a.height == b.height;
}

// Compares, and draws the map.
Result judge_files(const Options& options) {
  const auto [test_part, reference_part] = name_on_each_side(options.part);
  Picture test = read_side(options, "test", test_part);
  Picture reference = read_side(options, "reference", reference_part);
  bring_together(test, reference, options);
  if (!options.map.empty() && !have_one_size(test.image, reference.image)) {
    draw_sizes(options, test, reference);
  }
  Regions regions;
  if (!options.regions.empty()) {
    regions = read_regions(options.regions, test.image.width, test.image.height);
  }
  Judged judged = judge(test, reference, regions, options, options.reference);
  auto& [window, comparison, files] = judged;
  files.test = printable(options.test);
  files.reference = printable(options.reference);
  if (!options.map.empty()) {
    write_image(draw_map(options.map_kind, test, reference, window, comparison.flip), options.map);
  }
  if (comparison.verdict != Verdict::same) {
    // Makes room: the files are read anew.
    const auto of_test = std::exchange(test.image, {}).tags;
    const auto of_reference = std::exchange(reference.image, {}).tags;
    files.only_tags_differ = only_tags_that_differ(options, of_test, of_reference);
  }
  return {comparison.verdict, judged.explanation(), to_text(comparison, files),
          to_json(comparison, files)};
}

std::vector<std::string> parts_of(const std::string& file) {
  const Image first = read_image(file);
  std::vector<std::string> names = first.other_parts;
  names.insert(names.begin(), first.part);
  return names;
}

// Compares parts with frames of their own each for itself. The gravest verdict is that of all.
Result judge_parts(const Options& options, const FramesError& error) {
  const std::vector<std::string> parts = parts_of(options.test);
  if (parts != parts_of(options.reference) || options.crop || !options.regions.empty() ||
      !options.map.empty()) {
    throw error;
  }
  const auto gravity = [](Verdict verdict) {
    return verdict == Verdict::different ? 2 : verdict == Verdict::inconclusive ? 1 : 0;
  };
  Result all{Verdict::same, "", ""};
  auto numbers = nlohmann::ordered_json::object();
  for (const std::string& part : parts) {
    Options own = options;
    own.part = part;
    Result result{Verdict::trouble, "", ""};
    try {
      result = judge_files(own);
    } catch (const ImageError& trouble) {
      throw ImageError(fmt::format("part {}: {}", part, trouble.what()));
    }
    if (all.explanation.empty() || gravity(result.verdict) > gravity(all.verdict)) {
      all.verdict = result.verdict;
      const std::string verdict = to_string(result.verdict);
      all.explanation =
          fmt::format("{}: in part {}{}", verdict, part, result.explanation.substr(verdict.size()));
    }
    all.report += fmt::format("Part {}: {}\n", part, result.report);
    numbers[part] = std::move(result.json);
  }
  all.report += all.explanation.substr(0, all.explanation.find('\n') + 1);
  all.json = to_json(all.verdict, all.explanation,
                     {printable(options.test), printable(options.reference), ""});
  all.json["parts"] = std::move(numbers);
  return all;
}

Result judge(const Options& options) {
  try {
    return judge_files(options);
  } catch (const FramesError& error) {
    return judge_parts(options, error);
  }
}

// Writes the new reference, and says so in a line.
std::string update(const Options& options) {
  if (!options.reference_replicates.empty()) {
    throw std::invalid_argument("--update replaces one REFERENCE, not several replicates");
  }
  std::vector<std::string> files = options.test_replicates;
  files.insert(files.begin(), options.test);
  update_reference(options.reference, files, options.part, options.selection);
  return fmt::format("{} is now {}\n", options.reference, fmt::join(files, " + "));
}

// An update may end trouble, such as a missing reference or one of another size.
Result compare_files(const Options& options) {
  if (options.reference.empty()) throw std::invalid_argument("TEST and REFERENCE are required");
  Result result{Verdict::trouble, "", ""};
  try {
    result = judge(options);
    write_reports(options, result);
  } catch (const std::exception& error) {
    const ComparedFiles files{printable(options.test), printable(options.reference), ""};
    const std::string reason = printable(error.what(), LineEnds::kept);
    const auto json = to_json(Verdict::trouble, reason, files);
    write_text(options.json.empty() ? "" : json.dump(2) + "\n", options.json);
    if (!options.update || dynamic_cast<const ImageError*>(&error) == nullptr) throw;
    result.explanation = result.report = fmt::format("trouble: {}\n", reason);
  }
  if (options.update && result.verdict != Verdict::same) result.update = update(options);
  return result;
}

// Runs an entry of a gate as its own command line.
Result compare_entry(const GateEntry& entry, bool update) {
  auto options = parse_words<Options>(add_options, entry.arguments);
  options.update = update && entry.expected == Verdict::same;
  return compare_files(options);
}

// Runs all entries, with a line for each and one for each file that an update writes.
int run_entries(std::vector<GateEntry> entries, const std::string& junit,
                const std::function<Result(const GateEntry&)>& compare) {
  for (GateEntry& entry : entries) {
    std::string update;
    run_entry(entry, [&](const GateEntry& e) {
      const Result result = compare(e);
      update = result.update;
      return std::pair(result.verdict, result.explanation);
    });
    fmt::print("{} {}: {}\n{}", entry.is_as_expected() ? "ok  " : "FAIL", entry.name,
               entry.explanation.substr(0, entry.explanation.find('\n')), update);
  }
  write_text(to_junit(entries), junit);
  return exit_code_of(entries);
}

int run_gate(const Options& options) {
  std::vector<GateEntry> entries = read_gate(options.gate);
  const std::string junit = options.junit.empty() ? "" : fs::absolute(options.junit).string();
  fs::current_path(fs::absolute(options.gate).parent_path());
  return run_entries(std::move(entries), junit,
                     [&](const GateEntry& e) { return compare_entry(e, options.update); });
}

int run_folders(const Options& options) {
  if (!options.json.empty() || !options.markdown.empty() || !options.map.empty()) {
    throw std::invalid_argument("--json, --markdown and --output are of one pair, not of folders");
  }
  return run_entries(pair_folders(options.test, options.reference), options.junit,
                     [&](const GateEntry& e) {
                       Options pair = options;
                       pair.test = e.arguments[0];
                       pair.reference = e.arguments[1];
                       return compare_files(pair);
                     });
}

int run(const Options& options) {
  if (!options.gate.empty()) return run_gate(options);
  if (fs::is_directory(options.test) && fs::is_directory(options.reference)) {
    return run_folders(options);
  }
  const Result result = compare_files(options);
  if (options.json != "-" && options.markdown != "-") {
    fmt::print("{}{}", result.report, result.update);
  }
  return static_cast<int>(result.verdict);
}

}  // namespace

ComparisonTerms parse_terms(const std::vector<std::string>& words) {
  return parse_words<Options>(add_options, words);
}

MapKind parse_map(const std::string& word) { return one_of(map_words)(word); }

void add_compare(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<Options>();
  CLI::App& command =
      *app.add_subcommand("compare", "Tell whether two pictures differ by more than noise");
  add_options(command, *options);
  add_plain(command, "--gate", "FILE", options->gate,
            "Instead compare all pairs that this TOML file lists");
  add_plain(command, "--junit", "FILE", options->junit,
            "Of a gate or of folders: the outcome for CI servers");
  command.footer(R"(Examples:
  plumb compare test.exr reference.exr --tolerance 0.5%
  plumb compare a1.exr cycles.exr --replicates a2.exr a3.exr --floor 0.3%
  plumb compare test.exr reference.exr --regions mask.png -o diff.png
  plumb compare out references --tolerance 1%      # all pictures in two folders
  plumb compare --gate gate.toml --junit results.xml

Exit codes: 0 same, 1 different, 2 trouble (NaN, infinite or negative values,
other size, channels of one side only, unreadable files), 3 inconclusive.)");
  command.callback([=, &exit_code] { exit_code = run(*options); });
}

}  // namespace plumb::cli
