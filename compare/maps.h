// SPDX-License-Identifier: Apache-2.0

// Pictures of where two pictures differ.
#pragma once

#include <optional>

#include "compare/flip.h"

namespace plumb {

// What a pixel shows of the mean over the compared channels: the difference test - reference; that
// divided by its claimed standard deviation; the latter of its block's averages; or FLIP.
enum class MapKind { difference, z, blocks, flip };

// Draws the map of a window with a diverging palette, whose lightness and chroma are linear in
// Oklab (Ottosson 2020): negative values are blue, 0 is white, positive values are red. The bar
// below tells the scale; the provenance's `scale` is the value of the strongest colour.
// Throws std::invalid_argument if FLIP is to be drawn and `flip` is empty.
Image draw_map(MapKind kind, const Picture& test, const Picture& reference, const Window& window,
               const std::optional<Flip>& flip = {});

}  // namespace plumb
