// The path tracer once more, written to be read: one path at a time, in double precision. It has
// the estimator of simd/path-inl.h but shares no code with it beside the scene model, so that each
// of the two checks the other one. It is many times slower.
#pragma once

#include <vector>

#include "renderer/surfaces.h"
#include "renderer/trace.h"

namespace plumb {

// What the plain path tracer knows of a scene, which has to outlive it.
struct PlainScene {
  explicit PlainScene(const Scene& scene);

  const Camera& camera;
  std::vector<Surface> surfaces;
  std::vector<double> choice;  // for each surface, the chance of being the lamp: its share of power
  double margin;  // closer to its ends than this, a ray meets nothing: far above double's rounding
};

// As the other trace(). The settings' method, sampler and precision have no effect.
int64_t trace(const TraceJob<PlainScene>& job);

}  // namespace plumb
