#include <fmt/format.h>

#include <toml++/toml.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <pugixml.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "cli/commands.h"
#include "cli/names.h"
#include "compare/comparison.h"
#include "compare/maps.h"
#include "compare/report.h"

namespace plumb::cli {
namespace {

namespace fs = std::filesystem;

const Words<MapKind> map_words{{"difference", MapKind::difference},
                               {"z", MapKind::z},
                               {"blocks", MapKind::blocks},
                               {"flip", MapKind::flip}};
const Words<FlipKind> flip_words{{"ldr", FlipKind::ldr}, {"hdr", FlipKind::hdr}};

struct Options {
  std::string test, reference;
  std::vector<std::string> test_replicates, reference_replicates;
  std::string part;
  std::vector<std::string> channels;
  bool negative = false;
  std::string regions;
  std::optional<Window> crop;
  Judgement judgement;
  std::string json, markdown, map;
  MapKind map_kind = MapKind::difference;
  std::optional<FlipKind> flip;
  bool update = false;
  std::string gate, junit;
};

// "0.5%" of the reference's mean, or "0.002" in radiance; "0.1%" of the pixels, or "12" of them.
Amount parse_amount(const std::string& text) {
  if (!text.ends_with('%')) return {number(0.0, 1e30)(text), false};
  return {number(0.0, 1e6)(text.substr(0, text.size() - 1)) / 100.0, true};
}

Window parse_window(const std::string& text) {
  std::istringstream stream(text);
  Window w;
  char a = 0, b = 0, c = 0;
  stream >> w.x >> a >> w.y >> b >> w.width >> c >> w.height;
  const bool has_form = stream && stream.peek() == EOF && a == ',' && b == ',' && c == ',';
  if (!has_form || w.x < 0 || w.y < 0 || w.width < 1 || w.height < 1)
    refuse(text, "of the form X,Y,WIDTH,HEIGHT");
  return w;
}

// Adds "--name FILE" or the like.
template <typename Target>
CLI::Option* add_plain(CLI::App& command, const std::string& name, const std::string& value,
                       Target& target, const std::string& help) {
  return command.add_option(name, target, help)->type_name(value);
}

void add_options(CLI::App& command, Options& options) {
  Judgement& judgement = options.judgement;
  add_plain(command, "TEST", "", options.test, "Picture to judge, in any format OpenImageIO reads");
  add_plain(command, "REFERENCE", "", options.reference, "Picture to hold it against");
  add_option(command, "--tolerance", "T", judgement.tolerance, parse_amount,
             "Difference that doesn't matter: '0.5%' of the\n"
             "reference's mean, or '0.002' in radiance (default: 1%)");
  add_option(command, "--floor", "F", judgement.floor, parse_amount,
             "How wrong the pictures may be beside their known\n"
             "noise, as --tolerance; stands in for unknown noise\n"
             "(default: what the card.json beside REFERENCE says)");
  add_plain(command, "--replicates", "FILE", options.test_replicates,
            "Renders like TEST with other seeds: their mean is\n"
            "judged, and their scatter is its noise");
  add_plain(command, "--reference-replicates", "FILE", options.reference_replicates,
            "The same for REFERENCE");
  add_plain(command, "--regions", "MASK", options.regions,
            "Picture with a colour for each region, black for none;\n"
            "'plumb render --aov object' draws one");
  add_option(command, "--crop", "X,Y,W,H", options.crop, parse_window, "Only these pixels");
  add_plain(command, "--channels", "NAMES", options.channels, "Only these, such as R,G,B")
      ->delimiter(',');
  add_plain(command, "--part", "NAME", options.part,
            "Part of the files (subimage), by name or number");
  command.add_flag("--negative", options.negative, "Negative values are no error");
  add_option(command, "--max-outliers", "N", judgement.max_outliers, parse_amount,
             "Pixels that may differ, such as those at a lamp's\n"
             "edge: '12', or '0.1%' of all (default: 0)");
  add_option(command, "--false-alarms", "P", judgement.false_alarm, number(1e-12, 0.5),
             "Chance that noise alone makes the verdict 'different'\n(default: 0.001)");
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
  command.add_flag("--update", options.update,
                   "Overwrite REFERENCE with TEST unless they are the same");
}

// What was assumed about a picture, a line.
std::string notes(const Picture& picture) {
  std::string text;
  if (picture.image.encoding.find(',') != std::string::npos) {
    text += fmt::format("{}: {}\n", picture.side, picture.image.encoding);
  }
  if (!picture.knows_noise()) text += fmt::format("{}: noise not known\n", picture.side);
  const double samples = picture.samples_per_pixel();
  if (samples > 0.0 && samples < 16.0) {
    text += fmt::format("{}: too few samples to know its noise: 'different' may be by chance\n",
                        picture.side);
  }
  return text;
}

void write_text(const std::string& text, const std::string& file) {
  if (file.empty()) return;
  if (file == "-") return fmt::print("{}", text);
  write_file(file, text);
}

void write_reports(const Options& options, const std::string& json, const std::string& report) {
  std::string picture;  // for Markdown, as seen from its file
  if (!options.map.empty() && !options.markdown.empty()) {
    const fs::path folder = fs::absolute(options.markdown).parent_path();
    picture = fmt::format("\n![map]({})\n", fs::proximate(options.map, folder).string());
  }
  write_text(report + picture, options.markdown);
  write_text(json, options.json);
}

// By how much a picture may be wrong as a whole and in its worst region, by the card.json beside
// it, if there is one.
std::optional<std::pair<Amount, Amount>> floors_of_card(const fs::path& picture) {
  const fs::path file = fs::path(picture).replace_filename("card.json");
  std::ifstream stream(file);
  if (!stream) return {};
  try {
    const auto card = nlohmann::json::parse(stream);
    for (const auto& entry : card.at("pictures")) {
      if (entry.at("file") != picture.filename().string()) continue;
      const double whole = entry.at("floor").at("wholePercent");
      double worst = whole;
      for (const double floor : entry.at("floor").at("regionsPercent")) {
        worst = std::max(worst, floor);
      }
      return std::pair(Amount{whole / 100.0}, Amount{worst / 100.0});
    }
  } catch (const nlohmann::json::exception& error) {
    throw std::runtime_error(fmt::format("{}: {}", file.string(), error.what()));
  }
  return {};
}

// Compares, writes all that is asked for, and gives the verdict with its reason.
std::pair<Verdict, std::string> compare_files(const Options& options, std::string& report) {
  if (options.reference.empty()) throw std::invalid_argument("TEST and REFERENCE are required");
  const auto read = [&](const std::string& side, const std::string& file, auto replicates) {
    replicates.insert(replicates.begin(), file);
    return read_picture(side, replicates, options.part);
  };
  Picture test = read("test", options.test, options.test_replicates);
  Picture reference = read("reference", options.reference, options.reference_replicates);
  const auto channels = match(test, reference, options.channels, options.negative);
  Judgement judgement = options.judgement;
  std::string floor_note;
  if (!judgement.floor && !reference.knows_noise()) {
    if (const auto floors = floors_of_card(options.reference)) {
      std::tie(judgement.image_floor, judgement.floor) = *floors;
      floor_note = fmt::format(
          "reference: floor {:.3g} % of the image, {:.3g} % elsewhere, by its "
          "card.json\n",
          100.0 * floors->first.value, 100.0 * floors->second.value);
    }
  }
  const Image& image = test.image;
  const Window window = options.crop.value_or(Window{0, 0, image.width, image.height});
  if (window.width > image.width - window.x || window.height > image.height - window.y) {
    throw std::invalid_argument("--crop reaches beyond the picture");
  }
  Regions regions;
  if (!options.regions.empty()) {
    regions = read_regions(options.regions, image.width, image.height);
  }
  Comparison comparison = compare(test, reference, channels, window, regions, judgement);
  if (options.flip) comparison.flip = flip(*options.flip, test, reference, window);
  const ComparedFiles files{options.test, options.reference,
                            notes(test) + notes(reference) + floor_note, test.samples_per_pixel()};
  report = to_text(comparison, files);
  write_reports(options, to_json(comparison, files).dump(2) + "\n", report);
  if (!options.map.empty()) {
    write_image(draw_map(options.map_kind, test, reference, window, comparison.flip), options.map);
  }
  if (options.update && comparison.verdict != Verdict::same) {
    std::ifstream stream(options.test, std::ios::binary);
    write_file(options.reference, std::string(std::istreambuf_iterator<char>(stream), {}));
    report += fmt::format("{} is now {}\n", options.reference, options.test);
  }
  return {comparison.verdict, explain(comparison, files)};
}

int exit_code_of(const std::string& verdict) {
  if (verdict == "same") return 0;
  if (verdict == "different") return 1;
  return verdict == "inconclusive" ? 3 : 2;
}

// A comparison in a gate file, and how it ended:
//   [[compare]]
//   test = "out/cornell.exr"              # relative to the gate file
//   reference = "references/cornell.exr"
//   tolerance = "0.5%"                    # any option of 'plumb compare', without its dashes
//   name = "Cornell box"                  # default: the test's file name
//   expect = "different"                  # for a companion that must fail; default: "same"
struct Entry {
  std::string name, expected;
  std::vector<std::string> arguments;  // of 'plumb compare'
  std::string verdict, text;           // or "trouble", and why
  double seconds = 0;
};

// A value of the file as words of the command line.
void add_words(const toml::node& node, std::vector<std::string>& words) {
  if (const auto* list = node.as_array()) {
    for (const toml::node& item : *list) add_words(item, words);
  } else if (const auto text = node.value<std::string>()) {
    words.push_back(*text);
  } else {
    std::ostringstream stream;
    node.visit([&](const auto& value) { stream << value; });
    words.push_back(stream.str());
  }
}

Entry read_entry(const toml::table& table) {
  const std::string test = table["test"].value_or("");
  Entry entry;
  entry.name = table["name"].value_or(test);
  entry.expected = table["expect"].value_or("same");
  entry.arguments = {test, table["reference"].value_or("")};
  for (const auto& [key, node] : table) {
    const std::string_view name = key.str();
    if (name == "test" || name == "reference" || name == "name" || name == "expect") continue;
    if (node.is_boolean() && !node.value_or(true)) continue;
    entry.arguments.push_back(fmt::format("--{}", name));
    if (!node.is_boolean()) add_words(node, entry.arguments);
  }
  std::ranges::reverse(entry.arguments);  // as CLI11 wants them
  return entry;
}

// Throws std::runtime_error with the place of what is wrong.
std::vector<Entry> read_gate(const std::string& file) try {
  const toml::table gate = toml::parse_file(file);
  std::vector<Entry> entries;
  if (const auto* list = gate["compare"].as_array()) {
    for (const toml::node& node : *list) {
      if (const auto* table = node.as_table()) entries.push_back(read_entry(*table));
    }
  }
  if (entries.empty()) throw std::runtime_error(file + ": no [[compare]] in it");
  return entries;
} catch (const toml::parse_error& error) {
  throw std::runtime_error(
      fmt::format("{}:{}: {}", file, error.source().begin.line, error.description()));
}

// JUnit's XML, as CI servers read it.
std::string to_junit(const std::vector<Entry>& entries) {
  pugi::xml_document document;
  pugi::xml_node suite = document.append_child("testsuite");
  suite.append_attribute("name") = "plumb compare";
  suite.append_attribute("tests") = entries.size();
  for (const Entry& entry : entries) {
    pugi::xml_node test = suite.append_child("testcase");
    test.append_attribute("name") = entry.name.c_str();
    test.append_attribute("time") = entry.seconds;
    if (entry.verdict == entry.expected) continue;
    pugi::xml_node failure = test.append_child(entry.verdict == "trouble" ? "error" : "failure");
    failure.append_attribute("message") =
        fmt::format("{}, not {}", entry.verdict, entry.expected).c_str();
    failure.text() = entry.text.c_str();
  }
  std::ostringstream stream;
  document.save(stream, "  ");
  return stream.str();
}

// Runs an entry as its own command line.
void run(Entry& entry, bool update) {
  const auto start = std::chrono::steady_clock::now();
  std::string report;
  try {
    Options options;
    CLI::App command;
    add_options(command, options);
    command.parse(entry.arguments);
    options.update = update && entry.expected == "same";
    const auto [verdict, text] = compare_files(options, report);
    entry.verdict = to_string(verdict);
    entry.text = text;
  } catch (const std::exception& error) {
    entry.verdict = "trouble";
    entry.text = fmt::format("trouble: {}\n", error.what());
  }
  entry.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  fmt::print("{} {}: {}\n", entry.verdict == entry.expected ? "ok  " : "FAIL", entry.name,
             entry.text.substr(0, entry.text.find('\n')));
}

// 0 if all ended as expected, else the worst outcome's code: trouble, different, inconclusive.
int run_gate(const Options& options) {
  std::vector<Entry> entries = read_gate(options.gate);
  const std::string junit = options.junit.empty() ? "" : fs::absolute(options.junit).string();
  fs::current_path(fs::absolute(options.gate).parent_path());
  int code = 0;
  for (Entry& entry : entries) {
    run(entry, options.update);
    if (entry.verdict == entry.expected) continue;
    const int own = std::max(1, exit_code_of(entry.verdict));
    const auto gravity = [](int exit_code) { return std::array{0, 2, 3, 1}[size_t(exit_code)]; };
    if (gravity(own) > gravity(code)) code = own;
  }
  write_text(to_junit(entries), junit);
  return code;
}

int run(const Options& options) {
  if (!options.gate.empty()) return run_gate(options);
  std::string report;
  const Verdict verdict = compare_files(options, report).first;
  if (options.json != "-" && options.markdown != "-") fmt::print("{}", report);
  return exit_code_of(to_string(verdict));
}

}  // namespace

void add_compare(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<Options>();
  CLI::App& command =
      *app.add_subcommand("compare", "Tell whether two pictures differ by more than noise");
  add_options(command, *options);
  add_plain(command, "--gate", "FILE", options->gate,
            "Instead compare all pairs that this TOML file lists");
  add_plain(command, "--junit", "FILE", options->junit, "With --gate: the outcome for CI servers");
  command.footer(R"(Examples:
  plumb compare test.exr reference.exr --tolerance 0.5%
  plumb compare a1.exr cycles.exr --replicates a2.exr a3.exr --floor 0.3%
  plumb compare test.exr reference.exr --regions mask.png -o diff.png
  plumb compare --gate gate.toml --junit results.xml

Exit codes: 0 same, 1 different, 2 trouble (NaN, infinite or negative values,
other size or channels, unreadable files), 3 inconclusive.)");
  command.callback([=, &exit_code] { exit_code = run(*options); });
}

}  // namespace plumb::cli
