// SPDX-License-Identifier: Apache-2.0

// What a caller chooses about a render, apart from the scene.
#pragma once

#include <cstdint>

#include "scene/scene.h"

namespace plumb {

// How a path finds the lamps: by chance, when it samples the BSDF; by sampling them (next event
// estimation); or by both, weighted by the balance heuristic (multiple importance sampling, Veach
// 1997, ch. 9). `plain` is both, too, by
// the plain path tracer, which draws independent numbers in double precision only.
enum class Method { bsdf, nee, mis, plain };

// Where random numbers come from: independent ones, or an Owen-scrambled Sobol' sequence with a
// scramble of its own for each pixel and replicate.
enum class Sampler { independent, sobol };

enum class Precision { float32, float64 };

// The samplers count a replicate's samples in 32 bits.
constexpr int64_t largest_sample = int64_t{1} << 32;

// Samples first <= s < last.
struct SampleRange {
  int64_t first = 0;
  int64_t last = 0;

  int64_t count() const { return last - first; }
};

template <typename T>
struct PackedScene;
template <class TracedScene>
struct TraceJob;

// What takes the place of trace(): none is for a precision that it does not have.
struct Tracer {
  int64_t (*in_float)(const TraceJob<PackedScene<float>>&) = nullptr;
  int64_t (*in_double)(const TraceJob<PackedScene<double>>&) = nullptr;
};
enum class Fault : int;  // faults/faults.h
struct LightOrigin;      // scene/light_origin.h

struct Settings {
  Method method = Method::mis;
  Sampler sampler = Sampler::sobol;
  Precision precision = Precision::float32;
  uint32_t seed = 0;
  BounceRange bounces;
  int threads = 0;                      // 0: all that the machine has
  const Tracer* tracer = nullptr;       // instead of the usual one, with what it reads:
  Fault fault{};                        // set by plant()
  const LightOrigin* origin = nullptr;  // set by select_light()
};

}  // namespace plumb
