// SPDX-License-Identifier: Apache-2.0

// Pictures of matte polygons without noise: light is computed, not sampled, and its error is known
// from two resolutions.
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "radiosity/work.h"
#include "scene/light_origin.h"
#include "scene/scene.h"

namespace plumb::radiosity {

struct Picture {
  std::vector<float> rgb;  // mean radiance of each pixel, rows from the top
  size_t elements = 0, links = 0;
  int level = -1;  // of its resolution; -1: there is no picture

  // How far it is from a coarser picture. Where the error falls to less than half from one to the
  // next, that is a bound on its own. As `plumb render --error` has it, the root of the mean of
  // difference^2 / (mean^2 + 0.01) over pixels and channels; in the mean over the picture; and in
  // the worst of its 8 x 8 blocks, in parts of what is judged there (compare/comparison.h).
  // Infinite for the first picture.
  static constexpr double unknown = std::numeric_limits<double>::infinity();
  double error = unknown, image_floor = unknown, block_floor = unknown;

  std::string why_ended = {};  // before the wanted error was reached; else empty
};

// Finds the errors of a picture by a coarser one.
void estimate_error(Picture& fine, const Picture& coarse, const Camera& camera);

struct Settings {
  BounceRange bounces;
  const LightOrigin* origin = nullptr;  // of all light, if there is none
  double error = 0.0;                   // wanted; 0: whatever it is at `level`
  int level = 2;                        // the resolution to end with, above 0
  size_t most_bytes = 0;
};

// Refines until the picture's error is the wanted one, or until it is stopped or there is no memory
// for more. Throws Refusal (faces.h) for a scene with anything but matte polygons,
// std::runtime_error if light doesn't fade or there is no memory for even the coarsest elements.
Picture draw(const Scene& scene, const Settings& settings, const Work& work);

}  // namespace plumb::radiosity
