// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/info.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <stdexcept>
#include <string>

#include "cli/commands.h"
#include "cli/interrupt.h"
#include "cli/lesson.h"
#include "cli/outputs.h"
#include "cli/progress_line.h"
#include "cli/radiosity_drawing.h"
#include "cli/scene_options.h"
#include "radiosity/faces.h"

namespace plumb::cli {
namespace {

struct Options : RadiosityOptions {
  Outputs outputs;
  std::string lesson;  // the folder
};

void add_options(CLI::App& command, Options& options) {
  add_scene_option(command, options.scene);
  add_output_option(command, options.outputs);
  command.get_option("--output")->required(false);
  add_radiosity_options(command, options);
  CLI::Option& lesson = *add_option(command, "--teach", "DIR", options.lesson,
                                    "Write a lesson's pictures, plots and numbers");
  for (const char* other : {"--output", "--error", "--elements", "--bounces", "--from", "--by"}) {
    lesson.excludes(command.get_option(other));
  }
  add_exposure_option(command, options.outputs);
}

RadiosityDrawing draw_with_progress(const Scene& scene, const Options& options) {
  ProgressLine line;
  return draw(scene, options,
              {[&](const std::string& phase) { line.show(phase); }, &stop_requested});
}

int draw_picture(const Scene& scene, const Options& options) {
  const RadiosityDrawing drawing = draw_with_progress(scene, options);
  const int interrupted_by = stop_signal;
  if (drawing.image) {
    fmt::print("{}\n", drawing.summary);
    write(*drawing.image, options.outputs);
  }
  if (drawing.why_ended.empty()) return 0;
  fmt::print(stderr, "plumb: {}\n", drawing.why_ended);
  return interrupted_by == 0 ? 2 : 128 + interrupted_by;
}

int write_lesson(const Scene& scene, const Options& options) {
  const int threads = options.threads > 0 ? options.threads : tbb::info::default_concurrency();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(threads));
  try {
    ProgressLine line;
    const radiosity::Work work{[&](const std::string& phase) { line.show(phase); },
                               &stop_requested};
    teach(scene, options.lesson, options.outputs.exposure, half_of_the_memory(), work);
  } catch (const radiosity::Stopped&) {
    fmt::print(stderr, "plumb: interrupted\n");
    return 128 + stop_signal;
  }
  fmt::print("wrote {}\n", options.lesson);
  return 0;
}

int run(const Options& options) {
  const bool is_lesson = !options.lesson.empty();
  if (!is_lesson && options.outputs.files.empty()) {
    throw std::invalid_argument("--output or --teach is required");
  }
  check(options.outputs);
  const Scene scene = load_scene(options.scene);
  listen_for_interrupts();
  try {
    return is_lesson ? write_lesson(scene, options) : draw_picture(scene, options);
  } catch (const radiosity::Refusal& refusal) {
    fmt::print(stderr, "plumb: {}\n", refusal.what());
    return 3;
  }
}

}  // namespace

void add_radiosity(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<Options>();
  CLI::App& command =
      *app.add_subcommand("radiosity", "Compute a picture of matte polygons without noise");
  add_options(command, *options);
  command.footer(R"(Examples:
  plumb radiosity reference_scenes/cornell/scene.xml -o cornell.exr
  plumb radiosity scene.xml --error 0.01% -o scene.exr
  plumb radiosity scene.xml --bounces 1:1 -o direct_light.exr
  plumb compare render.exr scene.exr
  plumb radiosity scene.xml --elements constant -o patches.png
  plumb radiosity reference_scenes/cornell/scene.xml --teach lesson

Nothing is sampled: form factors and visibility are closed forms. The error is
told by the difference from a coarser picture, and 'plumb compare' takes it as
the reference's floor. Ctrl-C saves the coarser one. Exit codes: 0 done,
2 trouble (also: no memory for the wanted error), 3 there is more in the scene
than matte polygons, 130 interrupted.)");
  command.callback([=, &exit_code] { exit_code = run(*options); });
}

}  // namespace plumb::cli
