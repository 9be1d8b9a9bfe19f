// SPDX-License-Identifier: Apache-2.0

// Whether lamps are better left to chance.
#pragma once

#include "renderer/settings.h"
#include "scene/scene.h"

namespace plumb {

// Whether every path meets lamps by chance, so that sampling them only adds noise: where nothing
// ends a path but lamps, or everything shines. Told by 4 samples of a picture of 16 x 16 pixels by
// either method, with no more than 2,000 bounces. Chance must have met light in all pixels, with a
// variance of no more than a quarter of the squared mean (else lamps that are hardly ever met would
// be missed); and times its rays, that has to be less than half of what `mis` has. False for scenes
// of more than 300 faces and spheres, which take long to prepare. The same for all seeds and sizes.
bool chance_suffices(const Scene& scene);

}  // namespace plumb
