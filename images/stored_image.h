// SPDX-License-Identifier: Apache-2.0

// A picture as it is stored: what the readers of file formats give to read_image().
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "images/image.h"

namespace plumb {

// x and y of red, green, blue and white.
using Chromaticities = std::array<float, 8>;

constexpr Chromaticities rec709 = {0.640F, 0.330F, 0.300F,  0.600F,
                                   0.150F, 0.060F, 0.3127F, 0.3290F};

// Pixels of a file's coordinates, in which y points down.
struct PixelWindow {
  int64_t x = 0, y = 0, width = 0, height = 0;

  bool operator==(const PixelWindow&) const = default;
};

// The smallest window that has both in it.
PixelWindow unite(const PixelWindow& a, const PixelWindow& b);

struct StoredImage {
  Image image;  // of the data window alone
  PixelWindow data, display;
  int orientation = 1;  // as in TIFF 6.0: 1 is upright
  bool is_integer = false;
  std::string transfer = {};  // linear, srgb, rec709, gamma or a name; empty if it is not stated
  float gamma = 1.0F;
  int alpha = -1;  // the channel's number
  bool is_alpha_straight = false;
  std::optional<Chromaticities> chromaticities = {};
};

// Throws an ImageError that says what went wrong with the file and why.
[[noreturn]] void fail(const std::filesystem::path& file, std::string_view what,
                       std::string_view reason);

// The number of the part that is meant. Throws ImageError if none has this name or number.
int find_part(const std::vector<std::string>& names, const std::string& part,
              const std::filesystem::path& file);

// Throws ImageError if the picture has no channels or if these pixels of it would need more than
// half of this machine's memory, or of what the process may have of it (`ulimit -m`): a header can
// claim any size, and a few bytes can stand for many pixels of one colour.
void check_size(const StoredImage& stored, const PixelWindow& frame,
                const std::filesystem::path& file);

}  // namespace plumb
