// Named parts of a picture.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace plumb {

// Pixels x to x + width - 1, y to y + height - 1.
struct Window {
  int x = 0, y = 0, width = 0, height = 0;
};

struct Regions {
  std::vector<std::string> names;
  std::vector<int> of_pixel;  // index of its name, -1 for none; empty if there are no regions
};

// Reads a mask: a colour for each region, black for none. A region's name is the picture's text
// "plumbline:region#RRGGBB" or else "#RRGGBB", the colour's sRGB codes. Throws ImageError, also if
// the mask is not of this size.
Regions read_regions(const std::filesystem::path& mask, int width, int height);

}  // namespace plumb
