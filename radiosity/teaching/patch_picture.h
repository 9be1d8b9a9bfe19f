// SPDX-License-Identifier: Apache-2.0

// A picture of patches as they are, each of one colour.
#pragma once

#include "radiosity/radiosity.h"

namespace plumb::radiosity::teaching {

// Of some thousand patches, whose light is found by the whole matrix; `elements` are patches
// and `links` the numbers in the matrix. Its error is told by the difference from a quarter as many
// patches. Takes the bounces and the memory of the settings alone. Throws what draw() throws.
Picture draw_patches(const Scene& scene, const Settings& settings, const Work& work);

}  // namespace plumb::radiosity::teaching
