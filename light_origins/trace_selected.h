// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "renderer/settings.h"
#include "scene/light_origin.h"

namespace plumb {

// Makes render() draw that light alone, in either precision, but not with Method::plain. The origin
// is to be of the scene that is drawn, and to outlive the settings.
void select_light(const LightOrigin& origin, Settings& settings);

}  // namespace plumb
