// Differences as pictures.
#pragma once

#include <optional>

#include "compare/flip.h"

namespace plumb {

// Of the mean over the compared channels, a value per pixel of the window: the difference test -
// reference, that divided by its claimed standard deviation, or that of the block's mean; or FLIP.
enum class MapKind { difference, z, blocks, flip };

// Draws the map with an evenly diverging palette (lightness and chroma are linear in Oklab,
// Ottosson 2020): blue is negative, white 0, red positive. The bar below tells the scale: what it
// is for the largest colour is also returned as the provenance's `scale`. Throws
// std::invalid_argument if FLIP is to be drawn and is not there.
Image draw_map(MapKind kind, const Picture& test, const Picture& reference, const Window& window,
               const std::optional<Flip>& flip = {});

}  // namespace plumb
