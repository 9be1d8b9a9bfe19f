#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "cli/commands.h"
#include "cli/film_image.h"
#include "cli/names.h"
#include "cli/progress_line.h"
#include "renderer/render.h"
#include "renderer/scene_reader.h"

namespace plumb::cli {
namespace {

namespace fs = std::filesystem;

constexpr int64_t default_spp = 64;

std::atomic<bool> stop_requested{false};
std::atomic<int> stop_signal{0};

// The first signal ends the render with the pass under way; a second one kills as usual.
extern "C" void request_stop(int signal) {
  stop_requested = true;
  stop_signal = signal;
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

struct Options {
  std::string scene;
  std::vector<std::string> outputs;
  Settings settings;
  Limits limits;
  std::optional<int64_t> spp;
  std::optional<SampleRange> samples;
  std::optional<std::pair<int, int>> size;
  std::optional<double> exposure;
};

// Options under one heading of the help.
struct Group {
  CLI::App& command;
  const char* heading;

  // Adds "--name VALUE"; `parse` turns the text into a value or throws std::invalid_argument.
  template <typename Target, typename Parse>
  CLI::Option* add(const std::string& name, const std::string& value, Target& target, Parse parse,
                   const std::string& help) const {
    const auto store = [name, parse, &target](const std::string& text) {
      try {
        target = parse(text);
      } catch (const std::invalid_argument& error) {
        throw CLI::ValidationError(name, error.what());
      }
    };
    return command.add_option_function<std::string>(name, store, help)
        ->option_text(value)
        ->type_name("value")
        ->take_last()
        ->group(heading);
  }
};

template <typename T>
auto whole(int64_t least, int64_t most) {
  return [=](const std::string& text) { return static_cast<T>(parse_whole(text, least, most)); };
}

void add_files(CLI::App& command, Options& options) {
  const Group input{command, "Input"};
  command.add_option("SCENE", options.scene, "Scene file, in a subset of Mitsuba 3's XML")
      ->required()
      ->group(input.heading);
  input.add("--size", "WxH", options.size, parse_size, "Width and height (default: the scene's)");

  const Group output{command, "Output"};
  command
      .add_option("-o,--output", options.outputs,
                  "Where to write: .exr keeps linear float and noise;\n"
                  ".png is an sRGB preview; can be given more than once")
      ->required()
      ->option_text("FILE")
      ->type_name("value")
      ->allow_extra_args(false)
      ->group(output.heading);
  output.add(
      "--exposure", "EV", options.exposure,
      [](const std::string& text) { return parse_between(text, -100.0, 100.0); },
      "Brighten the .png by so many stops (default: 0)");
}

void add_limits(CLI::App& command, Options& options) {
  const Group end{command, "End of rendering, whichever comes first"};
  CLI::Option* spp = end.add("--spp", "N", options.spp, whole<int64_t>(1, largest_sample),
                             "Samples per pixel (default: 64, but without a limit\n"
                             "with --time or --error)");
  CLI::Option* time =
      end.add("--time", "SECONDS", options.limits.seconds, parse_positive, "Time of rendering");
  CLI::Option* error = end.add("--error", "E", options.limits.relative_error, parse_fraction,
                               "Relative error, as 0.01 or 1%: root of the mean of\n"
                               "variance / (mean^2 + 0.01) over pixels, estimated");
  end.add("--samples", "A:B", options.samples, parse_samples,
          "Instead of the above: samples A <= s < B of every\n"
          "pixel, as a part for 'plumb merge'")
      ->excludes(spp)
      ->excludes(time)
      ->excludes(error);
}

void add_settings(CLI::App& command, Settings& settings) {
  const Group method{command, "Method"};
  method.add("--method", "M", settings.method, parse_method,
             "How paths find lamps: bsdf (by chance), nee (lamps are\n"
             "sampled) or mis (both, weighted; default)");
  method.add("--sampler", "S", settings.sampler, parse_sampler,
             "sobol (Owen-scrambled; default) or independent");
  method.add("--precision", "P", settings.precision, parse_precision,
             "Arithmetic: float (default) or double");
  method.add("--bounces", "A:B", settings.bounces, parse_bounces,
             "Only light of A to B bounces: 0 is emission seen\n"
             "directly, 1 direct light; 'A:' for A and more");
  method.add("--seed", "N", settings.seed, whole<uint32_t>(0, 0x7fffffff),
             "Another seed gives other noise (default: 0)");
  const Group other{command, "Options"};
  other.add("--threads", "N", settings.threads, whole<int>(1, 1024),
            "Threads at most (default: one per processor); the\n"
            "picture doesn't depend on it");
}

void check_outputs(const Options& options) {
  std::set<fs::path> files;
  bool any_png = false;
  for (const std::string& file : options.outputs) {
    any_png |= image_format(file) == ImageFormat::png;
    check_writable(file);
    if (!files.insert(fs::weakly_canonical(fs::absolute(file))).second) {
      throw ImageError(fmt::format("--output: {} is given twice", file));
    }
  }
  if (options.exposure && !any_png) {
    throw ImageError("--exposure brightens .png only, and no --output is one");
  }
}

Scene load_scene(const Options& options) {
  Scene scene = read_scene(options.scene);
  if (options.size) std::tie(scene.camera.width, scene.camera.height) = *options.size;
  if (std::ranges::none_of(scene.shapes, &Shape::is_lamp)) {
    fmt::print(stderr, "plumb: warning: {}: no lamp, the picture will be black\n", options.scene);
  }
  return scene;
}

Limits limits_of(const Options& options) {
  Limits limits = options.limits;
  const bool has_other_limit = std::isfinite(limits.seconds) || limits.relative_error > 0.0;
  limits.samples = options.samples.value_or(
      SampleRange{0, options.spp.value_or(has_other_limit ? largest_sample : default_spp)});
  return limits;
}

std::string millions_per_second(int64_t count, const Cost& cost, const char* what) {
  return fmt::format("{:.1f} M{}/s", static_cast<double>(count) / 1e6 / cost.wall_seconds, what);
}

Cost render_with_progress(const Scene& scene, const Options& options, const Limits& limits,
                          Film& film) {
  ProgressLine line;
  line.show("first pass");
  const auto show = [&](const Progress& progress) {
    line.show(fmt::format("{} spp, {}, {}, {} left", progress.samples_per_pixel,
                          error_text(progress.relative_error),
                          millions_per_second(progress.cost.samples, progress.cost, "samples"),
                          duration(progress.seconds_left)));
  };
  return render(scene, options.settings, limits, film, show, &stop_requested);
}

int run(const Options& options) {
  check_outputs(options);
  const Scene scene = load_scene(options);
  const Limits limits = limits_of(options);
  Film film(scene.camera.width, scene.camera.height);
  std::signal(SIGINT, request_stop);
  std::signal(SIGTERM, request_stop);
  const Cost cost = render_with_progress(scene, options, limits, film);
  const int interrupted_by = stop_signal;

  const int64_t first = limits.samples.first;
  Image image = to_image(film, options.samples.has_value());
  image.metadata =
      describe(scene, options.settings, {first, first + film.samples_per_pixel()}, film, cost);
  fmt::print("{}, {}x{}: {} spp in {:.2f} s ({}, {}), {}\n", scene.name, film.width(),
             film.height(), film.samples_per_pixel(), cost.wall_seconds,
             millions_per_second(cost.samples, cost, "samples"),
             millions_per_second(cost.rays, cost, "rays"), error_text(film.relative_error()));
  for (const std::string& file : options.outputs) {
    write_image(image, file, options.exposure.value_or(0.0));
    fmt::print("wrote {}\n", file);
  }
  if (interrupted_by == 0) return 0;
  fmt::print(stderr, "plumb: interrupted, the picture has {} samples per pixel\n",
             film.samples_per_pixel());
  return 128 + interrupted_by;
}

}  // namespace

void add_render(CLI::App& app, Run& run_command) {
  auto options = std::make_shared<Options>();
  CLI::App& command = *app.add_subcommand("render", "Render a scene with the path tracer");
  add_files(command, *options);
  add_limits(command, *options);
  add_settings(command, options->settings);
  command.footer(R"(Examples:
  plumb render reference_scenes/cornell/scene.xml -o cornell.exr
  plumb render scene.xml --error 1% --time 60 -o scene.exr -o scene.png
  plumb render scene.xml --bounces 2:2 --spp 1024 -o two_bounces.exr

Ctrl-C saves what is finished. Exit codes: 0 done, 2 trouble, 130 interrupted.)");
  command.final_callback([=, &run_command] { run_command = [options] { return run(*options); }; });
}

}  // namespace plumb::cli
