// SPDX-License-Identifier: Apache-2.0

// Glass that touches another surface all over a part of a plane.
#pragma once

#include <string>
#include <vector>

#include "scene/scene.h"

namespace plumb {

// Where light goes that leaves a block of glass towards the floor on which it stands is undefined:
// floor and glass are met at the same distance. So each mesh of glass a face of which touches
// another shape's becomes thinner there, until there is air in between, 3e-5 of the scene's half
// diagonal thick; what is behind the face moves in proportion, so that flat faces stay flat.
// Returns a line on each mesh that has changed or, being as thin as that itself, could not.
std::vector<std::string> leave_air_around_glass(Scene& scene);

}  // namespace plumb
