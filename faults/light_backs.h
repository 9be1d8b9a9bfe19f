// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>

#include "scene/scene.h"

namespace plumb {

// Puts a lamp that faces the other way behind each mesh that shines and for which `wanted` says so,
// too close for light to get between them.
void light_backs(Scene& scene, const std::function<bool(const Shape&)>& wanted);

}  // namespace plumb
