// SPDX-License-Identifier: Apache-2.0

#include "cli/rendering.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "cli/commands.h"
#include "cli/film_image.h"
#include "cli/names.h"
#include "cli/words.h"
#include "light_origins/trace_selected.h"

namespace plumb::cli {
namespace {

Limits limits_of(const RenderOptions& options, const Scene& scene) {
  Limits limits = options.limits;
  const bool has_other_limit = std::isfinite(limits.seconds) || limits.relative_error > 0.0;
  if (options.samples && (options.spp || has_other_limit)) {
    throw std::invalid_argument("--samples excludes --spp, --time and --error");
  }
  const int64_t asked = scene.request.samples_per_pixel;
  const int64_t usual = has_other_limit ? largest_sample : asked > 0 ? asked : 64;
  limits.samples = options.samples.value_or(SampleRange{0, options.spp.value_or(usual)});
  return limits;
}

void complete(RenderOptions& options, const Scene& scene) {
  Settings& settings = options.settings;
  const bool has_fault = options.fault != Fault::none;
  settings.bounces = scene.request.bounces;
  settings.method = options.method ? *options.method
                    : has_fault    ? Method::mis
                                   : fitting_method(scene);
  const bool is_plain = settings.method == Method::plain;
  settings.sampler = options.sampler.value_or(is_plain ? Sampler::independent : Sampler::sobol);
  settings.precision = options.precision ? *options.precision
                       : is_plain        ? Precision::float64
                       : has_fault       ? Precision::float32
                                         : fitting_precision(scene);
}

std::string rate(const Cost& cost, int64_t count) {
  return fmt::format("{:.1f} M", static_cast<double>(count) / 1e6 / cost.wall_seconds);
}

std::string error_text(double relative_error) {
  if (!std::isfinite(relative_error)) return "relative error unknown";
  return fmt::format("relative error {:.2f} %", 100.0 * relative_error);
}

}  // namespace

void add_render_options(CLI::App& command, RenderOptions& options) {
  Settings& settings = options.settings;
  Limits& limits = options.limits;
  add_option(command, "--spp", "N", options.spp, number<int64_t>(1, largest_sample),
             "Samples per pixel (default: the scene's, else 64, if\n"
             "there is no other limit)");
  add_option(command, "--time", "SECONDS", limits.seconds, number(1e-3, 1e9), "Time of rendering");
  add_option(command, "--error", "E", limits.relative_error, parse_fraction,
             "Relative error, as 0.01 or 1%: root of the mean of\n"
             "variance / (mean^2 + 0.01) over pixels. Other samples\n"
             "tell how many it takes, so that none is chosen for it");
  add_option(command, "--samples", "A:B", options.samples, parse_samples,
             "Samples A <= s < B of every pixel, for 'plumb merge'");
  add_option(command, "--crop", "X,Y,W,H", options.crop, parse_window,
             "Only these pixels, in the place that they have in the\n"
             "picture, with the bits that they have there");
  add_option(command, "--method", "M", options.method, one_of(method_words),
             "How paths find lamps: bsdf (by chance), nee (lamps are\n"
             "sampled) or mis (both, weighted; default, unless every\n"
             "path meets lamps by chance); or plain,\n"
             "the same by slow, simple code in double precision");
  add_option(command, "--sampler", "S", options.sampler, one_of(sampler_words),
             "sobol (Owen-scrambled; default) or independent");
  add_option(command, "--precision", "P", options.precision, one_of(precision_words),
             "Arithmetic: float or double (default: float, unless the\n"
             "scene needs double)");
  add_size_and_bounces(command, options.scene);
  add_light_origin(command, options.scene);
  add_option(command, "--seed", "N", settings.seed, number<uint32_t>(0, 0x7fffffff),
             "Another seed gives other noise (default: 1; stored\n"
             "references have 0)");
  add_option(command, "--threads", "N", settings.threads, number(1, 1024),
             "Threads at most (default: one per processor)");
  add_option(command, "--fault", "NAME", options.fault, parse_fault,
             "Plant one of 'plumb faults', to see whether it is found\n"
             "(those of the integrator: float only)");
}

RenderOptions parse_render_options(const std::vector<std::string>& words) {
  return parse_words<RenderOptions>(add_render_options, words);
}

Rendering draw(Scene scene, RenderOptions options, const ProgressCallback& progress,
               const std::atomic<bool>& stop) {
  const Limits limits = limits_of(options, scene);
  complete(options, scene);
  const std::optional<LightOrigin> origin = light_origin_of(scene, options.scene);
  plant(options.fault, scene, options.settings);
  if (origin && (options.settings.tracer != nullptr || options.settings.method == Method::plain)) {
    throw std::invalid_argument(
        "--from and --by exclude faults of the integrator and method plain");
  }
  if (origin) select_light(*origin, options.settings);
  const Window window = window_of(options.crop, scene.camera);
  if (options.crop && options.fault != Fault::none &&
      description(options.fault).site == FaultSite::picture) {
    throw std::invalid_argument("--crop excludes faults that are done to the finished picture");
  }
  Film film(window);
  const Cost cost = render(scene, options.settings, limits, film, progress, &stop);
  Rendering rendering{{}, cost, film.samples_per_pixel(), film.relative_error()};
  if (rendering.samples_per_pixel == 0) return rendering;
  const int64_t first = limits.samples.first;
  Image image =
      to_image(spoil(options.fault, film, scene, options.settings), options.samples.has_value());
  image.provenance =
      describe(scene, options.settings, {first, first + rendering.samples_per_pixel}, film, cost);
  put_into_picture(image, window, scene.camera.width, scene.camera.height);
  image.provenance.light = light_origin_words(options.scene);
  if (options.fault != Fault::none) image.provenance.fault = fault_name(options.fault);
  rendering.image = std::move(image);
  return rendering;
}

Window window_of(const std::optional<Window>& crop, const Camera& camera) {
  const Window whole{0, 0, camera.width, camera.height};
  const Window window = crop.value_or(whole);
  if (intersection(window, whole) == window) return window;
  throw std::invalid_argument(fmt::format("--crop {} reaches beyond the picture, which has {}x{}",
                                          to_string(window), camera.width, camera.height));
}

std::string to_text(const Progress& progress) {
  const auto left = std::chrono::seconds(std::lround(std::min(359999.0, progress.seconds_left)));
  return fmt::format("{} spp, {}samples/s, {}, {:%T} left", progress.samples_per_pixel,
                     rate(progress.cost, progress.cost.samples),
                     error_text(progress.relative_error), left);
}

std::string summary(const Scene& scene, const Rendering& rendering) {
  const Cost& cost = rendering.cost;
  const auto& crop = rendering.image->provenance.crop;
  return fmt::format("{}, {}{}x{}: {} spp in {:.2f} s ({}samples/s, {}rays/s), {}", scene.name,
                     crop ? *crop + " of " : "", scene.camera.width, scene.camera.height,
                     rendering.samples_per_pixel, cost.wall_seconds, rate(cost, cost.samples),
                     rate(cost, cost.rays), error_text(rendering.relative_error));
}

std::string why_no_picture(const Rendering& rendering) {
  return fmt::format("no pass was finished in {:.1f} s: there is no picture to save",
                     rendering.cost.wall_seconds);
}

}  // namespace plumb::cli
