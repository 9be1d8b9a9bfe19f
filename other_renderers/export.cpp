// SPDX-License-Identifier: Apache-2.0

#include "other_renderers/export.h"

#include <fmt/format.h>

#include <cctype>
#include <stdexcept>
#include <string>

#include "images/output_file.h"

namespace plumb {

namespace fs = std::filesystem;

fs::path export_scene(const OtherRenderer& renderer, const Scene& scene, const fs::path& file) {
  fs::path script = fs::path(file).replace_filename(renderer.script_name);
  if (script == file) {
    throw std::runtime_error(fmt::format("{}: is the name of its include", file.string()));
  }
  write_file(file, renderer.format->text(scene));
  write_file(script, renderer.script);
  return script;
}

std::string box_filter_note(const std::string& renderer, const Filter& filter) {
  constexpr const char* names[] = {"box", "tent", "gaussian"};  // as in Filter::Kind
  if (filter.kind == Filter::Kind::box && filter.size == 0.5) return "";
  return fmt::format("{} draws a box filter, the scene asks for {} {}", renderer,
                     names[size_t(filter.kind)], filter.size);
}

std::string comment(const std::string& mark, const std::string& note) {
  return note.empty() ? "" : fmt::format("{}{}\n", mark, note);
}

std::string plain_identifier(const std::string& id) {
  std::string plain = id;
  for (char& c : plain) {
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  }
  return plain;
}

std::vector<Run> script_call(Command command, const Job& job, const Command& more) {
  const auto add = [&](const std::string& option, const std::string& value) {
    command.insert(command.end(), {option, value});
  };
  const ReferenceSettings& settings = job.settings;
  add("-o", picture_name);
  add("--spp", std::to_string(settings.samples_per_pixel));
  add("--seed", std::to_string(job.seed));
  add("--size", fmt::format("{}x{}", job.scene.camera.width, job.scene.camera.height));
  command.insert(command.end(), more.begin(), more.end());
  if (job.most_bounces) add("--bounces", std::to_string(*job.most_bounces));
  if (settings.threads > 0) add("--threads", std::to_string(settings.threads));
  for (const std::string& setting : settings.overrides) add("--set", setting);
  return {{command}};
}

}  // namespace plumb
