// SPDX-License-Identifier: Apache-2.0

#include "cli/film_image.h"

#include <OpenImageIO/color.h>
#include <fmt/ranges.h>
#include <tbb/info.h>

#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "cli/names.h"
#include "images/rgb.h"
#include "renderer/trace.h"

namespace plumb {
namespace {

constexpr size_t terms = std::tuple_size_v<decltype(ExactSum{}.terms())>;

std::string term_prefix(int replicate, size_t term) {
  return fmt::format("replicate{}.sum{}.", replicate, term);
}

bool is_sum(const std::string& channel) { return channel.starts_with("replicate"); }

}  // namespace

std::string host(int most_threads) {
  std::string processor = "unknown processor";
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("model name\t: ")) processor = line.substr(13);
  }
  const int threads = most_threads > 0 ? most_threads : tbb::info::default_concurrency();
  return fmt::format("{}, {} thread{}", processor, threads, threads == 1 ? "" : "s");
}

Image to_image(const Film& film, bool is_part) {
  // Three channels each: "variance." + "R", ...
  std::vector<std::pair<std::string, std::vector<float>>> layers{{"", film.mean()}};
  if (film.knows_variance()) layers.emplace_back("variance.", film.variance());
  for (int r = 0; is_part && r < Film::replicates; ++r) {
    if (film.samples_per_replicate()[size_t(r)] == 0) continue;
    for (size_t k = 0; k < terms; ++k) {
      layers.emplace_back(term_prefix(r, k), film.replicate_term(r, k));
    }
  }

  Image image{film.width(), film.height(), {}, {}, {}};
  for (const auto& [prefix, rgb] : layers) {
    for (const char* color : {"R", "G", "B"}) image.channels.push_back(prefix + color);
  }
  image.values.reserve(size_t(film.pixel_count()) * image.channels.size());
  for (size_t i = 0; i < size_t(film.pixel_count()) * 3; i += 3) {
    for (const auto& [prefix, rgb] : layers) {
      image.values.insert(image.values.end(), &rgb[i], &rgb[i] + 3);
    }
  }
  return image;
}

Picture to_picture(const std::string& side, const Film& film) {
  const auto has_samples = [](int64_t samples) { return samples > 0; };
  const auto replicates = std::ranges::count_if(film.samples_per_replicate(), has_samples);
  return to_picture(side, to_image(film, false), static_cast<int>(replicates));
}

bool has_sums(const Image& image) { return std::ranges::any_of(image.channels, is_sum); }

Image without_sums(Image image) {
  const std::vector<std::string> channels = std::exchange(image.channels, {});
  const std::vector<float> values = std::exchange(image.values, {});
  std::ranges::remove_copy_if(channels, std::back_inserter(image.channels), is_sum);
  for (size_t i = 0; i < values.size(); ++i) {
    if (!is_sum(channels[i % channels.size()])) image.values.push_back(values[i]);
  }
  return image;
}

void put_into_picture(Image& image, const Window& window, int width, int height) {
  if (window == Window{0, 0, width, height}) return;
  image.left = window.x;
  image.top = window.y;
  image.display = {-window.x, -window.y, width, height};
  image.provenance.crop = to_string(window);
}

Image to_image(const RegionMask& mask, const Window& window, const Camera& camera) {
  Image image{window.width, window.height, {"R", "G", "B"}, {}, {}};
  // An odd factor modulo 2^24 gives every number another colour.
  const auto color = [&](int region) {
    return region < 0 ? 0U : unsigned(mask.numbers[size_t(region)] + 1) * 0x9e3779U & 0xffffffU;
  };
  for (size_t i = 0; i < mask.names.size(); ++i) {
    image.provenance.regions.emplace_back(fmt::format("#{:06X}", color(int(i))), mask.names[i]);
  }
  for (const int region : mask.regions) {
    for (const int shift : {16, 8, 0}) {
      const unsigned code = color(region) >> shift & 0xffU;
      image.values.push_back(OIIO::sRGB_to_linear(float(code) / 255.0F));
    }
  }
  put_into_picture(image, window, camera.width, camera.height);
  return image;
}

void add_part(Film& film, const Image& part, const SampleRange& samples) {
  const Film::Counts counts = samples_per_replicate(samples);
  for (int r = 0; r < Film::replicates; ++r) {
    if (counts[size_t(r)] == 0) continue;
    for (size_t k = 0; k < terms; ++k) {
      const std::vector<float> values = rgb_of(part, term_prefix(r, k));
      if (values.empty()) {
        throw ImageError(lacks_sums);
      }
      film.add_sums(r, k == 0 ? counts[size_t(r)] : 0, values, 1.0);
    }
  }
}

Provenance describe(const Scene& scene, const Settings& settings, const SampleRange& samples,
                    const Film& film, const Cost& cost) {
  return {.renderer = "plumbline",
          .version = PLUMB_VERSION,
          .scene = scene.name,
          .scene_hash = scene.hash,
          .scene_notes = fmt::format("{}", fmt::join(scene.notes, "\n")),
          .method = to_word(settings.method, method_words),
          .sampler = to_word(settings.sampler, sampler_words),
          .precision = to_word(settings.precision, precision_words),
          .bounces = to_string(settings.bounces),
          .seed = static_cast<int>(settings.seed),
          .samples = to_string(samples),
          .brightness = scene.brightness(),
          .replicates = Film::replicates,
          .relative_error = film.relative_error(),
          .wall_seconds = cost.wall_seconds,
          .cpu_seconds = cost.cpu_seconds,
          .rays = static_cast<double>(cost.rays),
          .host = fmt::format("{}, {}", host(settings.threads), trace_target())};
}

}  // namespace plumb
