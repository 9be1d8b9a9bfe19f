// SPDX-License-Identifier: Apache-2.0

// Renders a scene onto a film, pass after pass, until a limit is reached.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>

#include "renderer/film.h"
#include "renderer/settings.h"
#include "scene/scene.h"

namespace plumb {

// A render ends with whichever comes first. Time and error are looked at between passes. When the
// time is up, a pass in which a path doesn't end is left unfinished.
//
// The number of samples that leads to the relative error is estimated from separate samples, at
// most as many as the picture has up to 64, and an eighth of them later: so the picture stays
// unbiased, and so does the error that it claims, which may exceed the wanted one a little. A
// picture that ends so has 64 samples per pixel or more.
struct Limits {
  SampleRange samples{0, std::numeric_limits<int64_t>::max()};
  double seconds = std::numeric_limits<double>::infinity();
  double relative_error = 0.0;
};

// What a render has cost so far, without preparing the scene.
struct Cost {
  double wall_seconds = 0.0;
  double cpu_seconds = 0.0;
  int64_t samples = 0;  // of all pixels, and also those that estimate how many are wanted
  int64_t rays = 0;     // shadow rays included
  // The bounces of the longest path, where the last pass was left unfinished; else 0.
  int64_t unfinished_path = 0;
};

// A path of so many bounces hardly ever ends: what it meets reflects everything.
constexpr int64_t endless_path = 10000;

// Why the last pass was left unfinished, as a sentence; nothing if it was not.
std::string why_unfinished(const Cost& cost);

struct Progress {
  Cost cost;
  int64_t samples_per_pixel = 0;
  double relative_error = 0.0;  // Film::relative_error()
  double seconds_left = 0.0;    // estimated, to the first limit
};

// Called after each pass, on the calling thread.
using ProgressCallback = std::function<void(const Progress&)>;

// Adds samples to the film, whose window lies within the scene's picture: its pixels get the bits
// that they have in the whole one. Setting `stop` ends the render with the pass under way or, if
// that takes more than half a second, without it. The film always holds whole passes, or nothing.
Cost render(const Scene& scene, const Settings& settings, const Limits& limits, Film& film,
            const ProgressCallback& progress = {}, const std::atomic<bool>* stop = nullptr);

}  // namespace plumb
