// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>

#include "cli/commands.h"
#include "cli/film_image.h"
#include "cli/interrupt.h"
#include "cli/names.h"
#include "cli/outputs.h"
#include "cli/progress_line.h"
#include "cli/rendering.h"
#include "cli/scene_options.h"

namespace plumb::cli {
namespace {

struct Options : RenderOptions {
  Outputs outputs;
  std::optional<RegionKind> mask;
};

void add_options(CLI::App& command, Options& options) {
  add_scene_option(command, options.scene);
  add_output_option(command, options.outputs);
  add_render_options(command, options);
  add_option(command, "--aov", "KIND", options.mask, one_of(region_words),
             "No picture but a mask for 'plumb compare --regions':\n"
             "object (a colour for each shape), side (for each\n"
             "shape's front, left, ...) or shadow (for what is\n"
             "lit, in penumbra, in umbra)");
  add_exposure_option(command, options.outputs);
}

Rendering draw_with_progress(const Scene& scene, const Options& options) {
  ProgressLine line;
  line.show("first pass");
  return draw(
      scene, options, [&](const Progress& progress) { line.show(to_text(progress)); },
      stop_requested);
}

int run(const Options& options) {
  check(options.outputs);
  const Scene scene = load_scene(options.scene);
  if (options.mask) {
    const Window window = window_of(options.crop, scene.camera);
    write(to_image(region_mask(scene, *options.mask, window), window, scene.camera),
          options.outputs);
    return 0;
  }
  listen_for_interrupts();
  const Rendering rendering = draw_with_progress(scene, options);
  const int interrupted_by = stop_signal;
  const std::string unfinished = why_unfinished(rendering.cost);
  if (!unfinished.empty()) fmt::print(stderr, "plumb: {}\n", unfinished);
  if (!rendering.image) {
    fmt::print(stderr, "plumb: {}\n", why_no_picture(rendering));
    return interrupted_by == 0 ? 2 : 128 + interrupted_by;
  }
  fmt::print("{}\n", summary(scene, rendering));
  write(*rendering.image, options.outputs);
  if (interrupted_by == 0) return 0;
  fmt::print(stderr, "plumb: interrupted, the picture has {} samples per pixel\n",
             rendering.samples_per_pixel);
  return 128 + interrupted_by;
}

}  // namespace

void add_render(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<Options>();
  CLI::App& command = *app.add_subcommand("render", "Render a scene with the path tracer");
  add_options(command, *options);
  command.footer(R"(Examples:
  plumb render reference_scenes/cornell/scene.xml -o cornell.exr
  plumb render scene.xml --error 1% --time 60 -o scene.exr -o scene.png
  plumb render scene.xml --bounces 2:2 --spp 1024 -o two_bounces.exr
  plumb render scene.xml --by left_wall -o where_the_red_comes_from.exr
  plumb render scene.xml --aov object -o objects.png
  plumb render scene.xml --size 8192x8192 --crop 0,0,8192,128 -o top.exr

The first of the limits --spp, --time and --error to be reached ends the render.
Ctrl-C saves what is finished. Exit codes: 0 done, 2 trouble, 130 interrupted.)");
  command.callback([=, &exit_code] { exit_code = run(*options); });
}

}  // namespace plumb::cli
