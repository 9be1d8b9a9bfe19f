// SPDX-License-Identifier: Apache-2.0

// Curves on doubly logarithmic axes, drawn by gnuplot.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace plumb {

struct PlotPoint {
  double x = 0, y = 0, low = 0, high = 0;  // the error bar ranges from low to high
};

struct Curve {
  std::string name;
  std::vector<PlotPoint> points;
  std::vector<PlotPoint> fit;  // drawn as a thin line through x and y
};

struct Plot {
  std::string title, x_title, y_title;
  std::vector<Curve> curves;
  std::vector<PlotPoint> front;  // drawn as steps behind the curves
};

// Draws the plot without the points that are 0 or negative, which logarithmic axes can't show.
// Throws std::invalid_argument if the file is neither .svg nor .png, and std::runtime_error if
// gnuplot is not installed or fails; and FileError as write_file() does.
void write_plot(const Plot& plot, const std::filesystem::path& file);

}  // namespace plumb
