// SPDX-License-Identifier: Apache-2.0

// What makes pictures wrong: classic bugs, and differences of set-up, planted on purpose. One table
// of them is what `--fault`, `plumb power`, `plumb diagnose` and docs/faults.md read.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "renderer/film.h"
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
  inverse_square,
  n_squared,
  fresnel_ignored,
  glass_inside_out,
  schlick,
  total_reflection_black,
  fov_axis,
  gaussian_filter,
  blackman_harris_filter,
  srgb_reflectance,
  lamp_missing,
  lamp_flipped,
  lamp_unseen,
  lamp_area,
  white_mirrors,
  one_sided_walls,
  two_sided_walls,
  other_diagonal,
  near_clipped,
  even_lamp,
  // What is done to pictures, in the order in which it is done.
  smeared_indirect,
  ambient,
  far_clipped,
  flipped,
  mirrored,
  mitchell_filter,
  blurred,
  smeared,
  denoised,
  rec2020_primaries,
  p3_primaries,
  acescg_primaries,
  srgb_decoded,
  gamma_decoded,
  exposure,
  clipped,
  srgb_encoded,
  gamma_encoded
};

// Where a fault comes in: it is another scene, or other settings; another step of the integrator;
// or something that is done to the finished picture.
enum class FaultSite { scene, integrator, picture };

struct FaultDescription {
  std::string name;
  Fault fault;
  FaultSite site;
  std::string text;              // what it is, in a few words
  std::string made, met, shows;  // how it is made, where it is met, and what shows it
  bool is_of_glass = false;      // changes nothing in scenes without it
  bool is_set_up = false;        // no bug

  // Of a fault that has a number: the usual one, and then others that are worth trying. If it is
  // continuous, the best one may lie between two of them.
  std::vector<double> numbers = {};
  bool is_continuous = false;
  bool has_order() const { return is_continuous || fault == Fault::five_bounces; }
};

// All but `none`: first the bugs, then the differences of set-up.
const std::vector<FaultDescription>& faults();

// The row of a fault, which is not `none`.
const FaultDescription& description(Fault fault);

// Changes scene and settings so that render() shows the fault, with a number other than the usual
// one if that is given; what is done to pictures is left to spoil(). Faults of the integrator are
// for render() in float alone, which throws std::invalid_argument else.
void plant(Fault fault, Scene& scene, Settings& settings, std::optional<double> number = {});

// The film with what plant() has left to do, so that mean and variance are those of the spoilt
// picture. `scene` and `settings` are those that the film was rendered with.
Film spoil(Fault fault, const Film& film, const Scene& scene, const Settings& settings,
           std::optional<double> number = {});

}  // namespace plumb
