// SPDX-License-Identifier: Apache-2.0

// A comparison from two pictures to its report, for whoever asks: a command line or a script.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "compare/comparison.h"
#include "compare/picture.h"
#include "compare/report.h"

namespace plumb {

// What of two pictures is compared, and how.
struct ComparisonTerms {
  Selection selection;
  bool other_scene = false;  // whether they may be of different scenes
  std::optional<Window> crop;
  Judgement judgement;
  std::optional<FlipKind> flip;
  double pixels_per_degree = usual_pixels_per_degree;
};

struct Judged {
  Window window;
  Comparison comparison;
  ComparedFiles files;

  std::string explanation() const;  // with what was assumed, a line each
};

// Leaves out overscan, after which both have one size if they can be compared at all. Throws
// ImageError if they tell of different scenes and the terms don't allow that.
void bring_together(Picture& test, Picture& reference, const ComparisonTerms& terms);

// Compares two pictures that have been brought together, what the regions hold of them; leaves them
// as draw_map() takes them. `reference_file` is where the reference was read: the card beside it
// may tell how wrong it is. Throws ImageError for pictures that can't be compared,
// std::invalid_argument for terms that contradict each other or the pictures.
Judged judge(Picture& test, Picture& reference, const Regions& regions,
             const ComparisonTerms& terms,
             const std::optional<std::filesystem::path>& reference_file);

}  // namespace plumb
