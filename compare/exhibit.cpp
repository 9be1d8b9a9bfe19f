// SPDX-License-Identifier: Apache-2.0

#include "compare/exhibit.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <limits>
#include <optional>

namespace plumb {
namespace {

using Json = nlohmann::ordered_json;

constexpr double infinity = std::numeric_limits<double>::infinity();

std::string seconds_text(double seconds) {
  if (seconds >= 3600.0) return fmt::format("{:.3g} h", seconds / 3600.0);
  return fmt::format("{:.3g} s", seconds);
}

// With its larger half of the interval.
std::string exponent_text(const Interval& p) {
  return fmt::format("{:.3f} +- {:.3f}", p.value, std::max(p.high - p.value, p.value - p.low));
}

std::string bias_text(const Convergence& fall) {
  const Interval& bias = fall.bias;
  if (!fall.stops) return "none above " + percent(std::max(bias.high, 0.0));
  return fmt::format("{:.3g} % +- {:.2g}", 100.0 * bias.value,
                     100.0 * std::max(bias.high - bias.value, bias.value - bias.low));
}

std::string sentence(const std::string& name, const Convergence& fall) {
  return fmt::format("{}: noise falls as N^-{}{}{}.", name, exponent_text(fall.law.exponent),
                     fall.stops ? " and stops at a bias of " : ", no bias seen above ",
                     fall.stops ? bias_text(fall) : percent(std::max(fall.bias.high, 0.0)));
}

Json to_json(const Interval& i) { return {i.value, i.low, i.high}; }

Json points_json(const Study& study, const Series& series) {
  Json points = Json::array();
  for (const Point& p : series.points) {
    Json json = {{"step", p.label.step},
                 {"samples", p.label.samples},
                 {"seconds", p.label.seconds},
                 {"startupSeconds", p.label.startup_seconds},
                 {"runs", p.runs}};
    for (size_t c = 0; c < study.channels().size(); ++c) {
      json["relMse"][study.channels()[c]] = {p.errors[c], p.deviations[c]};
    }
    points.push_back(json);
  }
  return points;
}

std::vector<std::string> first_sentences(const Study& study) {
  const double noise = study.reference_noise().back();
  std::vector<std::string> sentences = study.left_out();
  sentences.insert(
      sentences.begin(),
      noise == 0.0
          ? "The reference's noise is not known: it counts as bias."
          : fmt::format("The reference's own noise, a relMSE of {:.2g} ({}), is subtracted.", noise,
                        percent(std::sqrt(noise))));
  return sentences;
}

// Where the reference is the noisier one.
void add_noise_sentence(const Study& study, const Series& series, Exhibit& exhibit) {
  const double noise = study.reference_noise().back();
  const auto found =
      std::ranges::find_if(series.points, [&](const Point& p) { return p.errors.back() < noise; });
  if (found == series.points.end()) return;
  exhibit.sentences.push_back(fmt::format(
      "{}: from {} on the reference is noisier than the picture.", series.name, found->label.step));
}

std::optional<Convergence> fit(const Study& study, const Series& series, size_t channel,
                               std::string& problem) {
  try {
    return study.convergence(series, channel);
  } catch (const std::exception& error) {
    problem = error.what();
    return {};
  }
}

// An error's bar of two standard errors.
PlotPoint error_point(double x, const Point& p, double power, double unit) {
  const double error = p.errors.back();
  const double bar = 2.0 * p.deviations.back();
  const auto at = [&](double value) { return unit * std::pow(std::max(value, 0.0), power); };
  return {x, at(error), at(error - bar), at(error + bar)};
}

void add_rows(const Study& study, const Series& series, Exhibit& exhibit) {
  Json data = {{"series", series.name}, {"points", points_json(study, series)}};
  Curve curve{series.name, {}, {}};
  for (const Point& p : series.points) {
    curve.points.push_back(error_point(p.label.samples, p, 1.0, 1.0));
  }
  for (size_t c = 0; c < study.channels().size(); ++c) {
    const bool is_last = c + 1 == study.channels().size();
    std::string problem;
    const auto fall = fit(study, series, c, problem);
    if (!fall) {
      if (is_last) exhibit.sentences.push_back(fmt::format("{}: {}.", series.name, problem));
      continue;
    }
    exhibit.rows.push_back({series.name, study.channels()[c], exponent_text(fall->law.exponent),
                            fmt::format("{:.2e} ({:.2e} to {:.2e})", fall->floor.value,
                                        fall->floor.low, fall->floor.high),
                            fmt::format("{:.2e}", study.reference_noise()[c]), bias_text(*fall),
                            fmt::format("{:.3g}", fall->law.scale)});
    data["fits"].push_back({{"channel", study.channels()[c]},
                            {"scale", fall->law.scale},
                            {"exponent", to_json(fall->law.exponent)},
                            {"floor", to_json(fall->floor)},
                            {"referenceNoise", study.reference_noise()[c]},
                            {"bias", to_json(fall->bias)},
                            {"stops", fall->stops}});
    if (!is_last) continue;
    exhibit.sentences.push_back(sentence(series.name, *fall));
    const double floor = fall->stops ? std::pow(fall->bias.value, 2.0) : 0.0;
    for (const Point& p : series.points) {
      curve.fit.push_back({p.label.samples, fall->law.noise(p.label.samples) + floor, 0, 0});
    }
  }
  add_noise_sentence(study, series, exhibit);
  exhibit.plot.curves.push_back(curve);
  exhibit.data.push_back(data);
}

struct Efficiency {
  double variance_time = infinity;
  bool is_biased = false;
  std::array<std::string, 2> to_error;  // to 1 % and 0.1 %
  std::array<double, 2> seconds{infinity, infinity};
};

constexpr std::array<double, 2> goals{0.01, 0.001};

// By the law of a series whose samples take equally long.
void predict(const Convergence& fall, const Point& last, Efficiency& efficiency) {
  const double per_sample = last.label.seconds / last.label.samples;
  efficiency.variance_time = fall.law.noise(last.label.samples) * last.label.seconds;
  efficiency.is_biased = fall.stops;
  const double floor = fall.stops ? std::pow(fall.bias.value, 2.0) : 0.0;
  for (size_t i = 0; i < goals.size(); ++i) {
    const double noise = goals[i] * goals[i] - floor;
    efficiency.to_error[i] = "never";
    if (noise <= 0.0) continue;
    const double samples =
        std::max(1.0, std::pow(fall.law.scale / noise, 1.0 / fall.law.exponent.value));
    efficiency.seconds[i] = samples * per_sample;
    const bool is_measured = samples <= last.label.samples;
    efficiency.to_error[i] = (is_measured ? "" : "~") + seconds_text(efficiency.seconds[i]);
  }
}

Efficiency efficiency_of(const Study& study, const Series& series, Exhibit& exhibit) {
  Efficiency efficiency;
  std::string problem;
  const auto fall = fit(study, series, study.channels().size() - 1, problem);
  if (fall) {
    predict(*fall, series.points.back(), efficiency);
    return efficiency;
  }
  for (size_t i = 0; i < goals.size(); ++i) {
    efficiency.to_error[i] = "not reached";
    for (const Point& p : series.points) {
      if (p.errors.back() > goals[i] * goals[i] || p.label.seconds >= efficiency.seconds[i])
        continue;
      efficiency.seconds[i] = p.label.seconds;
      efficiency.to_error[i] = "at most " + seconds_text(p.label.seconds);
    }
  }
  const bool has_samples = series.points.front().label.samples > 0.0;
  if (has_samples) exhibit.sentences.push_back(fmt::format("{}: {}.", series.name, problem));
  return efficiency;
}

std::vector<PlotPoint> pareto_front(const std::vector<Curve>& curves) {
  std::vector<PlotPoint> all;
  for (const Curve& curve : curves) {
    all.insert(all.end(), curve.points.begin(), curve.points.end());
  }
  std::erase_if(all, [](const PlotPoint& p) { return p.y <= 0.0; });
  std::ranges::sort(all, {}, [](const PlotPoint& p) { return std::pair(p.x, p.y); });
  std::vector<PlotPoint> front;
  for (const PlotPoint& p : all) {
    if (front.empty() || p.y < front.back().y) front.push_back(p);
  }
  return front;
}

std::string ratio(double value, double best) {
  if (!std::isfinite(value) || !std::isfinite(best)) return "";
  return fmt::format("{:.3g}", value / best);
}

}  // namespace

Exhibit convergence(const Study& study) {
  std::vector<Series> all = study.series();
  Exhibit exhibit{{"Error against samples", "samples per pixel", "relMSE", {}, {}},
                  {"series", "channel", "noise falls as N^-p, p =", "floor",
                   "of it the reference's noise", "bias", "relMSE of one sample"},
                  {},
                  first_sentences(study),
                  Json::array()};
  for (Series& series : all) {
    std::erase_if(series.points, [](const Point& p) { return p.label.samples == 0.0; });
    if (series.points.empty()) {
      exhibit.sentences.push_back(series.name + ": the number of samples is not known.");
      continue;
    }
    add_rows(study, series, exhibit);
  }
  return exhibit;
}

Exhibit speed_and_accuracy(const Study& study) {
  std::vector<Series> all = study.series();
  Exhibit exhibit{{"Accuracy against speed", "seconds of rendering", "relative error, %", {}, {}},
                  {"series", "start-up", "variance x time", "to the best", "to 1 %", "to the best",
                   "to 0.1 %", "to the best"},
                  {},
                  first_sentences(study),
                  Json::array()};
  std::vector<std::pair<Series, Efficiency>> efficiencies;
  Efficiency best;
  for (Series& series : all) {
    std::erase_if(series.points, [](const Point& p) { return p.label.seconds <= 0.0; });
    if (series.points.empty()) {
      exhibit.sentences.push_back(series.name + ": the seconds of rendering are not known.");
      continue;
    }
    const Efficiency efficiency = efficiency_of(study, series, exhibit);
    if (!efficiency.is_biased)
      best.variance_time = std::min(best.variance_time, efficiency.variance_time);
    for (size_t i = 0; i < goals.size(); ++i) {
      best.seconds[i] = std::min(best.seconds[i], efficiency.seconds[i]);
    }
    Curve curve{series.name, {}, {}};
    for (const Point& p : series.points) {
      curve.points.push_back(error_point(p.label.seconds, p, 0.5, 100.0));
    }
    exhibit.plot.curves.push_back(curve);
    exhibit.data.push_back({{"series", series.name}, {"points", points_json(study, series)}});
    efficiencies.emplace_back(std::move(series), efficiency);
  }
  exhibit.plot.front = pareto_front(exhibit.plot.curves);
  for (const auto& [series, efficiency] : efficiencies) {
    const double startup = series.points.back().label.startup_seconds;
    exhibit.rows.push_back({series.name, startup > 0.0 ? seconds_text(startup) : "",
                            std::isfinite(efficiency.variance_time)
                                ? fmt::format("{:.2e} s", efficiency.variance_time)
                                : "",
                            ratio(efficiency.variance_time, best.variance_time),
                            efficiency.to_error[0], ratio(efficiency.seconds[0], best.seconds[0]),
                            efficiency.to_error[1], ratio(efficiency.seconds[1], best.seconds[1])});
  }
  return exhibit;
}

std::string to_text(const Exhibit& exhibit) {
  std::string text = table(exhibit.head, exhibit.rows) + "\n";
  for (const std::string& line : exhibit.sentences) text += line + "\n";
  return text;
}

Json to_json(const Exhibit& exhibit) {
  return {{"plumbline", PLUMB_VERSION},
          {"head", exhibit.head},
          {"rows", exhibit.rows},
          {"sentences", exhibit.sentences},
          {"series", exhibit.data}};
}

}  // namespace plumb
