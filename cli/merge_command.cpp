#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "cli/commands.h"
#include "cli/film_image.h"
#include "cli/names.h"

namespace plumb::cli {
namespace {

// What parts must have in common.
constexpr const char* common_keys[] = {"renderer", "version", "scene",   "sceneHash", "method",
                                       "sampler",  "seed",    "bounces", "precision", "replicates"};

struct Options {
  std::vector<std::string> parts;
  std::string output;
};

struct Part {
  std::string file;
  SampleRange samples;
};

// Null if there is none.
Metadata::value_type::second_type* find(Metadata& metadata, std::string_view key) {
  const auto entry = std::ranges::find(metadata, key, &Metadata::value_type::first);
  return entry == metadata.end() ? nullptr : &entry->second;
}

template <typename T>
T& get(Metadata& metadata, std::string_view key) {
  T* value = std::get_if<T>(find(metadata, key));
  if (value == nullptr) throw ImageError(fmt::format("not a part of a render: lacks {}", key));
  return *value;
}

// Adds a part's metadata to the whole's.
void add(Metadata& whole, Metadata& part) {
  for (const char* key : common_keys) {
    const auto* a = find(whole, key);
    const auto* b = find(part, key);
    if (a == nullptr || b == nullptr || *a != *b) {
      throw ImageError(fmt::format("not the same {} as in the parts before", key));
    }
  }
  for (const char* key : {"wallSeconds", "cpuSeconds", "rays"}) {
    get<double>(whole, key) += get<double>(part, key);
  }
  auto& hosts = get<std::string>(whole, "host");
  const auto& host = get<std::string>(part, "host");
  if (hosts.find(host) == std::string::npos) hosts += "; " + host;
}

SampleRange join(std::vector<Part> parts) {
  std::ranges::sort(parts, {}, [](const Part& part) { return part.samples.first; });
  for (size_t i = 1; i < parts.size(); ++i) {
    const auto& [file, samples] = parts[i];
    const auto& [file_before, before] = parts[i - 1];
    if (samples.first < before.last) {
      throw ImageError(fmt::format("{} and {} overlap: samples {} and {}", file_before, file,
                                   to_string(before), to_string(samples)));
    }
    if (samples.first > before.last) {
      throw ImageError(fmt::format("samples {}:{} are missing between {} and {}", before.last,
                                   samples.first, file_before, file));
    }
  }
  return {parts.front().samples.first, parts.back().samples.last};
}

int run(const Options& options) {
  image_format(options.output);
  check_writable(options.output);
  std::vector<Part> parts;
  std::optional<Film> film;
  Metadata metadata;
  for (const std::string& file : options.parts) {
    Image image = read_image(file);
    try {
      parts.push_back({file, parse_samples(get<std::string>(image.metadata, "samples"))});
      if (!film) {
        film.emplace(image.width, image.height);
        metadata = image.metadata;
      } else {
        add(metadata, image.metadata);
      }
      add_part(*film, image, parts.back().samples);
    } catch (const std::exception& error) {
      throw ImageError(fmt::format("{}: {}", file, error.what()));
    }
  }
  const SampleRange samples = join(parts);
  get<std::string>(metadata, "samples") = to_string(samples);
  get<double>(metadata, "relativeError") = film->relative_error();
  Image whole = to_image(*film, true);
  whole.metadata = std::move(metadata);
  write_image(whole, options.output);
  fmt::print("{}: {} spp from {} parts, {}\nwrote {}\n", get<std::string>(whole.metadata, "scene"),
             film->samples_per_pixel(), parts.size(), error_text(film->relative_error()),
             options.output);
  return 0;
}

}  // namespace

void add_merge(CLI::App& app, Run& run_command) {
  auto options = std::make_shared<Options>();
  CLI::App& command =
      *app.add_subcommand("merge", "Put together what 'render --samples' has drawn");
  command.add_option("PART", options->parts, "The parts' .exr files, in any order")
      ->required()
      ->option_text("...")
      ->group("Input");
  command.add_option("-o,--output", options->output, "Where to write the whole: .exr or .png")
      ->required()
      ->option_text("FILE")
      ->type_name("value")
      ->group("Output");
  command.footer(R"(Example:
  plumb render scene.xml --samples 0:64 -o a.exr
  plumb render scene.xml --samples 64:128 -o b.exr
  plumb merge a.exr b.exr -o whole.exr

The whole is what '--samples 0:128' would have given, up to rounding, and
can be merged in turn. Parts that overlap, leave a gap or differ in scene, size,
seed or method are refused. Exit codes: 0 done, 2 trouble.)");
  command.final_callback([=, &run_command] { run_command = [options] { return run(*options); }; });
}

}  // namespace plumb::cli
