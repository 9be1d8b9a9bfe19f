// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "cli/commands.h"
#include "cli/film_image.h"
#include "cli/interrupt.h"
#include "cli/list_renderers.h"
#include "cli/names.h"
#include "cli/progress_line.h"
#include "cli/scene_options.h"
#include "cli/study_options.h"
#include "cli/words.h"
#include "other_renderers/runner.h"
#include "renderer/render.h"

namespace plumb::cli {
namespace {

namespace fs = std::filesystem;

struct Options {
  StudyOptions study;
  std::vector<Method> methods{Method::mis};
  std::vector<Sampler> samplers{Sampler::sobol};
  std::pair<int64_t, int64_t> spp{1, 1024};  // least and most
  int runs = 3;
  Settings settings;  // of all renders
  SceneOptions scene;
  std::vector<std::string> programs;
  std::string keep;
};

// A parser of lists with commas between.
template <typename Parse>
auto list_of(Parse parse) {
  return [parse](const std::string& text) {
    std::vector<decltype(parse(text))> values;
    std::istringstream stream(text);
    for (std::string word; std::getline(stream, word, ',');) values.push_back(parse(word));
    return values;
  };
}

std::pair<int64_t, int64_t> parse_spp(const std::string& text) {
  const auto [least, most] = parse_pair<int64_t>(text, ':', 1, largest_sample);
  if (least > most) refuse(text, "a range A:B with A <= B");
  return {least, most};
}

void add_options(CLI::App& command, Options& options) {
  command
      .add_option("PICTURES", options.study.pictures, "Scene file to render, or renders that exist")
      ->required()
      ->type_name("");
  add_study_options(command, options.study);
  add_option(command, "--methods", "M,...", options.methods, list_of(one_of(method_words)),
             "Of a scene: bsdf, nee, mis (default: mis)");
  add_option(command, "--samplers", "S,...", options.samplers, list_of(one_of(sampler_words)),
             "sobol, independent (default: sobol)");
  add_option(command, "--spp", "A:B", options.spp, parse_spp,
             "Samples per pixel A, 2 A, 4 A, ... up to B\n(default: 1:1024)");
  add_option(command, "--runs", "R", options.runs, number(1, 1000),
             "Renders of each, with other seeds (default: 3)");
  command
      .add_option(
          "--with", options.programs,
          "Of a scene, by other programs too: " + list_renderers([](const OtherRenderer& r) {
            return r.has_samples ? r.word : "";
          }) + ",\nor FILE.toml (docs/renderers.md)")
      ->type_name("PROGRAM,...")
      ->delimiter(',')
      ->check(refused_by(other_renderer));
  add_size_and_bounces(command, options.scene);
  add_option(command, "--threads", "N", options.settings.threads, number(1, 1024),
             "Threads at most (default: one per processor)");
  command
      .add_option("--keep", options.keep, "Keeps the renders here and takes those that are there")
      ->type_name("FOLDER");
}

bool is_scene(const std::string& file) { return file.ends_with(".xml"); }

// The settings of all renders, with their number of samples; every one has another seed, and none
// that of the reference.
std::vector<std::pair<Settings, int64_t>> plan(const Options& options,
                                               const std::optional<int>& taken) {
  std::vector<std::pair<Settings, int64_t>> renders;
  for (const Method method : options.methods) {
    for (const Sampler sampler : options.samplers) {
      Settings settings = options.settings;
      settings.method = method;
      settings.sampler = sampler;
      settings.seed = 1;
      for (int64_t n = options.spp.first; n <= options.spp.second; n *= 2) {
        for (int run = 0; run < options.runs; ++run, ++settings.seed) {
          if (taken && settings.seed == static_cast<uint32_t>(*taken)) ++settings.seed;
          renders.emplace_back(settings, n);
        }
      }
    }
  }
  return renders;
}

// Renders, or takes what an earlier run has kept. No picture after an interrupt.
std::optional<Image> picture_of(const Scene& scene, const Settings& settings, int64_t samples,
                                const std::string& keep, const std::atomic<bool>& stop) {
  Film film(scene.camera.width, scene.camera.height);
  const SampleRange range{0, samples};
  const fs::path file = fs::path(keep) / fmt::format("{}-{}-{}-{}spp-seed{}.exr", scene.name,
                                                     to_word(settings.method, method_words),
                                                     to_word(settings.sampler, sampler_words),
                                                     samples, settings.seed);
  if (!keep.empty() && fs::exists(file)) {
    Image kept = read_image(file);
    const bool has_size = kept.width == film.width() && kept.height == film.height();
    const Provenance planned = describe(scene, settings, range, film, {});
    if (has_size && is_same_render(kept.provenance, planned)) return kept;
  }
  const Cost cost = render(scene, settings, {.samples = range}, film, {}, &stop);
  if (stop) return {};
  Image image = to_image(film, false);
  image.provenance = describe(scene, settings, range, film, cost);
  if (!keep.empty()) write_image(image, file);
  return image;
}

// Adds what another program draws: with each number of samples so many pictures of a seed each.
void render_all_by(const OtherRenderer& renderer, const Scene& scene, const Options& options,
                   const Watcher& watcher, Study& study) {
  if (!renderer.has_samples) {
    throw std::invalid_argument(renderer.name + " has no samples whose number could grow");
  }
  const fs::path log = fs::temp_directory_path() / fmt::format("plumb-{}.log", renderer.word);
  ReferenceSettings settings{.seeds = 1,
                             .first_seed = 1,
                             .bounces = scene.request.bounces,
                             .threads = options.settings.threads};
  for (int64_t n = options.spp.first; n <= options.spp.second; n *= 2) {
    for (int run = 0; run < options.runs; ++run, ++settings.first_seed) {
      settings.samples_per_pixel = static_cast<int>(n);
      Reference drawn =
          render_reference(renderer, scene, options.scene.file, settings, log, watcher);
      if (watcher.stop) return;
      const Label label{
          .series = renderer.name,
          .step = fmt::format("{} spp", n),
          .samples = static_cast<double>(n),
          .seconds = drawn.wall_seconds,
          .startup_seconds = drawn.process_seconds - drawn.wall_seconds,
          .file = fmt::format("{}, {} spp, seed {}", renderer.name, n, settings.first_seed)};
      add_picture(study, to_picture("picture", std::move(drawn.image), 1), label, options.study);
    }
  }
}

// Adds all renders that an interrupt leaves time for.
void render_all(Options options, Study& study, const Watcher& watcher) {
  options.scene.file = options.study.pictures.front();
  if (options.study.pictures.size() > 1) throw std::invalid_argument("one scene at a time");
  const Scene scene = load_scene(options.scene);
  options.settings.bounces = scene.request.bounces;
  options.settings.precision = fitting_precision(scene);
  if (!options.keep.empty()) fs::create_directories(options.keep);
  const auto renders = plan(options, study.reference().image.provenance.seed);
  for (size_t done = 0; const auto& [settings, samples] : renders) {
    watcher.show(fmt::format("{} of {} renders: {} {}, {} spp", ++done, renders.size(),
                             to_word(settings.method, method_words),
                             to_word(settings.sampler, sampler_words), samples));
    auto image = picture_of(scene, settings, samples, options.keep, watcher.stop);
    if (!image) return;
    Picture picture = to_picture("picture", std::move(*image));
    Label label = label_of(picture);
    label.file = fmt::format("{}, {}, seed {}", label.series, label.step, settings.seed);
    add_picture(study, std::move(picture), label, options.study);
  }
  for (const std::string& program : options.programs) {
    render_all_by(other_renderer(program), scene, options, watcher, study);
  }
}

Exhibit converge(const Options& options, const Watcher& watcher, bool& is_complete) {
  Study study(read_picture("reference", {options.study.reference}, ""));
  if (is_scene(options.study.pictures.front())) {
    render_all(options, study, watcher);
  } else {
    is_complete = add_pictures(study, options.study);
  }
  return convergence(study);
}

int run(const Options& options) {
  if (is_scene(options.study.pictures.front())) listen_for_interrupts();
  bool is_complete = true;
  std::optional<Exhibit> exhibit;
  {
    ProgressLine line;
    exhibit = converge(options, {[&](const std::string& text) { line.show(text); }, stop_requested},
                       is_complete);
  }
  present(*exhibit, options.study);
  if (stop_signal != 0) return 128 + stop_signal;
  return is_complete ? 0 : 2;
}

}  // namespace

Exhibit converge(const std::vector<std::string>& words, const Watcher& watcher) {
  bool is_complete = true;
  return converge(parse_words<Options>(add_options, words), watcher, is_complete);
}

void add_converge(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<Options>();
  CLI::App& command =
      *app.add_subcommand("converge", "Tell how error falls with samples, and where it stops");
  add_options(command, *options);
  command.footer(R"(Examples:
  plumb converge scene.xml --methods bsdf,nee,mis --reference ref.exr -o fall.svg
  plumb converge scene.xml --with mine.toml --spp 4:256 --reference ref.exr
  plumb converge *.exr --reference ref.exr
  plumb converge a.png=mine,16 b.png=mine,64 c.png=mine,256 d.png=mine,1024 \
    --reference ref.exr

Fits relMSE(N) = a N^-p + c to each series of pictures; = SERIES,SPP,SECONDS says
what a picture itself doesn't. Ctrl-C fits what is finished.
Exit codes: 0 done, 2 trouble (the other pictures still count), 130 interrupted.)");
  command.callback([=, &exit_code] { exit_code = run(*options); });
}

}  // namespace plumb::cli
