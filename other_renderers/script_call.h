// The options that the scripts of this folder take.
#pragma once

#include <fmt/format.h>

#include <string>

#include "other_renderers/other_renderer.h"

namespace plumb {

// `command` with what the job says; `more` are options of this script alone.
inline std::vector<Run> script_call(Command command, const Job& job, const Command& more = {}) {
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
