// SPDX-License-Identifier: Apache-2.0

// Rectangles of a picture's pixels.
#pragma once

#include <algorithm>
#include <cstdint>

namespace plumb {

// The pixels x to x + width - 1 and y to y + height - 1; y points down.
struct Window {
  int x = 0, y = 0, width = 0, height = 0;

  int64_t pixel_count() const { return int64_t{width} * height; }

  // Pixels are numbered along rows from the top left corner. Of the one that is number `pixel` in
  // the window, the number in a picture with rows so long.
  int64_t number_in_picture(int64_t pixel, int64_t row) const {
    return (y + pixel / width) * row + x + pixel % width;
  }

  bool operator==(const Window&) const = default;
};

// Calls `use` with x and y of each pixel, row by row.
template <typename Use>
void for_each_pixel(const Window& w, Use use) {
  for (int y = w.y; y < w.y + w.height; ++y) {
    for (int x = w.x; x < w.x + w.width; ++x) use(x, y);
  }
}

// The pixels that both have; none if the width or the height is not positive.
inline Window intersection(const Window& a, const Window& b) {
  const int x = std::max(a.x, b.x), y = std::max(a.y, b.y);
  return {x, y, std::min(a.x + a.width, b.x + b.width) - x,
          std::min(a.y + a.height, b.y + b.height) - y};
}

}  // namespace plumb
