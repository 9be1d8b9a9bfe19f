// SPDX-License-Identifier: Apache-2.0

// Scenes for people who write a reader in an evening: JSON with all numbers in world space.
#pragma once

#include <string>

#include "scene/scene.h"

namespace plumb {

// The scene as docs/plain-scene.md describes it: triangles and spheres, the camera as a matrix and
// as four corner rays.
std::string plain_scene(const Scene& scene);

}  // namespace plumb
