// SPDX-License-Identifier: Apache-2.0

// Classic bugs, planted on purpose: what a comparison must be able to see. docs/faults.md tells
// where each is met in the wild.
#pragma once

#include <string>
#include <vector>

#include "renderer/settings.h"
#include "scene/scene.h"

namespace plumb {

enum class Fault : int {
  none,
  emitter_cosine,
  inverse_pi,
  uniform_directions,
  five_bounces,
  roulette_weight,
  clamp_indirect,
  two_sided_lamp,
  half_lamp_area,
  one_sided_mis,
  gamma_reflectance,
  half_pixel,
  tangent_frame,
  webgl_random,
  webgl_demo,
  n_squared,
  fresnel_ignored,
  glass_inside_out,
  schlick,
  total_reflection_black
};

struct FaultDescription {
  std::string name;
  Fault fault;
  std::string text;
  bool is_of_glass = false;  // changes nothing in scenes without it
};

// All but `none`.
const std::vector<FaultDescription>& faults();

// Changes scene and settings so that render() shows the fault. Faults that are not just another
// scene or setting are for render() in float alone, which throws std::invalid_argument else.
void plant(Fault fault, Scene& scene, Settings& settings);

}  // namespace plumb
