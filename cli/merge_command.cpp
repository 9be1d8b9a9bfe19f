// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/commands.h"
#include "cli/film_image.h"
#include "cli/names.h"

namespace plumb::cli {
namespace {

struct Options {
  std::vector<std::string> parts;
  std::string output;
};

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
  Provenance provenance;
  for (const std::string& file : options.parts) {
    Image image = read_image(file);
    try {
      if (!image.provenance.samples) throw ImageError("not a part of a render: lacks samples");
      parts.push_back(parse_samples(*image.provenance.samples));
      if (!film) {
        film.emplace(image.width, image.height);
        film->set_brightness(image.provenance.brightness.value_or(1.0));
        provenance = image.provenance;
      } else {
        add_part(provenance, image.provenance);
      }
      add_part(*film, image, parts.back());
    } catch (const std::exception& error) {
      throw ImageError(fmt::format("{}: {}", file, error.what()));
    }
  }
  provenance.samples = to_string(join(parts));
  provenance.relative_error = film->relative_error();
  Image whole = to_image(*film, true);
  whole.provenance = std::move(provenance);
  write_image(whole, options.output);
  fmt::print("{}: {} spp from {} parts, relative error {:.2f} %\nwrote {}\n",
             whole.provenance.scene.value_or(""), film->samples_per_pixel(), parts.size(),
             100.0 * film->relative_error(), options.output);
}

}  // namespace

void add_merge(CLI::App& app, int&) {
  auto options = std::make_shared<Options>();
  CLI::App& command =
      *app.add_subcommand("merge", "Put together what 'render --samples' has drawn");
  add_option(command, "PART", "", options->parts, "The parts' .exr files, in any order")
      ->required();
  add_option(command, "-o,--output", "FILE", options->output,
             "Where to write the whole: .exr or .png")
      ->required();
  command.footer(R"(Example:
  plumb render scene.xml --samples 0:64 -o a.exr
  plumb render scene.xml --samples 64:128 -o b.exr
  plumb merge a.exr b.exr -o whole.exr

The whole has the bits that '--samples 0:128' would have given, and can be
merged in turn. Parts that overlap, leave a gap or differ in scene, size, seed
or method are refused. Exit codes: 0 done, 2 trouble.)");
  command.callback([options] { run(*options); });
}

}  // namespace plumb::cli
