// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "certificate/certificate.h"
#include "cli/commands.h"
#include "cli/examination.h"
#include "cli/film_image.h"
#include "cli/interrupt.h"
#include "cli/list_renderers.h"
#include "cli/names.h"
#include "cli/progress_line.h"
#include "cli/scene_options.h"
#include "cli/trial.h"
#include "compare/assessment.h"
#include "images/output_file.h"
#include "scene_files/scene_reader.h"

namespace plumb::cli {
namespace {

namespace fs = std::filesystem;

struct Options {
  OtherRenderer renderer;
  std::string output;
  fs::path folder = scene_folder();
  std::vector<std::string> scenes;
  double tolerance = 0.5;  // per cent
  std::optional<double> seconds;
  bool quick = false;
};

// What stands in the comment at a file's top, without the line of its oracle.
std::string comment_of(const fs::path& file) {
  std::ifstream stream(file);
  const std::string text(std::istreambuf_iterator<char>(stream), {});
  const size_t begin = text.find("<!--"), end = text.find("-->");
  if (begin != 0 || end == std::string::npos) return "";
  std::string comment = text.substr(4, end - 4);
  comment = comment.substr(0, comment.find("Oracle:"));
  std::string words;  // lines of a paragraph in one
  for (size_t i = comment.find_first_not_of(" \n"); i < comment.size(); ++i) {
    if (comment[i] != '\n') {
      words += comment[i];
    } else {
      const size_t next = comment.find_first_not_of(" \n", i);
      if (next == std::string::npos) break;
      words += std::count(&comment[i], &comment[next], '\n') > 1 ? "\n" : " ";
      i = next - 1;
    }
  }
  return words;
}

// Scenes whose truth their files tell.
void add_known(const fs::path& folder, const std::string& group, const Terms& terms,
               std::vector<Question>& questions) {
  for (const fs::path& file : scene_files_in(folder)) {
    const StressScene known(file);
    const Limits limits{.seconds = terms.seconds / 4.0};
    questions.push_back({.name = known.scene.name,
                         .group = group,
                         .about = comment_of(file),
                         .scene = known.scene,
                         .file = file,
                         .bounces = {},
                         .truth = [=] { return known.find_truth(limits, stop_requested); },
                         .is_uniform = known.oracle == Oracle::radiance,
                         .is_beyond_float = known.beyond_float});
  }
}

Question reference_scene(const fs::path& folder, const std::string& name) {
  const fs::path file = folder / name / "scene.xml";
  const std::string stored = file.parent_path() / "plumbline.exr";
  return {.name = name,
          .group = "scenes",
          .about = comment_of(file),
          .scene = read_scene(file),
          .file = file,
          .bounces = {},
          .truth = [=] { return read_picture("reference", {stored}, ""); }};
}

const std::vector<std::string> reference_scenes{"goral", "furnace", "cornell", "shadows",
                                                "seed",  "metals",  "spheres", "veach"};
constexpr BounceRange bounce_ranges[] = {{0, 1}, {2, 2}, {3, 3}, {4, BounceRange{}.last}};

std::string name_of(const BounceRange& bounces) {
  return fmt::format("cornell/{}", to_string(bounces));
}

// Throws std::invalid_argument if there is no question of this name.
void check_question(const std::string& name, const fs::path& folder) {
  std::vector<std::string> names = scene_names_in(folder / "closed_forms");
  std::ranges::copy(reference_scenes, std::back_inserter(names));
  std::ranges::transform(bounce_ranges, std::back_inserter(names), name_of);
  std::ranges::copy(scene_names_in(folder / "stress"), std::back_inserter(names));
  if (std::ranges::find(names, name) == names.end())
    refuse(name, fmt::format("one of {}", fmt::join(names, ", ")));
}

// The Cornell box by what its light has met.
Question some_bounces(const fs::path& folder, const BounceRange& bounces) {
  Question question = reference_scene(folder, "cornell");
  question.group = "bounce by bounce";
  question.name = name_of(bounces);
  question.bounces = bounces;
  question.truth = [=, scene = question.scene] {
    constexpr int64_t samples = 4096;
    Film film(scene.camera.width, scene.camera.height);
    render(scene, {.bounces = bounces}, {.samples = {0, samples}}, film, {}, &stop_requested);
    return to_picture("reference", film);
  };
  return question;
}

// From the simplest one on.
std::vector<Question> list_questions(const Options& options, const Terms& terms) {
  std::vector<Question> questions;
  add_known(options.folder / "closed_forms", "closed forms", terms, questions);
  for (const std::string& scene : reference_scenes) {
    questions.push_back(reference_scene(options.folder, scene));
  }
  if (options.renderer.counts_bounces) {
    for (const BounceRange& bounces : bounce_ranges) {
      questions.push_back(some_bounces(options.folder, bounces));
    }
  }
  add_known(options.folder / "stress", stress_group, terms, questions);
  std::erase_if(questions, [&](const Question& q) {
    if (!options.scenes.empty()) {
      return std::ranges::find(options.scenes, q.name) == options.scenes.end();
    }
    return options.quick && q.group != "closed forms" && q.name != "cornell";
  });
  if (questions.empty()) throw std::invalid_argument("there are no such scenes");
  return questions;
}

// How the variance falls with the samples.
std::string noise_of(const std::vector<Examiner::Round>& rounds) {
  if (rounds.size() < 2) return "";
  const Examiner::Round &few = rounds.front(), &many = rounds.back();
  if (!(few.variance > 0.0) || !(many.variance > 0.0)) return "";
  return fmt::format(
      "From {:.0f} to {:.0f} samples per pixel of the Cornell box the variance falls "
      "as N^-{:.2f}. Independent samples have N^-1.",
      few.samples, many.samples,
      std::log(few.variance / many.variance) / std::log(many.samples / few.samples));
}

// How long others that are here take for a picture, and ours does.
std::vector<Pace> measure_others(const Options& options, const Question& cornell, double seconds,
                                 const Watcher& watcher) {
  constexpr double alarm = 1e-3;
  std::vector<Pace> paces;
  const auto add = [&](const std::optional<Trial>& trial) {
    if (!trial) return;
    const Assessment assessment = assess(*trial, cornell.truth(), alarm);
    paces.push_back({trial->program.empty() ? "Plumbline" : trial->program,
                     assessment.seconds_to_one_percent, assessment.is_right()});
  };
  for (const OtherRenderer& other : other_renderers()) {
    const bool is_wanted = !options.quick && other.word != options.renderer.word;
    if (!is_wanted || !installed_version(other)) continue;
    try {
      add(try_renderer(other, cornell.scene, cornell.file, seconds, watcher));
    } catch (const std::runtime_error& error) {
      fmt::print(stderr, "plumb: the speed of {} is not known: {}\n", other.name, error.what());
    }
    if (watcher.stop) return paces;
  }
  add(try_method(cornell.scene, {.bounces = {}}, {.seconds = seconds}, stop_requested));
  return paces;
}

// The tables of noise and speed, after the answer to the Cornell box.
void add_speed(const Options& options, const Question& cornell, const Answer& answer,
               const std::vector<Examiner::Round>& rounds, const Watcher& watcher,
               Certificate& certificate) {
  constexpr double one_percent = 1e-4;  // as relMSE
  constexpr double enough_seconds = 2.0;
  if (rounds.empty() || !(rounds.back().variance > 0.0)) return;
  certificate.noise = noise_of(rounds);
  certificate.paces = {{options.renderer.name,
                        rounds.back().variance * rounds.back().seconds / one_percent,
                        answer.mark != Mark::wrong}};
  for (const Pace& pace : measure_others(options, cornell, enough_seconds, watcher)) {
    certificate.paces.push_back(pace);
  }
}

void print(const Answer& answer) {
  fmt::print("{:<17} {}: {}\n", to_string(answer.mark), answer.name, finding(answer));
  std::fflush(stdout);
}

void write(const Certificate& certificate, const fs::path& page) {
  write_file(page, to_html(certificate));
  write_file(fs::path(page).replace_extension(".json"), to_json(certificate).dump(1) + "\n");
  write_file(fs::path(page).replace_extension(".xml"), to_junit(certificate));
  const std::string advice = certificate.advice();
  fmt::print("{}\n{}wrote {}, and beside it .json and .xml\n", certificate.summary(),
             advice.empty() ? "" : advice + "\n", page.string());
}

// How long all questions take at most, but for first rounds, what is right, and others' speed.
void tell_limits(const OtherRenderer& renderer, const Terms& terms, size_t questions) {
  const double minutes = std::ceil(double(questions) * terms.seconds / 60.0);
  std::string longer = "first rounds may take longer";
  if (std::isfinite(renderer.time_limit)) {
    longer += fmt::format(", up to {:g} s a run", renderer.time_limit);
  }
  say(fmt::format("{} has up to {:g} s for each of {} questions (--time), {:.0f} min in all; {}",
                  renderer.name, terms.seconds, questions, minutes, longer));
}

Certificate examine(const Options& options) {
  const Terms terms{options.tolerance / 100.0,
                    options.seconds.value_or(options.quick ? 15.0 : 30.0)};
  const std::vector<Question> questions = list_questions(options, terms);
  tell_limits(options.renderer, terms, questions.size());
  ProgressLine line;
  std::string title;
  const Watcher watcher{[&](const std::string& text) { line.show(title + ": " + text); },
                        stop_requested};
  Examiner examiner(options.renderer, terms, questions.size(), watcher);
  Certificate certificate{.renderer = options.renderer.name,
                          .version = "",
                          .host = host(0),
                          .tolerance = terms.tolerance,
                          .answers = {}};
  certificate.is_quick = options.quick;
  const auto add = [&](Answer answer) {
    line.show("");
    print(answer);
    certificate.answers.push_back(std::move(answer));
  };
  title = "trying the program";
  for (Answer& answer : examiner.try_protocol(options.folder / "closed_forms/02_matte_floor.xml")) {
    add(std::move(answer));
  }
  const bool runs = !certificate.answers.empty() && certificate.answers[0].mark != Mark::failed;
  for (const Question& question : questions) {
    if (stop_requested || !runs) break;
    title = question.name;
    line.show(title);
    Answer answer = examiner.ask(question);
    if (stop_requested) break;
    if (question.name == "cornell") {
      add_speed(options, question, answer, examiner.rounds(), watcher, certificate);
    }
    add(std::move(answer));
  }
  certificate.version = examiner.version();
  certificate.is_complete = !stop_requested;
  return certificate;
}

int run(Options options) {
  if (options.output.empty()) options.output = options.renderer.word + "-certificate.html";
  if (fs::path(options.output).extension() != ".html") {
    throw std::invalid_argument(options.output + ": the page's name ends in .html");
  }
  check_writable(options.output);
  listen_for_interrupts();
  const Certificate certificate = examine(options);
  write(certificate, options.output);
  return stop_signal == 0 ? certificate.exit_code() : 128 + stop_signal;
}

}  // namespace

void add_certify(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<Options>();
  CLI::App& command = *app.add_subcommand("certify", "Tell whether another renderer is right");
  const std::string words = list_renderers([](const OtherRenderer& r) { return r.word; });
  add_option(command, "--with", "PROGRAM", options->renderer, other_renderer,
             "FILE.toml, the description of a renderer\n(docs/renderers.md); or " + words)
      ->required();
  add_option(command, "-o,--output", "FILE", options->output,
             "The page, .html; beside it stand .json and JUnit's .xml\n"
             "(default: NAME-certificate.html)");
  add_option(command, "--tolerance", "PERCENT", options->tolerance, number(1e-3, 100.0),
             "What a picture, a region or a block may be off\n(default: 0.5)");
  add_option(command, "--time", "SECONDS", options->seconds, number(0.1, 1e6),
             "Of the program for each question, at most; a first round\nmay take longer (default: "
             "30; with --quick 15)");
  command.add_flag("--quick", options->quick,
                   "Closed forms and the Cornell box alone: a minute for a renderer\n"
                   "as fast as Mitsuba");
  add_option(command, "--folder", "DIR", options->folder,
             "Where the scenes are (default: reference_scenes)");
  add_option(command, "--scene", "NAME,...", options->scenes,
             "Only these questions, by name; can be repeated;\n"
             "a name that is none, such as '?', lists them")
      ->delimiter(',')
      ->check(refused_by([=](const std::string& name) { check_question(name, options->folder); }));
  command.footer(R"(Examples:
  plumb certify --with mine.toml --quick
  plumb certify --with mine.toml --tolerance 0.1 -o mine.html
  plumb certify --with mine.toml --scene 03_tilted_lamp,cornell,cornell/2:2

Asks from the simplest question on: the first wrong answer is the place to
start. docs/renderers.md says how to describe a renderer. Ctrl-C writes what
is known.
Exit codes: 0 passed, 1 something is wrong or failed, 2 trouble, 3 too noisy
to tell, 130 interrupted.)");
  command.callback([=, &exit_code] { exit_code = run(*options); });
}

}  // namespace plumb::cli
