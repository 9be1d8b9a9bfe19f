// SPDX-License-Identifier: Apache-2.0

#include "compare/report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "compare/markdown.h"
#include "images/printable.h"
#include "images/relative_error.h"

namespace plumb {
namespace {

using Json = nlohmann::ordered_json;

std::string short_number(double value) { return fmt::format("{:.4g}", value); }

// With three decimals, or what shows that it is not 0.
std::string decimals(double value) {
  return std::abs(value) < 0.001 && value != 0.0 ? fmt::format("{:.2g}", value)
                                                 : fmt::format("{:.3f}", value);
}

// In per cent of the reference, unless that is next to nothing.
std::string bias(const Estimate& e) {
  const bool is_relative = std::abs(e.difference) < 100.0 * std::abs(e.reference);
  const double unit = is_relative ? std::abs(e.reference) / 100.0 : 1.0;
  std::string text = e.difference < 0.0 ? "" : "+";
  text += decimals(e.difference / unit) + (is_relative ? " %" : "");
  if (e.confidence > 0.0) text += " +- " + decimals(e.confidence / unit);
  return text;
}

std::string place(const Finding& f) {
  if (!f.name.empty()) return f.name;
  return fmt::format("{}x{} at {},{}", f.window.width, f.window.height, f.window.x, f.window.y);
}

TableRow row(const Finding& f) {
  const auto [test, reference] = told_apart(f.estimate.test, f.estimate.reference);
  return {place(f), f.channel, test, reference, bias(f.estimate)};
}

// The errors' names for programs and for people.
struct Field {
  const char* key;
  const char* title;
  double value;
};
std::vector<Field> fields(const Errors& e) {
  const double rest = e.mse - e.bias_squared - e.test_noise - e.reference_noise;
  return {{"mae", "MAE", e.mae},
          {"rmse", "RMSE", std::sqrt(e.mse)},
          {"relMse", "relMSE", e.rel_mse},
          {"smape", "SMAPE", e.smape},
          {"psnr", "PSNR", e.psnr()},
          {"mse", "MSE", e.mse},
          {"biasSquared", "= bias^2", e.bias_squared},
          {"testNoise", "+ test's noise", e.test_noise},
          {"referenceNoise", "+ reference's", e.reference_noise},
          {"rest", "+ rest", rest}};
}

std::string error_tables(const Comparison& comparison) {
  std::array<TableRow, 2> heads{{{"channel", "test", "reference", "bias +- 95 %"},
                                 {"channel", "largest", "at", "test", "reference"}}};
  std::array<std::vector<TableRow>, 2> rows;
  for (size_t c = 0; c < comparison.errors.size(); ++c) {
    const Errors& e = comparison.errors[c];
    const auto [test, reference] = told_apart(e.max_test, e.max_reference);
    rows[0].push_back(row(comparison.image[c]));
    rows[0].back().erase(rows[0].back().begin());
    rows[1].push_back({comparison.channels[c], short_number(e.max), fmt::format("{},{}", e.x, e.y),
                       test, reference});
    for (size_t i = 0; const Field& field : fields(e)) {
      const size_t half = i++ / 5;
      if (c == 0) heads[half].emplace_back(field.title);
      rows[half].back().push_back(short_number(field.value));
    }
  }
  return table(heads[0], rows[0]) + table(heads[1], rows[1]) +
         fmt::format(
             "\nWith x the test and r the reference: relMSE = mean (x-r)^2 / (r^2 + {0}),\n"
             "SMAPE = mean 2 |x-r| / (|x| + |r| + {0}), PSNR = 10 lg (peak^2 / MSE), peak = max(1, "
             "r).\n",
             relative_epsilon);
}

const char* to_string(FlipKind kind) { return kind == FlipKind::hdr ? "HDR" : "LDR"; }

// What gates only where that is asked for.
std::string remarks(const Comparison& comparison) {
  std::string text;
  if (comparison.fireflies > 0) {
    text += fmt::format("\n{} {}, without which the bias of all is {}\n", comparison.fireflies,
                        comparison.fireflies == 1 ? "firefly" : "fireflies",
                        bias(comparison.without_fireflies));
  }
  if (const auto& flip = comparison.flip) {
    text += fmt::format(
        "\nFLIP {:.4f}, 95th percentile {:.4f} ({}, {:.0f} pixels per degree, exposed by {:.2f} to "
        "{:.2f} stops)\n",
        flip->mean, flip->p95, to_string(flip->kind), flip->pixels_per_degree, flip->first_exposure,
        flip->last_exposure);
  }
  return text;
}

std::string finding_tables(const Comparison& comparison) {
  std::vector<TableRow> regions;
  for (const Finding& f : comparison.regions) {
    regions.push_back(row(f));
    regions.back().emplace_back(to_string(f.estimate.verdict));
  }
  std::string text =
      table({"region", "channel", "test", "reference", "bias +- 95 %", "verdict"}, regions);
  for (const Level& level : comparison.levels) {
    if (level.different == 0 || level.unit == Unit::image) continue;
    std::vector<TableRow> rows;
    for (const Finding& f : level.worst) rows.push_back(row(f));
    text += fmt::format("\n{} of {} {}s differ, most clearly:\n", level.different, level.units,
                        to_string(level.unit)) +
            table({to_string(level.unit), "channel", "test", "reference", "bias +- 95 %"}, rows);
  }
  return text;
}

// JSON has no infinite numbers; programs read this word as one.
Json number(double value) {
  return std::isinf(value) ? Json(value > 0.0 ? "Infinity" : "-Infinity") : Json(value);
}

// Relative numbers are null where the reference is 0.
Json to_json(const Estimate& e) {
  const double whole = std::abs(e.reference);
  return {{"test", e.test},
          {"reference", e.reference},
          {"difference", e.difference},
          {"relativeDifference", e.difference / whole},
          {"standardError", e.standard_error},
          {"confidence95", e.confidence},
          {"relativeConfidence95", e.confidence / whole},
          {"margin", e.margin},
          {"visible", number(e.visible)},
          {"verdict", to_string(e.verdict)}};
}

Json to_json(const Window& w) { return {w.x, w.y, w.width, w.height}; }

Json to_json(const std::vector<Finding>& findings) {
  Json list = Json::array();
  for (const Finding& f : findings) {
    Json json = f.name.empty() ? Json{{"window", to_json(f.window)}} : Json{{"region", f.name}};
    json["channel"] = f.channel;
    json.update(to_json(f.estimate));
    list.push_back(json);
  }
  return list;
}

Json to_json(const Errors& e) {
  Json json = {{"peak", e.peak},
               {"max",
                {{"difference", e.max},
                 {"x", e.x},
                 {"y", e.y},
                 {"test", e.max_test},
                 {"reference", e.max_reference}}}};
  for (const Field& field : fields(e)) json[field.key] = number(field.value);
  return json;
}

// "53 pixels (0.08 %), most clearly at 141,31"; nothing if none differs.
std::string outliers(const Comparison& comparison) {
  for (const Level& level : comparison.levels) {
    if (level.unit != Unit::pixel || level.different == 0) continue;
    const Window& w = level.worst.front().window;
    const std::string beyond = level.beyond_limit == 0
                                   ? ""
                                   : fmt::format(", {} beyond the hard limit", level.beyond_limit);
    return fmt::format("{} pixel{} ({}), most clearly at {},{}{}", level.different,
                       level.different == 1 ? "" : "s",
                       percent(double(level.different), double(level.units)), w.x, w.y, beyond);
  }
  return "";
}

// As a part of the mean: what any number of samples leaves of the difference, and the floor.
double least_tolerance(const Comparison& comparison) {
  double least = 0.0;
  for (size_t c = 0; c < comparison.image.size(); ++c) {
    const Estimate& e = comparison.image[c].estimate;
    if (e.reference == 0.0) continue;
    least =
        std::max(least, (std::abs(e.difference) + comparison.floors[c]) / std::abs(e.reference));
  }
  return least;
}

// What differs most.
std::string clearest(const Comparison& comparison) {
  const auto clearness = [](const Level& level) {
    return !level.differs ? 0.0 : level.worst.front().estimate.excess;
  };
  const Level& level = *std::ranges::max_element(comparison.levels, {}, clearness);
  const Finding& f = level.worst.front();
  const auto [test, reference] = told_apart(f.estimate.test, f.estimate.reference);
  return fmt::format("{} {} has {} in {} ({}, not {})", to_string(level.unit), place(f),
                     bias(f.estimate), f.channel, test, reference);
}

std::string reason(const Comparison& comparison, double samples_per_pixel) {
  const Estimate& whole = comparison.image.back().estimate;
  const double tolerance = comparison.tolerances.back();
  const std::string tolerated =
      fmt::format("{} ({:.3g})", percent(tolerance, whole.reference), tolerance);
  const std::string within =
      tolerance == 0.0 ? "the means are equal" : "the means differ by less than " + tolerated;
  const std::string but = outliers(comparison);
  if (comparison.is_same_but_for_pixels) {
    return fmt::format("{}, but not {}; --max-outliers lets them pass", within, but);
  }
  if (comparison.looks_different) {
    return fmt::format("looks different: FLIP has the mean {:.4g} and the 95th percentile {:.4g}",
                       comparison.flip->mean, comparison.flip->p95);
  }
  if (comparison.verdict == Verdict::different) return clearest(comparison);
  if (comparison.is_doubtful) {
    return fmt::format("{}, but of fewer than {} samples per pixel all may have missed some light",
                       clearest(comparison), enough_samples);
  }
  if (comparison.errors.back().max == 0.0) {
    // As two programs draw it that miss all light.
    return whole.reference == 0.0 ? "all pixels are equal, and their mean is 0"
                                  : "all pixels are equal";
  }
  if (comparison.verdict == Verdict::same) {
    return within + (but.empty() ? "" : ", but for " + but);
  }
  const double factor = comparison.samples_factor;
  if (!std::isfinite(factor)) {
    return fmt::format(
        "with a floor of {} nothing tells whether the means differ by less than {}; a "
        "tolerance above {} % could be met",
        percent(comparison.floors.back(), whole.reference), tolerated,
        told_apart(100.0 * least_tolerance(comparison),
                   100.0 * tolerance / std::abs(whole.reference))[0]);
  }
  std::string text = "noise hides whether the means differ by less than " + tolerated;
  text += fmt::format("; {} times the samples", rounded(std::max(factor, 1.1), 2));  // not 1 times
  if (samples_per_pixel > 0.0) {
    text += fmt::format(" ({:.0f} spp)", std::ceil(factor * samples_per_pixel));
  }
  return text + " would tell";
}

// How large an error must be to be found.
std::string visible(double part) {
  if (std::isinf(part)) return "nothing";
  return part > 1.0 ? "more than all" : percent(part);
}

}  // namespace

Json to_json(Verdict verdict, const std::string& explanation, const ComparedFiles& files) {
  return {{"plumbline", PLUMB_VERSION},
          {"test", files.test},
          {"reference", files.reference},
          {"verdict", to_string(verdict)},
          {"explanation", explanation}};
}

std::string explain(const Comparison& comparison, const ComparedFiles& files) {
  std::string text = to_string(comparison.verdict);
  if (!files.only_tags_differ.empty()) {
    text += fmt::format(": the stored numbers are equal, only tags differ ({})",
                        fmt::join(files.only_tags_differ, ", "));
  }
  text += fmt::format(": {}\n", reason(comparison, files.samples_per_pixel));
  if (comparison.is_paired) {
    text += "Paired: both took the same samples, so that the noise is that of their differences.\n";
  }
  if (!comparison.knows_noise) {
    return text + "Without the noise of both pictures this was a plain check of every pixel.\n";
  }
  std::string levels;
  for (const Level& level : comparison.levels) {
    levels += fmt::format("{}{} of {} {}", levels.empty() ? "" : ", ", visible(level.visible),
                          level.unit == Unit::image ? "the" : "a typical", to_string(level.unit));
  }
  return text + "Would have been found: " + levels + ".\n";
}

std::string to_text(const Comparison& comparison, const ComparedFiles& files) {
  return fmt::format("{} against {}, {}\n{}", files.test, files.reference,
                     place(Finding{"", comparison.window, "", {}}), files.notes) +
         error_tables(comparison) + finding_tables(comparison) + remarks(comparison) + "\n" +
         explain(comparison, files);
}

Json to_json(const Comparison& comparison, const ComparedFiles& files) {
  Json json = to_json(comparison.verdict, explain(comparison, files), files);
  json["knowsNoise"] = comparison.knows_noise;
  json["paired"] = comparison.is_paired;
  json["samplesFactor"] = number(comparison.samples_factor);
  json["window"] = to_json(comparison.window);
  json["fireflies"] = {{"pixels", comparison.fireflies},
                       {"without", to_json(comparison.without_fireflies)}};
  if (const auto& flip = comparison.flip) {
    json["flip"] = {{"mean", flip->mean},
                    {"kind", to_string(flip->kind)},
                    {"p95", flip->p95},
                    {"pixelsPerDegree", flip->pixels_per_degree},
                    {"exposures", {flip->first_exposure, flip->last_exposure}}};
  }
  for (size_t c = 0; c < comparison.errors.size(); ++c) {
    Json channel = {{"channel", comparison.channels[c]},
                    {"tolerance", comparison.tolerances[c]},
                    {"floor", comparison.floors[c]}};
    channel.update(to_json(comparison.image[c].estimate));
    channel.update(to_json(comparison.errors[c]));
    json["channels"].push_back(channel);
  }
  json["notes"] = Json::array();
  std::istringstream notes(files.notes);
  for (std::string line; std::getline(notes, line);) json["notes"].push_back(line);
  json["leftOut"] = {{"test", files.left_out_of_test}, {"reference", files.left_out_of_reference}};
  if (!files.only_tags_differ.empty()) json["onlyTagsDiffer"] = files.only_tags_differ;
  if (!comparison.regions.empty()) json["regions"] = to_json(comparison.regions);
  for (const Level& level : comparison.levels) {
    json["levels"].push_back({{"level", to_string(level.unit)},
                              {"units", level.units},
                              {"different", level.different},
                              {"beyondLimit", level.beyond_limit},
                              {"relativeVisible", number(level.visible)},
                              {"worst", to_json(level.worst)}});
  }
  return json;
}

std::string relative_difference(const Estimate& e) {
  if (e.reference == 0.0) return rounded(e.test, 3) + " ± " + rounded(e.confidence, 2) + ", not 0";
  const double unit = std::abs(e.reference) / 100.0;
  return percent_with_error(e.difference / unit, e.confidence / unit, 3);
}

std::string clearest_difference(const Comparison& comparison) {
  for (const Unit unit : {Unit::region, Unit::image, Unit::block, Unit::pixel}) {
    const auto level = std::ranges::find(comparison.levels, unit, &Level::unit);
    if (level == comparison.levels.end() || level->worst.empty()) continue;
    const Finding& f = level->worst.front();
    const std::string place =
        f.name.empty() ? fmt::format("{} at {},{}", to_string(unit), f.window.x, f.window.y)
                       : f.name;
    return fmt::format("{}, {}: {}", place, f.channel, relative_difference(f.estimate));
  }
  return "";
}

}  // namespace plumb
