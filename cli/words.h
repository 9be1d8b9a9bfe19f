// SPDX-License-Identifier: Apache-2.0

// What commands are asked for, as a list of words of the command line: so a gate's file and scripts
// have its options, its limits and its refusals.
#pragma once

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

#include "cli/radiosity_drawing.h"
#include "cli/rendering.h"
#include "compare/exhibit.h"
#include "compare/judging.h"
#include "compare/maps.h"
#include "other_renderers/runner.h"

namespace plumb::cli {

// The options that `add` adds, as the words set them. Throws CLI::ParseError.
template <typename Options>
Options parse_words(void (*add)(CLI::App&, Options&), const std::vector<std::string>& words) {
  Options options;
  CLI::App command;
  add(command, options);
  // CLI11 wants them backwards.
  command.parse(std::vector<std::string>(words.rbegin(), words.rend()));
  return options;
}

ComparisonTerms parse_terms(const std::vector<std::string>& words);         // of 'plumb compare'
RenderOptions parse_render_options(const std::vector<std::string>& words);  // of 'plumb render'
RadiosityOptions parse_radiosity_options(const std::vector<std::string>& words);
MapKind parse_map(const std::string& word);

// What 'plumb converge' shows; after a stop, of what is finished. Throws as it does.
Exhibit converge(const std::vector<std::string>& words, const Watcher& watcher);

}  // namespace plumb::cli
