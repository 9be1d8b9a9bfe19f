#include "cli/film_image.h"

#include <fmt/format.h>
#include <sys/utsname.h>
#include <tbb/info.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <vector>

#include "cli/names.h"
#include "renderer/trace.h"

namespace plumb {
namespace {

// Three channels of an image: "variance." + "R", ...
struct Layer {
  std::string prefix;
  std::vector<float> rgb;
};

std::string replicate_prefix(int replicate) { return fmt::format("replicate{}.", replicate); }

// Of the whole machine; where /proc doesn't name the processor, its architecture.
std::string processor_name() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    const size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  utsname system{};
  return uname(&system) == 0 ? system.machine : "unknown processor";
}

std::string host(const Settings& settings) {
  const int available = tbb::info::default_concurrency();
  const int threads = settings.threads > 0 ? std::min(settings.threads, available) : available;
  return fmt::format("{}, {} {}, {}", processor_name(), threads,
                     threads == 1 ? "thread" : "threads", trace_target());
}

}  // namespace

Image to_image(const Film& film, bool is_part) {
  std::vector<Layer> layers{{"", film.mean()}};
  if (film.knows_variance()) layers.push_back({"variance.", film.variance()});
  for (int r = 0; is_part && r < Film::replicates; ++r) {
    if (film.samples_per_replicate()[size_t(r)] == 0) continue;
    layers.push_back({replicate_prefix(r), film.replicate_mean(r)});
  }

  Image image{film.width(), film.height(), {}, {}, {}};
  for (const Layer& layer : layers) {
    for (const char* color : {"R", "G", "B"}) image.channels.push_back(layer.prefix + color);
  }
  image.values.reserve(size_t(film.pixel_count()) * image.channels.size());
  for (size_t i = 0; i < size_t(film.pixel_count()) * 3; i += 3) {
    for (const Layer& layer : layers) {
      image.values.insert(image.values.end(), &layer.rgb[i], &layer.rgb[i] + 3);
    }
  }
  return image;
}

void add_part(Film& film, const Image& part, const SampleRange& samples) {
  if (part.width != film.width() || part.height != film.height()) {
    throw ImageError(fmt::format("{}x{} pixels, not {}x{} as in the parts before", part.width,
                                 part.height, film.width(), film.height()));
  }
  const Film::Counts counts = samples_per_replicate(samples);
  for (int r = 0; r < Film::replicates; ++r) {
    if (counts[size_t(r)] == 0) continue;
    const auto red = std::ranges::find(part.channels, replicate_prefix(r) + "R");
    if (part.channels.end() - red < 3) {
      throw ImageError("lacks replicates: only what --samples has rendered can be merged");
    }
    std::vector<float> mean;
    mean.reserve(size_t(film.pixel_count()) * 3);
    for (size_t i = size_t(red - part.channels.begin()); i < part.values.size();
         i += part.channels.size()) {
      mean.insert(mean.end(), &part.values[i], &part.values[i] + 3);
    }
    film.add_mean(r, counts[size_t(r)], mean);
  }
}

Metadata describe(const Scene& scene, const Settings& settings, const SampleRange& samples,
                  const Film& film, const Cost& cost) {
  return {{"renderer", "plumbline"},
          {"version", PLUMB_VERSION},
          {"scene", scene.name},
          {"sceneHash", scene.hash},
          {"method", to_string(settings.method)},
          {"sampler", to_string(settings.sampler)},
          {"precision", to_string(settings.precision)},
          {"bounces", to_string(settings.bounces)},
          {"seed", static_cast<int>(settings.seed)},
          {"samples", to_string(samples)},
          {"replicates", Film::replicates},
          {"relativeError", film.relative_error()},
          {"wallSeconds", cost.wall_seconds},
          {"cpuSeconds", cost.cpu_seconds},
          {"rays", static_cast<double>(cost.rays)},
          {"host", host(settings)}};
}

std::string error_text(double relative_error) {
  if (!std::isfinite(relative_error)) return "relative error unknown";
  return fmt::format("relative error {:.2f} %", 100.0 * relative_error);
}

}  // namespace plumb
