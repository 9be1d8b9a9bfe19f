// A way of rendering is tried on a scene for a while and held against the truth.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "compare/picture.h"
#include "reference_scenes/reference.h"
#include "renderer/render.h"

namespace plumb::cli {

// How single samples scatter around their pixels' means, over all pixels.
struct Tail {
  double fireflies = 0.0;  // the worst thousandth's share of the variance
  double kurtosis = 0.0;   // 3 for a normal distribution; 0 if nothing scatters
  int64_t unfit = 0;       // values that are not finite or negative
  double brightest = 0.0;
};

struct Trial {
  Picture picture;         // with its noise, unless the program has none
  std::string program;     // with its version; empty for our own
  double seconds = 0.0;    // of rendering alone
  double samples = 0.0;    // of all pixels; 0 if the program has none
  double brightest = 0.0;  // what a sample may show, though none has
  std::optional<Tail> tail;
};

// Both return nothing after a stop. Other programs take as many samples as fit into the time, by a
// first small picture; POV-Ray draws its draft. Throws as render_reference() does.
std::optional<Trial> try_method(const Scene& scene, const Settings& settings, const Limits& limits,
                                const std::atomic<bool>& stop);
std::optional<Trial> try_program(const Scene& scene, const std::filesystem::path& file,
                                 Program program, double seconds, const Watcher& watcher);

enum class Outcome { holds, noisy, biased, breaks };

// docs/stability.md says what these mean.
struct Assessment {
  Outcome outcome = Outcome::breaks;
  double bias = 0.0, error = 0.0;  // of the picture's mean, and its standard error, as parts of it
  double square = 0.0;             // relative mean square error of pixels
  double seconds_to_one_percent = 0.0;  // for a picture of 256 x 256 pixels
};

// `false_alarm` is the chance that noise alone makes this trial biased.
Assessment assess(Trial trial, Picture truth, double false_alarm);

}  // namespace plumb::cli
