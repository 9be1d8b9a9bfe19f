// SPDX-License-Identifier: Apache-2.0

#include "cli/study_options.h"

#include <fmt/format.h>

#include <filesystem>
#include <sstream>
#include <utility>

#include "cli/names.h"
#include "cli/scene_options.h"
#include "compare/shared_samples.h"
#include "images/printable.h"

namespace plumb::cli {
namespace {

// What "SERIES,SPP,SECONDS" says, and else the picture itself.
Label parse_label(const std::string& words, const Picture& picture) {
  std::istringstream stream(words);
  Label label = label_of(picture);
  std::string samples, seconds;
  std::getline(stream, label.series, ',');
  std::getline(stream, samples, ',');
  std::getline(stream, seconds);
  if (!samples.empty()) label.samples = number(1.0, 1e15)(samples);
  if (!seconds.empty()) label.seconds = number(1e-9, 1e15)(seconds);
  label.step = fmt::format("{} spp", label.samples);
  return label;
}

void add_file(Study& study, const std::string& text, const StudyOptions& options) {
  const size_t sign = std::filesystem::exists(text) ? std::string::npos : text.rfind('=');
  const std::string file = text.substr(0, sign);
  Picture picture = read_picture("picture", {file}, "");
  Label label =
      sign == std::string::npos ? label_of(picture) : parse_label(text.substr(sign + 1), picture);
  if (label.series.empty()) {
    throw ImageError("doesn't tell what made it: say FILE=SERIES,SPP,SECONDS");
  }
  label.file = printable(file);
  add_picture(study, std::move(picture), label, options);
}

}  // namespace

void add_study_options(CLI::App& command, StudyOptions& options) {
  command.add_option("--reference", options.reference, "Converged picture of the same scene")
      ->required()
      ->type_name("FILE");
  command.add_option("-o,--output", options.plot, "Plot, .svg or .png; by gnuplot")
      ->type_name("FILE");
  command.add_option("--json", options.json, "All numbers; '-' for standard output alone")
      ->type_name("FILE");
  command.add_flag("--other-scene", options.other_scene,
                   "Take pictures that say that they are of another scene");
}

void add_picture(Study& study, Picture picture, const Label& label, const StudyOptions& options) {
  if (!options.other_scene) refuse_other_scenes(picture, study.reference());
  study.add(std::move(picture), label);
}

bool add_pictures(Study& study, const StudyOptions& options) {
  bool is_complete = true;
  for (const std::string& picture : options.pictures) {
    try {
      add_file(study, picture, options);
    } catch (const std::exception& error) {
      say(fmt::format("{}: {}; left out", picture, error.what()));
      is_complete = false;
    }
  }
  return is_complete;
}

void present(const Exhibit& exhibit, const StudyOptions& options) {
  const std::string json = to_json(exhibit).dump(2) + "\n";
  fmt::print("{}", options.json == "-" ? json : to_text(exhibit));
  if (!options.json.empty() && options.json != "-") write_file(options.json, json);
  if (!options.plot.empty()) write_plot(exhibit.plot, options.plot);
}

}  // namespace plumb::cli
