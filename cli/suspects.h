// SPDX-License-Identifier: Apache-2.0

// What may be wrong with a picture: a fault of the table, or several.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compare/explanation.h"
#include "faults/faults.h"
#include "renderer/film.h"
#include "scene/scene.h"

namespace plumb::cli {

// The chance that a picture that is right, or as a suspect says, is called different.
constexpr double false_alarm = 1e-3;

// Of neighbours; above it the picture was filtered.
constexpr double much_shared_noise = 0.15;

struct Planting {
  Fault fault;
  std::optional<double> number = {};  // other than the usual one
};

// What may be wrong, and how well it explains the picture.
struct Suspect {
  std::vector<Planting> plantings;  // in the order of Fault
  bool has_mis = true;              // else lamps are sampled without it (nee)

  // The squared differences that are left (Yardstick), of blocks and of pixels, with a penalty for
  // each choice: the logarithm of the number of values (Schwarz, "Estimating the dimension of a
  // model", Annals of Statistics 6(2), 1978).
  double blocks = 0, pixels = 0;
  double blocks_error = 0, pixels_error = 0;  // the standard deviations of these
  double explained = 0;     // the part of the picture's squared difference from the reference
  double number_error = 0;  // of an exposure
  std::shared_ptr<const Film> film = {};
  Agreement agreement = {};
};

// "`five-bounces` (8) and `flipped`"; what is in parentheses is a number other than the usual one.
std::string name_of(const Suspect& suspect);

// Each row of the table that may show in the scene, with its usual number.
std::vector<Suspect> all_suspects(const Scene& scene);

// Nothing if they exclude each other.
std::optional<Suspect> both(const Suspect& a, const Suspect& b);

// Whether a has the faults that b has, and more.
bool adds_to(const Suspect& a, const Suspect& b);

// Suspects whose squares are above another one's by so many standard deviations of both are worse.
constexpr double clearly = 5.0;

// Of these squares, with those deviations: what is clearly worse than something that is refuted is
// refuted, too, however wide its own margins are.
void refute_what_is_worse(std::vector<Suspect>& suspects, double Suspect::* squares,
                          double Suspect::* deviation);

// Whatever their numbers are.
bool have_same_faults(const Suspect& a, const Suspect& b);

// Whether it takes a render; else it is done to a finished picture.
bool is_drawn(const Planting& planting);

// The side of squares of pixels whose averages err each by itself: more than 1 for filters, unless
// they are sampled, and for what works like one.
int side_without_shared_noise(const Suspect& suspect);

// Whether random numbers repeat themselves in all replicates, which then don't tell the noise.
bool repeats_noise(const Suspect& suspect);

}  // namespace plumb::cli
