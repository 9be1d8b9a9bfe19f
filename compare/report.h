// SPDX-License-Identifier: Apache-2.0

// What a comparison found, as text for people and as JSON for programs.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "compare/comparison.h"

namespace plumb {

// What the report says about the two pictures.
struct ComparedFiles {
  std::string test, reference;   // the names of the files
  std::string notes;             // lines that tell what was assumed about them
  double samples_per_pixel = 0;  // of the test; 0 if not known
  std::vector<std::string> left_out_of_test = {}, left_out_of_reference = {};  // channels
  std::vector<std::string> only_tags_differ =
      {};  // Image::tags, where the stored numbers are equal
};

// The whole report, in Markdown.
std::string to_text(const Comparison& comparison, const ComparedFiles& files);
nlohmann::ordered_json to_json(const Comparison& comparison, const ComparedFiles& files);

// The outcome alone, such as trouble.
nlohmann::ordered_json to_json(Verdict verdict, const std::string& explanation,
                               const ComparedFiles& files);

// A line with the verdict and its reason, and a line that tells which errors would have been found.
std::string explain(const Comparison& comparison, const ComparedFiles& files);

// The clearest difference: of a region, else of the image, a block or a pixel; nothing if there is
// none. And a difference as a part of the reference, with its 95 % interval; if the reference is 0,
// the test with that.
std::string clearest_difference(const Comparison& comparison);
std::string relative_difference(const Estimate& estimate);

}  // namespace plumb
