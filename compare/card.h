// SPDX-License-Identifier: Apache-2.0

// How wrong a stored picture may be, by the card that lies beside it.
#pragma once

#include <filesystem>
#include <optional>

#include "compare/comparison.h"

namespace plumb {

// The floors of a picture's average over the whole image, and of its worst region.
struct CardFloors {
  Amount image, region;
};

// Reads them from the card.json in the picture's folder; nothing if there is no such file or if it
// lists no floor of the picture. Throws std::runtime_error if the file is not a card.
std::optional<CardFloors> floors_of_card(const std::filesystem::path& picture);

}  // namespace plumb
