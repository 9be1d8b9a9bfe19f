// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <ctime>
#include <memory>
#include <stdexcept>
#include <string>

#include "cli/commands.h"
#include "cli/film_image.h"
#include "cli/interrupt.h"
#include "cli/lesson.h"
#include "cli/names.h"
#include "cli/outputs.h"
#include "cli/progress_line.h"
#include "cli/scene_options.h"
#include "radiosity/radiosity.h"
#include "radiosity/teaching/patch_picture.h"

namespace plumb::cli {
namespace {

struct Options {
  SceneOptions scene;
  Outputs outputs;
  bool is_constant = false;
  std::string lesson;  // the folder
  double error = 0.0;
  int threads = 0;
};

const Words<bool> element_words{{"linear", false}, {"constant", true}};

void add_options(CLI::App& command, Options& options) {
  add_scene_option(command, options.scene);
  add_output_option(command, options.outputs);
  CLI::Option& output = *command.get_option("--output")->required(false);
  CLI::Option& error = *add_option(command, "--error", "E", options.error, parse_fraction,
                                   "Refine until two resolutions differ by no more, as\n"
                                   "0.0001 or 0.01%: root of the mean of difference^2 /\n"
                                   "(mean^2 + 0.01) over pixels (default: three\n"
                                   "resolutions)");
  add_size_and_bounces(command, options.scene);
  add_light_origin(command, options.scene);
  CLI::Option& elements =
      *add_option(command, "--elements", "KIND", options.is_constant, one_of(element_words),
                  "linear (default), or constant: flat patches and the\n"
                  "whole matrix of their form factors, to be seen")
           ->excludes(&error);
  CLI::Option& lesson = *add_option(command, "--teach", "DIR", options.lesson,
                                    "Write a lesson's pictures, plots and numbers")
                             ->excludes(&output)
                             ->excludes(&error)
                             ->excludes(&elements)
                             ->excludes(command.get_option("--bounces"));
  for (const char* origin : {"--from", "--by"}) {
    elements.excludes(command.get_option(origin));
    lesson.excludes(command.get_option(origin));
  }
  add_option(command, "--threads", "N", options.threads, number(1, 1024),
             "Threads at most (default: one per processor)");
  add_exposure_option(command, options.outputs);
}

size_t half_of_the_memory() {
  return size_t(::sysconf(_SC_PHYS_PAGES)) * size_t(::sysconf(_SC_PAGESIZE)) / 2;
}

struct Clock {
  std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();
  std::clock_t cpu_begin = std::clock();

  double wall_seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }
  double cpu_seconds() const { return double(std::clock() - cpu_begin) / CLOCKS_PER_SEC; }
};

Image to_image(const Scene& scene, const radiosity::Picture& picture, const Options& options,
               const Clock& clock) {
  Image image{scene.camera.width, scene.camera.height, {"R", "G", "B"}, picture.rgb, {}};
  image.provenance = {.renderer = "plumbline",
                      .version = PLUMB_VERSION,
                      .scene = scene.name,
                      .scene_hash = scene.hash,
                      .scene_notes = fmt::format("{}", fmt::join(scene.notes, "\n")),
                      .method = options.is_constant ? "constant radiosity" : "radiosity",
                      .precision = "double",
                      .bounces = to_string(scene.request.bounces),
                      .light = light_origin_words(options.scene),
                      .settings = fmt::format("elements={}", picture.elements),
                      .wall_seconds = clock.wall_seconds(),
                      .cpu_seconds = clock.cpu_seconds(),
                      .host = host(options.threads)};
  if (std::isfinite(picture.error)) {
    image.provenance.relative_error = picture.error;
    image.provenance.image_floor = picture.image_floor;
    image.provenance.region_floor = picture.block_floor;
  }
  return image;
}

std::string summary(const Scene& scene, const radiosity::Picture& picture, const Clock& clock) {
  std::string error = "error unknown";
  if (std::isfinite(picture.error)) {
    error = fmt::format(
        "from one with fewer it differs by {:.2g} % (the mean {:.2g} %, the worst "
        "block {:.2g} %)",
        100.0 * picture.error, 100.0 * picture.image_floor, 100.0 * picture.block_floor);
  }
  return fmt::format("{}, {}x{}: {} elements with {} links in {:.2f} s, {}", scene.name,
                     scene.camera.width, scene.camera.height, picture.elements, picture.links,
                     clock.wall_seconds(), error);
}

int draw_picture(const Scene& scene, const Options& options) {
  const std::optional<LightOrigin> origin = light_origin_of(scene, options.scene);
  const Clock clock;
  radiosity::Picture picture;
  {
    ProgressLine line;
    const radiosity::Work work{[&](const std::string& phase) { line.show(phase); },
                               &stop_requested};
    const auto draw = options.is_constant ? radiosity::teaching::draw_patches : radiosity::draw;
    picture = draw(scene,
                   {.bounces = scene.request.bounces,
                    .origin = origin ? &*origin : nullptr,
                    .error = options.error,
                    .most_bytes = half_of_the_memory()},
                   work);
  }
  const int interrupted_by = stop_signal;
  if (picture.level >= 0) {
    fmt::print("{}\n", summary(scene, picture, clock));
    write(to_image(scene, picture, options, clock), options.outputs);
  }
  if (picture.why_ended.empty()) return 0;
  fmt::print(stderr, "plumb: {}\n", picture.why_ended);
  return interrupted_by == 0 ? 2 : 128 + interrupted_by;
}

int write_lesson(const Scene& scene, const Options& options) {
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
  const int threads = options.threads > 0 ? options.threads : tbb::info::default_concurrency();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(threads));
  listen_for_interrupts();
  return is_lesson ? write_lesson(scene, options) : draw_picture(scene, options);
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
2 trouble (also: no memory for the wanted error), 130 interrupted.)");
  command.callback([=, &exit_code] { exit_code = run(*options); });
}

}  // namespace plumb::cli
