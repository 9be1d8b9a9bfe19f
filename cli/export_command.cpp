// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

#include "cli/commands.h"
#include "cli/list_renderers.h"
#include "cli/names.h"
#include "cli/scene_options.h"
#include "images/output_file.h"
#include "other_renderers/export.h"
#include "other_renderers/plain_scene.h"

namespace plumb::cli {
namespace {

struct Options {
  SceneOptions scene;
  std::string output;
  std::optional<OtherRenderer> renderer;  // none: JSON
};

std::optional<OtherRenderer> find(const std::string& word) {
  std::string words = "json";
  if (word == words) return {};
  for (const OtherRenderer& renderer : other_renderers()) {
    if (renderer.format) words += ", " + renderer.word;
    if (renderer.word != word) continue;
    if (renderer.format) return renderer;
    throw std::invalid_argument(renderer.name + " reads scene files as they are");
  }
  refuse(word, "one of " + words);
}

std::string word_and_file(const OtherRenderer& renderer) {
  if (!renderer.format) return "";
  return fmt::format("{} ({} for {})", renderer.word, renderer.format->extension,
                     renderer.software);
}

void run(const Options& options) {
  if (!options.renderer) {
    write_file(options.output, plain_scene(load_scene(options.scene)));
    fmt::print("wrote {}\n", options.output);
    return;
  }
  const std::filesystem::path include =
      export_scene(*options.renderer, load_scene(options.scene), options.output);
  fmt::print("wrote {}\nwrote {}, which it includes\n", options.output, include.string());
}

}  // namespace

void add_export(CLI::App& app, int&) {
  auto options = std::make_shared<Options>();
  const std::string readers =
      list_renderers([](const OtherRenderer& r) { return r.format ? r.software : ""; });
  CLI::App& command =
      *app.add_subcommand("export", fmt::format("Write a scene as {} reads it", readers));
  add_scene_option(command, options->scene);
  add_option(command, "--to", "FORMAT", options->renderer, find,
             list_renderers(word_and_file) +
                 ",\nor json: plain numbers for any other (docs/plain-scene.md)")
      ->required();
  add_option(command, "-o,--output", "FILE", options->output,
             "The file; what it includes is put beside it")
      ->required();
  command.footer(R"(Examples:
  plumb export scene.xml --to povray -o box.pov
  povray box.pov +W512 +H512
  plumb export scene.xml --to json -o box.json
  plumb export scene.xml --to cycles -o box.py
  blender -b --python box.py -- -o box.exr --spp 256

'blender -b --python box.py -- --help' lists what the script takes.
Exit codes: 0 done, 2 trouble.)");
  command.callback([=] { run(*options); });
}

}  // namespace plumb::cli
