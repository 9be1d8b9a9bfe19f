// SPDX-License-Identifier: Apache-2.0

#include "cli/radiosity_drawing.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <ctime>

#include "cli/commands.h"
#include "cli/film_image.h"
#include "cli/names.h"
#include "cli/words.h"
#include "radiosity/teaching/patch_picture.h"

namespace plumb::cli {
namespace {

const Words<bool> element_words{{"linear", false}, {"constant", true}};

struct Clock {
  std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();
  std::clock_t cpu_begin = std::clock();

  double wall_seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }
  double cpu_seconds() const { return double(std::clock() - cpu_begin) / CLOCKS_PER_SEC; }
};

Image to_image(const Scene& scene, const radiosity::Picture& picture,
               const RadiosityOptions& options, const Clock& clock) {
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
                      .quality = fmt::format("{} elements", picture.elements),
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

}  // namespace

size_t half_of_the_memory() {
  return size_t(::sysconf(_SC_PHYS_PAGES)) * size_t(::sysconf(_SC_PAGESIZE)) / 2;
}

void add_radiosity_options(CLI::App& command, RadiosityOptions& options) {
  CLI::Option& error = *add_option(command, "--error", "E", options.error, parse_fraction,
                                   "Refine until two resolutions differ by no more, as\n"
                                   "0.0001 or 0.01%: root of the mean of difference^2 /\n"
                                   "(mean^2 + 0.01) over pixels (default: three\n"
                                   "resolutions)");
  add_size_and_bounces(command, options.scene);
  add_light_origin(command, options.scene);
  add_option(command, "--elements", "KIND", options.is_constant, one_of(element_words),
             "linear (default), or constant: flat patches and the\n"
             "whole matrix of their form factors, to be seen")
      ->excludes(&error)
      ->excludes(command.get_option("--from"))
      ->excludes(command.get_option("--by"));
  add_option(command, "--threads", "N", options.threads, number(1, 1024),
             "Threads at most (default: one per processor)");
}

RadiosityOptions parse_radiosity_options(const std::vector<std::string>& words) {
  return parse_words<RadiosityOptions>(add_radiosity_options, words);
}

RadiosityDrawing draw(const Scene& scene, const RadiosityOptions& options,
                      const radiosity::Work& work) {
  const int threads = options.threads > 0 ? options.threads : tbb::info::default_concurrency();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(threads));
  const Clock clock;
  const std::optional<LightOrigin> origin = light_origin_of(scene, options.scene);
  const auto draw = options.is_constant ? radiosity::teaching::draw_patches : radiosity::draw;
  const radiosity::Picture picture = draw(scene,
                                          {.bounces = scene.request.bounces,
                                           .origin = origin ? &*origin : nullptr,
                                           .error = options.error,
                                           .most_bytes = half_of_the_memory()},
                                          work);
  RadiosityDrawing drawing;
  drawing.why_ended = picture.why_ended;
  if (picture.level < 0) return drawing;
  drawing.summary = summary(scene, picture, clock);
  drawing.image = to_image(scene, picture, options, clock);
  return drawing;
}

}  // namespace plumb::cli
