// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/commands.h"
#include "cli/names.h"
#include "cli/render_parts.h"
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
  const Image first = read_data_window(options.parts.front(), false);
  const bool is_ours = first.provenance.renderer == "plumbline";
  const Image whole = is_ours ? merge_parts(options.parts, options.is_last) : merge_seeds(options);
  write_image(whole, options.output);
  const Provenance& made = whole.provenance;
  fmt::print("{}: {} spp from {} parts{}{}\nwrote {}\n", made.scene.value_or(""),
             made.samples_per_pixel(), options.parts.size(),
             made.crop ? fmt::format(", pixels {} of {}x{}", *made.crop, whole.display.width,
                                     whole.display.height)
                       : "",
             made.relative_error
                 ? fmt::format(", relative error {:.2f} %", 100.0 * *made.relative_error)
                 : "",
             options.output);
}

}  // namespace

void add_merge(CLI::App& app, int&) {
  auto options = std::make_shared<Options>();
  CLI::App& command =
      *app.add_subcommand("merge", "Put together what was drawn by pixels, samples or seeds");
  add_option(command, "PART", "", options->parts, "The parts' .exr files, in any order")
      ->required();
  add_option(command, "-o,--output", "FILE", options->output,
             "Where to write the whole: .exr or .png")
      ->required();
  command.add_flag("--last", options->is_last,
                   "Nothing will be added any more: leave out the sums that\n"
                   "merging takes, as 'render --spp' does, and refuse parts\n"
                   "of several crops that don't make up the picture");
  command.footer(R"(Example:
  plumb render scene.xml --samples 0:64 -o a.exr
  plumb render scene.xml --samples 64:128 -o b.exr
  plumb merge a.exr b.exr --last -o whole.exr
  plumb render scene.xml --size 512x512 --crop 0,0,512,256 -o top.exr
  plumb render scene.xml --size 512x512 --crop 0,256,512,256 -o bottom.exr
  plumb merge top.exr bottom.exr --last -o whole.exr

The whole has the bits that rendering it at once would have given, and can be
merged in turn. Parts of the same pixels have to be drawn with --samples;
several crops have to make up a rectangle, with the same samples. Parts that
overlap, leave a gap or differ in scene, size, seed or method are refused.

Pictures that 'reference --seeds 1' has another program draw give what more
seeds at once would have, if named in the seeds' order.
Exit codes: 0 done, 2 trouble.)");
  command.callback([options] { run(*options); });
}

}  // namespace plumb::cli
