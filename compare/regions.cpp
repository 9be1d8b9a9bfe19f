#include "compare/regions.h"

#include <fmt/format.h>

#include <cmath>
#include <map>

#include "images/image.h"

namespace plumb {

Regions read_regions(const std::filesystem::path& mask, int width, int height) {
  const Image image = read_image(mask, "", Integers::codes);
  if (image.width != width || image.height != height || image.channels.size() < 3) {
    throw ImageError(fmt::format("{}: a mask of {} x {} colours is needed, this has {} x {}",
                                 mask.string(), width, height, image.width, image.height));
  }
  Regions regions;
  std::map<long, int> indices{{0, -1}};
  for (size_t i = 0; i < image.values.size(); i += image.channels.size()) {
    long colour = 0;
    for (size_t c = 0; c < 3; ++c) colour = colour * 256 + std::lround(image.values[i + c] * 255);
    const auto [entry, is_new] = indices.emplace(colour, static_cast<int>(regions.names.size()));
    if (is_new) {
      const std::string code = fmt::format("#{:06X}", colour);
      const auto name = metadata_value<std::string>(image.metadata, "region" + code);
      regions.names.push_back(name.value_or(code));
    }
    regions.of_pixel.push_back(entry->second);
  }
  return regions;
}

}  // namespace plumb
