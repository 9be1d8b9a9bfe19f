// SPDX-License-Identifier: Apache-2.0

// What 'plumb converge' and 'plumb chart' have in common: pictures in, an exhibit out.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "compare/exhibit.h"
#include "compare/study.h"

namespace plumb::cli {

struct StudyOptions {
  std::vector<std::string> pictures;  // files, or FILE=SERIES,SPP,SECONDS
  std::string reference, plot, json;
  bool other_scene = false;
};

void add_study_options(CLI::App& command, StudyOptions& options);

// Adds a picture. Throws ImageError as Study::add() does, and if the picture is of another scene
// than the reference, which the options don't allow.
void add_picture(Study& study, Picture picture, const Label& label, const StudyOptions& options);

// Adds all pictures. Says which can't be used and why; returns whether all could.
bool add_pictures(Study& study, const StudyOptions& options);

// Prints the exhibit and writes its files.
void present(const Exhibit& exhibit, const StudyOptions& options);

}  // namespace plumb::cli
