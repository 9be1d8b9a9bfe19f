// SPDX-License-Identifier: Apache-2.0

#include "compare/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <stdexcept>

#include "images/output_file.h"
#include "images/printable.h"

namespace plumb {
namespace {

namespace fs = std::filesystem;

// As gnuplot reads it literally. A line's end would begin a command.
std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : printable(text)) result += c == '\'' ? "''" : std::string(1, c);
  return result + "'";
}

std::string data_block(const std::string& name, const std::vector<PlotPoint>& points) {
  std::string text = fmt::format("${} << EOD\n", name);
  for (const PlotPoint& p : points) {
    if (!(p.x > 0.0 && p.y > 0.0)) continue;
    const double low = std::max(p.low, 1e-3 * p.y);
    text += fmt::format("{:.9g} {:.9g} {:.9g} {:.9g}\n", p.x, p.y, low, p.high);
  }
  return text + "EOD\n";
}

std::string script(const Plot& plot, bool is_svg) {
  const char* const terminal = is_svg ? "svg size 800,760 noenhanced font 'sans,14'"
                                      : "pngcairo size 1200,1140 noenhanced font 'sans,20'";
  std::string text = fmt::format(
      "set terminal {} background rgb 'white'\nset colorsequence podo\nset pointsize 0.7\n"
      "set logscale xy\nset mxtics 10\nset mytics 10\nset format xy '%g'\nset grid linetype 1 "
      "linecolor rgb '#cccccc'\n"
      "set key below height 1 maxcolumns 2 Left reverse\n"
      "set title {}\nset xlabel {}\nset ylabel {}\n",
      terminal, quoted(plot.title), quoted(plot.x_title), quoted(plot.y_title));
  std::string commands;
  if (!plot.front.empty()) {
    text += data_block("front", plot.front);
    commands =
        "$front using 1:2 with steps linewidth 6 linecolor rgb '#c8c8c8' title "
        "'Pareto front'";
  }
  for (size_t i = 0; const Curve& curve : plot.curves) {
    text += data_block(fmt::format("points{}", ++i), curve.points);
    const char* const style = curve.fit.empty() ? "yerrorlines" : "yerrorbars";
    commands += fmt::format(
        "{}$points{} using 1:2:3:4 with {} linewidth 1.5 linecolor {} dashtype {} pointtype {} "
        "title {}",
        commands.empty() ? "" : ", ", i, style, i, i > 8 ? 2 : 1, i + 3, quoted(curve.name));
    if (curve.fit.empty()) continue;
    text += data_block(fmt::format("fit{}", i), curve.fit);
    commands += fmt::format(", $fit{} using 1:2 with lines linecolor {} notitle", i, i);
  }
  return text + "plot " + commands + "\n";
}

// What gnuplot draws for the file. It doesn't tell when a disk is full, so it writes into a pipe.
std::string draw(const std::string& script, const fs::path& file) {
  const std::unique_ptr<FILE, int (*)(FILE*)> commands(std::tmpfile(), std::fclose);
  if (commands == nullptr || std::fwrite(script.data(), script.size(), 1, commands.get()) != 1 ||
      std::fseek(commands.get(), 0, SEEK_SET) != 0) {
    throw std::runtime_error("cannot write a temporary file");
  }
  const std::string command = fmt::format("gnuplot /dev/fd/{}", fileno(commands.get()));
  FILE* const gnuplot = popen(command.c_str(), "r");
  if (gnuplot == nullptr) throw std::runtime_error("can't start gnuplot");
  std::string picture;
  std::array<char, 65536> buffer;
  while (const size_t count = std::fread(buffer.data(), 1, buffer.size(), gnuplot)) {
    picture.append(buffer.data(), count);
  }
  if (pclose(gnuplot) != 0) {
    throw std::runtime_error(file.string() + ": gnuplot is not installed or failed");
  }
  return picture;
}

}  // namespace

void write_plot(const Plot& plot, const fs::path& file) {
  const bool is_svg = file.extension() == ".svg";
  if (!is_svg && file.extension() != ".png") {
    throw std::invalid_argument(file.string() + ": a plot's name ends in .svg or .png");
  }
  const auto is_drawn = [](const Curve& curve) {
    return std::ranges::any_of(curve.points, [](const PlotPoint& p) { return p.y > 0.0; });
  };
  if (std::ranges::none_of(plot.curves, is_drawn)) {
    throw std::runtime_error(file.string() + ": nothing to draw");
  }
  Plot drawn = plot;
  std::erase_if(drawn.curves, [&](const Curve& curve) { return !is_drawn(curve); });
  write_file(file, draw(script(drawn, is_svg), file));
}

}  // namespace plumb
