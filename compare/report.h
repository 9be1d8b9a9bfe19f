// A comparison for people and for programs.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "compare/comparison.h"

namespace plumb {

// Whom the report is about.
struct ComparedFiles {
  std::string test, reference;   // file names
  std::string notes;             // what was assumed, a line each
  double samples_per_pixel = 0;  // of the test; 0 if not known
};

// Markdown.
std::string to_text(const Comparison& comparison, const ComparedFiles& files);
nlohmann::ordered_json to_json(const Comparison& comparison, const ComparedFiles& files);

// The verdict and its reason, and what would have been found; a line each.
std::string explain(const Comparison& comparison, const ComparedFiles& files);

}  // namespace plumb
