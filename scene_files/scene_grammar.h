// SPDX-License-Identifier: Apache-2.0

// What may stand where in a scene file.
#pragma once

#include "scene_files/scene_file.h"

namespace plumb {

// Refuses all elements and attributes that are not supported, that are missing or given twice, and
// notes those that have no effect.
void check_grammar(SceneFile& file);

}  // namespace plumb
