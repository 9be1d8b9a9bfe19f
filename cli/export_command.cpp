#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "cli/commands.h"
#include "cli/names.h"
#include "cli/scene_options.h"
#include "reference_scenes/exporters.h"

namespace plumb::cli {
namespace {

using Exporter = decltype(&export_to_povray);

struct Options {
  SceneOptions scene;
  std::string output;
  Exporter exporter = nullptr;
};

void run(const Options& options) {
  const std::filesystem::path include = options.exporter(load_scene(options.scene), options.output);
  fmt::print("wrote {}\nwrote {}, which it includes\n", options.output, include.string());
}

}  // namespace

void add_export(CLI::App& app) {
  static const Words<Exporter> words{{"povray", export_to_povray}, {"cycles", export_to_cycles}};
  auto options = std::make_shared<Options>();
  CLI::App& command = *app.add_subcommand("export", "Write a scene as POV-Ray or Blender reads it");
  add_scene_option(command, options->scene);
  add_option(command, "--to", "PROGRAM", options->exporter, one_of(words),
             "povray (a .pov file) or cycles (a Python script for\nBlender)")
      ->required();
  command.add_option("-o,--output", options->output, "The file; what it includes is put beside it")
      ->required()
      ->type_name("FILE");
  command.footer(R"(Examples:
  plumb export scene.xml --to povray -o box.pov
  povray box.pov +W512 +H512
  plumb export scene.xml --to cycles -o box.py
  blender -b --python box.py -- -o box.exr --spp 256

'blender -b --python box.py -- --help' lists what the script takes.)");
  command.callback([=] { run(*options); });
}

}  // namespace plumb::cli
