// What a study shows: how error falls with samples, and what speed costs in accuracy. Each as a
// plot with its table and sentences.
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

// relMSE against samples per pixel, with the power law of each series and channel.
Exhibit convergence(const Study& study);

// Relative error, the root of relMSE, against seconds of rendering, with the Pareto front: those
// points than which none is both faster and more accurate. Variance x time is that of a series'
// last point, and the best one is the best without a bias. The times to 1 % and to 0.1 % follow
// from the power law and are marked with ~ where no render took as long.
Exhibit speed_and_accuracy(const Study& study);

std::string to_text(const Exhibit& exhibit);
nlohmann::ordered_json to_json(const Exhibit& exhibit);

}  // namespace plumb
