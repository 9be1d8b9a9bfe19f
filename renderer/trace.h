// SPDX-License-Identifier: Apache-2.0

// The tracer's inner loop, compiled once for each SIMD instruction set and chosen at run time.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>

#include "renderer/film.h"
#include "renderer/packed_scene.h"
#include "renderer/settings.h"

namespace plumb {

// How many pixels a thread takes at once.
constexpr int64_t pixels_at_once = 64;

// Some samples of every pixel of a scene, as the tracer sees it. Several threads may work on one
// job: they share `next_pixel`. Several processes may, too, each with a film of its own: of
// `shares` of them number k begins at pixel k * pixels_at_once.
template <class TracedScene>
struct TraceJob {
  const TracedScene& scene;
  const Settings& settings;
  SampleRange samples;
  Film& film;
  std::atomic<int64_t>& next_pixel;
  // Asked every few milliseconds, on all threads, with the bounces of the longest path under way:
  // whether to leave the job unfinished.
  const std::function<bool(int64_t)>& is_abandoned;
  int64_t shares = 1;
};

// Takes pixels until none is left and adds their samples to the film. Returns how many rays were
// traced, shadow rays included. The same job gives the same film whatever the number of threads
// and, among instruction sets with fused multiply-add, whatever the width of the vectors.
int64_t trace(const TraceJob<PackedScene<float>>& job);
int64_t trace(const TraceJob<PackedScene<double>>& job);

// The instruction set that trace() uses on this machine.
const char* trace_target();

}  // namespace plumb
