// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

#include "cli/commands.h"
#include "cli/list_renderers.h"
#include "cli/scene_options.h"
#include "other_renderers/export.h"

namespace plumb::cli {
namespace {

struct Options {
  SceneOptions scene;
  std::string output;
  const OtherRenderer* renderer = nullptr;
};

const OtherRenderer* find(const std::string& word) {
  const OtherRenderer& renderer = other_renderer(word);
  if (!renderer.format) {
    throw std::invalid_argument(renderer.name + " reads scene files as they are");
  }
  return &renderer;
}

std::string word_and_file(const OtherRenderer& renderer) {
  if (!renderer.format) return "";
  return fmt::format("{} ({} for {})", renderer.word, renderer.format->extension,
                     renderer.software);
}

void run(const Options& options) {
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
  add_option(command, "--to", "PROGRAM", options->renderer, find, list_renderers(word_and_file))
      ->required();
  add_option(command, "-o,--output", "FILE", options->output,
             "The file; what it includes is put beside it")
      ->required();
  command.footer(R"(Examples:
  plumb export scene.xml --to povray -o box.pov
  povray box.pov +W512 +H512
  plumb export scene.xml --to cycles -o box.py
  blender -b --python box.py -- -o box.exr --spp 256

'blender -b --python box.py -- --help' lists what the script takes.)");
  command.callback([=] { run(*options); });
}

}  // namespace plumb::cli
