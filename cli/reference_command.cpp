// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "cli/commands.h"
#include "cli/film_image.h"
#include "cli/interrupt.h"
#include "cli/list_renderers.h"
#include "cli/names.h"
#include "cli/progress_line.h"
#include "cli/scene_options.h"
#include "other_renderers/runner.h"

namespace plumb::cli {
namespace {

const Words<Quality> qualities{
    {"draft", Quality::draft}, {"good", Quality::good}, {"best", Quality::best}};

struct Options {
  SceneOptions scene;
  std::string output;
  OtherRenderer renderer;
  ReferenceSettings settings;
};

// For programs: what they may ask other renderers for, and whether they are installed.
[[noreturn]] void print_list_and_exit() {
  auto list = nlohmann::json::array();
  for (const OtherRenderer& renderer : other_renderers()) {
    const std::optional<std::string> version = installed_version(renderer);
    list.push_back({{"word", renderer.word},
                    {"name", renderer.name},
                    {"isInstalled", version.has_value()},
                    {"version", version.value_or("")},
                    {"hasSamples", renderer.has_samples}});
  }
  fmt::print("{}\n", list.dump(1));
  throw CLI::Success();
}

std::string word_and_owner(const OtherRenderer& renderer) {
  if (renderer.software == renderer.name) return renderer.word;
  return fmt::format("{} ({}'s)", renderer.word, renderer.software);
}

std::string settings_help(const OtherRenderer& renderer) {
  if (renderer.example_setting.empty()) return "";
  return fmt::format("{}: a setting of its own that differs, such as\n{}", renderer.name,
                     renderer.example_setting);
}

void add_options(CLI::App& command, Options& options) {
  ReferenceSettings& settings = options.settings;
  command
      .add_flag_callback("--list", print_list_and_exit,
                         "Print as JSON which programs there are and exit")
      ->trigger_on_parse();
  add_scene_option(command, options.scene);
  add_option(command, "--with", "PROGRAM", options.renderer, other_renderer,
             list_renderers(word_and_owner) +
                 ", or FILE.toml,\na description of any renderer (docs/renderers.md)")
      ->required();
  add_option(command, "-o,--output", "FILE", options.output, "Linear .exr")->required();
  add_option(command, "--quality", "Q", settings.quality, one_of(qualities),
             "draft (seconds), good (minutes; default) or best");
  add_option(command, "--spp", "N", settings.samples_per_pixel, number(1, 1 << 20),
             "Samples per pixel of each seed (default: by quality)");
  add_option(command, "--seeds", "K", settings.seeds, number(1, 1000),
             "Pictures with so many seeds, whose mean is written\nand whose differences give the "
             "variance\n(default: by quality)");
  add_option(command, "--seed", "N", settings.first_seed, number(1, 1 << 30),
             "The first of the seeds (default: 101; those of stored\nreferences begin with 1)");
  add_option(command, "--set", "NAME=NUMBER", settings.overrides,
             list_renderers(settings_help) + "; can be repeated")
      ->allow_extra_args(false);
  add_size_and_bounces(command, options.scene);
  add_option(command, "--threads", "N", settings.threads, number(1, 1024),
             "Threads at most (default: one per processor)");
}

Provenance describe(const Scene& scene, const ReferenceSettings& settings,
                    const Reference& reference) {
  return {.renderer = reference.program,
          .version = reference.version,
          .scene = scene.name,
          .scene_hash = scene.hash,
          .bounces = to_string(settings.bounces),
          .quality = to_word(settings.quality, qualities),
          .settings = fmt::format("{}", fmt::join(settings.overrides, " ")),
          .seed = settings.first_seed,
          .samples = to_string(SampleRange{0, reference.samples_per_pixel}),
          .replicates = reference.seeds,
          .wall_seconds = reference.wall_seconds,
          .process_seconds = reference.process_seconds,
          .runs = reference.runs,
          .host = host(settings.threads)};
}

int run(Options options) {
  check_writable(options.output);
  const Scene scene = load_scene(options.scene);
  options.settings.bounces = scene.request.bounces;
  const std::string note = options.renderer.drawn_otherwise(scene);
  if (!note.empty()) fmt::print(stderr, "plumb: {}\n", note);
  listen_for_interrupts();
  Reference reference;
  try {
    ProgressLine line;
    const Watcher watcher{[&](const std::string& text) { line.show(text); }, stop_requested};
    reference = render_reference(options.renderer, scene, options.scene.file, options.settings,
                                 options.output + ".log", watcher);
  } catch (const std::invalid_argument& refusal) {
    fmt::print(stderr, "plumb: {}\n", refusal.what());
    return 3;
  }
  if (reference.seeds == 0) {
    fmt::print(stderr, "plumb: interrupted before the first picture was finished\n");
    return 128 + stop_signal;
  }
  reference.image.provenance = describe(scene, options.settings, reference);
  write_image(reference.image, options.output);
  fmt::print("{}, {}x{} by {}: {} in {:.1f} s\nwrote {}\n", scene.name, scene.camera.width,
             scene.camera.height, reference.program,
             reference.seeds == 1 ? "one picture" : fmt::format("{} seeds", reference.seeds),
             reference.wall_seconds, options.output);
  return stop_signal == 0 ? 0 : 128 + stop_signal;
}

}  // namespace

void add_reference(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<Options>();
  CLI::App& command = *app.add_subcommand("reference", "Have another program render a scene");
  add_options(command, *options);
  const std::string without_samples =
      list_renderers([](const OtherRenderer& r) { return r.has_samples ? "" : r.name; });
  command.footer(fmt::format(R"(Examples:
  plumb reference scene.xml --with cycles --spp 256 --seeds 4 -o cycles.exr
  plumb reference scene.xml --with povray --quality best -o povray.exr
  plumb reference scene.xml --with povray --bounces 0:1 -o direct.exr

Ctrl-C writes the mean of the seeds that are finished. If the program fails,
what it printed is kept in FILE.log. {} takes neither --spp nor --seeds.
Exit codes: 0 done, 2 trouble, 3 the program can't draw that,
130 interrupted.)",
                             without_samples));
  command.callback([=, &exit_code] { exit_code = run(*options); });
}

}  // namespace plumb::cli
