// SPDX-License-Identifier: Apache-2.0

// What stored colours mean: transfer functions, alpha and primaries.
#pragma once

#include "images/stored_image.h"

namespace plumb {

// Makes colours linear, multiplied by alpha and of the primaries of Rec. 709, and notes what was
// converted or assumed.
void make_linear(StoredImage& stored);

}  // namespace plumb
