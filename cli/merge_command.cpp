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

Metadata::value_type::second_type& find(Metadata& metadata, std::string_view key) {
  const auto entry = std::ranges::find(metadata, key, &Metadata::value_type::first);
  if (entry != metadata.end()) return entry->second;
  throw ImageError(fmt::format("not a part of a render: lacks {}", key));
}

template <typename T>
T& get(Metadata& metadata, std::string_view key) {
  T* value = std::get_if<T>(&find(metadata, key));
  if (value == nullptr) throw ImageError(fmt::format("not a part of a render: odd {}", key));
  return *value;
}

// Adds a part's metadata to the whole's.
void add(Metadata& whole, Metadata& part) {
  for (const char* key : common_keys) {
    if (find(whole, key) != find(part, key)) {
      throw ImageError(fmt::format("not the same {} as in the parts before", key));
    }
  }
  const auto fault = [](const Metadata& metadata) {
    return metadata_value<std::string>(metadata, "fault");
  };
  if (fault(whole) != fault(part)) throw ImageError("not the same fault as in the parts before");
  for (const char* key : {"wallSeconds", "cpuSeconds", "rays"}) {
    get<double>(whole, key) += get<double>(part, key);
  }
  auto& hosts = get<std::string>(whole, "host");
  const auto& host = get<std::string>(part, "host");
  if (hosts.find(host) == std::string::npos) hosts += "; " + host;
}

SampleRange join(std::vector<SampleRange> parts) {
  std::ranges::sort(parts, {}, &SampleRange::first);
  for (size_t i = 1; i < parts.size(); ++i) {
    if (parts[i].first == parts[i - 1].last) continue;
    throw ImageError(fmt::format("samples {} and {} {}", to_string(parts[i - 1]),
                                 to_string(parts[i]),
                                 parts[i].first < parts[i - 1].last ? "overlap" : "leave a gap"));
  }
  return {parts.front().first, parts.back().last};
}

void run(const Options& options) {
  image_format(options.output);
  check_writable(options.output);
  std::vector<SampleRange> parts;
  std::optional<Film> film;
  Metadata metadata;
  for (const std::string& file : options.parts) {
    Image image = read_image(file);
    try {
      parts.push_back(parse_samples(get<std::string>(image.metadata, "samples")));
      if (!film) {
        film.emplace(image.width, image.height);
        metadata = image.metadata;
      } else {
        add(metadata, image.metadata);
      }
      add_part(*film, image, parts.back());
    } catch (const std::exception& error) {
      throw ImageError(fmt::format("{}: {}", file, error.what()));
    }
  }
  get<std::string>(metadata, "samples") = to_string(join(parts));
  get<double>(metadata, "relativeError") = film->relative_error();
  Image whole = to_image(*film, true);
  whole.metadata = std::move(metadata);
  write_image(whole, options.output);
  fmt::print("{}: {} spp from {} parts, relative error {:.2f} %\nwrote {}\n",
             get<std::string>(whole.metadata, "scene"), film->samples_per_pixel(), parts.size(),
             100.0 * film->relative_error(), options.output);
}

}  // namespace

void add_merge(CLI::App& app) {
  auto options = std::make_shared<Options>();
  CLI::App& command =
      *app.add_subcommand("merge", "Put together what 'render --samples' has drawn");
  command.add_option("PART", options->parts, "The parts' .exr files, in any order")
      ->required()
      ->type_name("");
  command.add_option("-o,--output", options->output, "Where to write the whole: .exr or .png")
      ->required()
      ->type_name("FILE");
  command.footer(R"(Example:
  plumb render scene.xml --samples 0:64 -o a.exr
  plumb render scene.xml --samples 64:128 -o b.exr
  plumb merge a.exr b.exr -o whole.exr

The whole is what '--samples 0:128' would have given, up to rounding, and
can be merged in turn. Parts that overlap, leave a gap or differ in scene, size,
seed or method are refused. Exit codes: 0 done, 2 trouble.)");
  command.callback([options] { run(*options); });
}

}  // namespace plumb::cli
