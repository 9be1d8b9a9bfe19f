// SPDX-License-Identifier: Apache-2.0

#include <CLI/CLI.hpp>
#include <memory>

#include "cli/commands.h"
#include "cli/study_options.h"

namespace plumb::cli {

void add_chart(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<StudyOptions>();
  CLI::App& command =
      *app.add_subcommand("chart", "Hold methods' and programs' accuracy against their speed");
  command.add_option("PICTURES", options->pictures, "Renders of one scene, with their seconds")
      ->required()
      ->type_name("");
  add_study_options(command, *options);
  command.footer(R"(Examples:
  plumb chart *.exr --reference reference.exr -o chart.svg
  plumb chart ours.exr theirs.png=theirs,64,2.5 --reference reference.exr

Pictures by the same program with the same settings are a series, told by what
they say about themselves or by =SERIES,SPP,SECONDS; those with as many samples
are runs, of whose seconds the median counts. Seconds are of rendering alone.
Exit codes: 0 done, 2 trouble (the other pictures still count).)");
  command.callback([=, &exit_code] {
    Study study(read_picture("reference", {options->reference}, ""));
    exit_code = add_pictures(study, *options) ? 0 : 2;
    present(speed_and_accuracy(study), *options);
  });
}

}  // namespace plumb::cli
