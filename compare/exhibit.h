// SPDX-License-Identifier: Apache-2.0

// What a study shows: how the error falls with the samples, and how accuracy trades against speed.
// Each is a plot with its table and sentences.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "compare/markdown.h"
#include "compare/plot.h"
#include "compare/study.h"

namespace plumb {

struct Exhibit {
  Plot plot;
  TableRow head;
  std::vector<TableRow> rows;
  std::vector<std::string> sentences;
  nlohmann::ordered_json data;  // every point, and the fits
};

// Plots relMSE against samples per pixel, and fits a power law to each series and channel.
Exhibit convergence(const Study& study);

// Plots the relative error, which is the root of relMSE, against seconds of rendering, with the
// Pareto front: the points to which no other point is superior in both speed and accuracy. Variance
// x time is that of the last point of a series; the best one is the smallest among the series
// without bias. The times to 1 % and to 0.1 % follow from the power law, with ~ where no render
// took as long.
Exhibit speed_and_accuracy(const Study& study);

std::string to_text(const Exhibit& exhibit);
nlohmann::ordered_json to_json(const Exhibit& exhibit);

}  // namespace plumb
