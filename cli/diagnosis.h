// SPDX-License-Identifier: Apache-2.0

// Looks for what a picture of a scene may have gone through that it differs from the right one.
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cli/suspects.h"
#include "compare/explanation.h"
#include "renderer/film.h"
#include "scene/scene.h"

namespace plumb::cli {

struct Diagnosis {
  Film reference;
  Agreement healthy = {};              // of the picture with the reference
  double shared_noise = 0;             // what of it is sure
  size_t tried = 0;                    // how many suspects there were
  std::vector<Suspect> suspects = {};  // the likeliest first, with films; none if all is well
};

// Diagnoses a picture of the scene, which is rendered in its size. What agrees with the picture is
// refined until it does so within `tolerance`, as a part of what is judged, or as well as the
// reference. `show` is called with what is done. Returns nothing after a stop. Throws ImageError if
// the picture has no R, G and B or unfit values.
std::optional<Diagnosis> diagnose(const Scene& original, Picture& test, double tolerance,
                                  const std::function<void(const std::string&)>& show,
                                  const std::atomic<bool>& stop);

// Says so if the picture tells of another version of the scene.
void warn_of_another_version(const Scene& scene, const Picture& test);

// The verdict in words, with a table of the likeliest suspects.
std::string to_text(const Diagnosis& diagnosis, double tolerance);

// Whether the picture is the same as the reference within the tolerance, whatever was found.
Verdict verdict_of(const Diagnosis& diagnosis, double tolerance);

}  // namespace plumb::cli
