// SPDX-License-Identifier: Apache-2.0

// Colours out of images with any channels.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "images/image.h"

namespace plumb {

// The values of the channel `prefix` + "R" and of the two after it, pixel by pixel; nothing if the
// image lacks these.
inline std::vector<float> rgb_of(const Image& image, const std::string& prefix = "") {
  const auto red = std::ranges::find(image.channels, prefix + "R");
  if (image.channels.end() - red < 3) return {};
  std::vector<float> values;
  for (size_t i = size_t(red - image.channels.begin()); i < image.values.size();
       i += image.channels.size()) {
    values.insert(values.end(), &image.values[i], &image.values[i] + 3);
  }
  return values;
}

}  // namespace plumb
