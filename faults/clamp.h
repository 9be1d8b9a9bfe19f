// SPDX-License-Identifier: Apache-2.0

#pragma once

namespace plumb {

// Where the integrator with the fault clamp-indirect clamps. To clamp elsewhere, plant() dims all
// lamps and spoil() brightens the picture.
constexpr float clamped_at = 10.0F;

}  // namespace plumb
