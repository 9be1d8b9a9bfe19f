// SPDX-License-Identifier: Apache-2.0

// Looks for what a picture of a scene may have gone through that it differs from the right one.
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "compare/explanation.h"
#include "faults/faults.h"
#include "renderer/film.h"
#include "scene/scene.h"

namespace plumb::cli {

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
  std::optional<Film> film = {};
  Agreement agreement = {};
};

// "`five-bounces` (8) and `flipped`"; what is in parentheses is a number other than the usual one.
std::string name_of(const Suspect& suspect);

// Of neighbours; above it the picture was filtered.
constexpr double much_shared_noise = 0.15;

struct Diagnosis {
  Film reference;
  Agreement healthy = {};              // of the picture with the reference
  double shared_noise = 0;             // see there
  size_t tried = 0;                    // how many suspects there were
  std::vector<Suspect> suspects = {};  // the likeliest first, with films; none if all is well
};

// Diagnoses a picture of the scene, which is rendered in its size. What agrees with the picture is
// refined until it does so within `tolerance`, as a part of what is judged, or as well as the
// reference. `show` is called with what is done. Returns nothing after a stop. Throws ImageError if
// the picture has no R, G and B or unfit values.
std::optional<Diagnosis> diagnose(const Scene& scene, Picture& test, double tolerance,
                                  const std::function<void(const std::string&)>& show,
                                  const std::atomic<bool>& stop);

// Says so if the picture tells of another version of the scene.
void warn_of_another_version(const Scene& scene, const Picture& test);

// The verdict in words, with a table of the likeliest suspects.
std::string to_text(const Diagnosis& diagnosis, double tolerance);

// Whether the picture is the same as the reference within the tolerance, whatever was found.
Verdict verdict_of(const Diagnosis& diagnosis, double tolerance);

}  // namespace plumb::cli
