// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/commands.h"
#include "cli/film_image.h"
#include "cli/names.h"
#include "images/replicates.h"
#include "images/rgb.h"
#include "other_renderers/runner.h"

namespace plumb::cli {
namespace {

struct Options {
  std::vector<std::string> parts;
  std::string output;
  bool is_last = false;
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

// Calls `add` with one picture after the other, since all at once may be too large.
template <typename Add>
void for_each_part(const Options& options, Add add) {
  for (const std::string& file : options.parts) {
    Image image = read_image(file);
    try {
      add(std::move(image));
    } catch (const std::exception& error) {
      throw ImageError(fmt::format("{}: {}", file, error.what()));
    }
  }
}

// Of what 'render --samples' has drawn.
Image merge_samples(const Options& options) {
  std::vector<SampleRange> parts;
  std::optional<Film> film;
  Provenance provenance;
  for_each_part(options, [&](const Image& image) {
    if (!image.provenance.samples) {
      throw ImageError("not a part of a render: lacks samples");
    }
    parts.push_back(parse_samples(*image.provenance.samples));
    if (!film) {
      film.emplace(image.width, image.height);
      film->set_brightness(image.provenance.brightness.value_or(1.0));
      provenance = image.provenance;
    } else {
      add_part(provenance, image.provenance);
    }
    add_part(*film, image, parts.back());
  });
  provenance.samples = to_string(join(parts));
  provenance.relative_error = film->relative_error();
  Image whole = to_image(*film, !options.is_last);
  whole.provenance = std::move(provenance);
  return whole;
}

// Of pictures by another program, each of one seed: what 'reference --seeds' writes.
Image merge_seeds(const Options& options) {
  std::optional<Image> first;
  std::vector<Replicates<double>> values;
  nlohmann::json runs = nlohmann::json::array();
  double samples = 0.0;
  int seeds = 0;
  for_each_part(options, [&](Image image) {
    Provenance& part = image.provenance;
    const std::vector<float> rgb = rgb_of(image);
    if (part.replicates != 1 || !part.seed) throw ImageError("not of a single seed");
    samples += part.samples_per_pixel();
    runs.insert(runs.end(), nlohmann::json::parse(part.runs.value_or("[]")));
    if (!first) {
      values.resize(rgb.size());
      first = std::move(image);
    } else {
      if (*part.seed != *first->provenance.seed + seeds) {
        throw ImageError("its seed does not follow that of the part before");
      }
      part.seed = first->provenance.seed;
      add_part(first->provenance, part);
    }
    if (rgb.size() != values.size()) throw ImageError("not the same size as the parts before");
    for (size_t i = 0; i < rgb.size(); ++i) values[i].add(double{rgb[i]});
    ++seeds;
  });
  Image whole = mean_of(values, first->width, first->height);
  whole.provenance = first->provenance;
  whole.provenance.replicates = seeds;
  whole.provenance.samples = to_string(SampleRange{0, int64_t(samples)});
  whole.provenance.runs = runs.dump();
  return whole;
}

void run(const Options& options) {
  image_format(options.output);
  check_writable(options.output);
  const bool is_ours = read_image(options.parts.front()).provenance.renderer == "plumbline";
  const Image whole = is_ours ? merge_samples(options) : merge_seeds(options);
  write_image(whole, options.output);
  const Provenance& made = whole.provenance;
  fmt::print("{}: {} spp from {} parts{}\nwrote {}\n", made.scene.value_or(""),
             made.samples_per_pixel(), options.parts.size(),
             made.relative_error
                 ? fmt::format(", relative error {:.2f} %", 100.0 * *made.relative_error)
                 : "",
             options.output);
}

}  // namespace

void add_merge(CLI::App& app, int&) {
  auto options = std::make_shared<Options>();
  CLI::App& command =
      *app.add_subcommand("merge", "Put together what was drawn by samples or seeds");
  add_option(command, "PART", "", options->parts, "The parts' .exr files, in any order")
      ->required();
  add_option(command, "-o,--output", "FILE", options->output,
             "Where to write the whole: .exr or .png")
      ->required();
  command.add_flag("--last", options->is_last,
                   "Nothing will be added any more: leave out the sums that\n"
                   "merging takes, as 'render --spp' does");
  command.footer(R"(Example:
  plumb render scene.xml --samples 0:64 -o a.exr
  plumb render scene.xml --samples 64:128 -o b.exr
  plumb merge a.exr b.exr --last -o whole.exr

The whole has the bits that '--samples 0:128' would have given, and can be
merged in turn. Parts that overlap, leave a gap or differ in scene, size, seed
or method are refused. Pictures that 'reference --seeds 1' has another program
draw give what more seeds at once would have, if named in the seeds' order.
Exit codes: 0 done, 2 trouble.)");
  command.callback([options] { run(*options); });
}

}  // namespace plumb::cli
