// One side of a comparison: a picture from anyone's file, checked, with its noise where it is
// known; and named parts of it.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "images/image.h"

namespace plumb {

struct Picture {
  std::string side;  // "test" or "reference"
  Image image;
  std::vector<float> scatter = {};     // variances of the values if they are means of replicates
  std::vector<size_t> values = {};     // the compared channels' places in the image
  std::vector<size_t> variances = {};  // their variances' places, in `scatter` if there is one
  double degrees_of_freedom = 1;       // of each variance

  bool knows_noise() const { return !variances.empty(); }
  double value(size_t pixel, size_t channel) const {
    return double{image.values[pixel * image.channels.size() + values[channel]]};
  }
  double variance(size_t pixel, size_t channel) const {
    if (variances.empty()) return 0.0;
    const std::vector<float>& from = scatter.empty() ? image.values : scatter;
    return double{from[pixel * image.channels.size() + variances[channel]]};
  }

  // 0 if the file doesn't tell.
  double samples_per_pixel() const { return image.provenance.samples_per_pixel(); }
};

// One picture, which may say of how many replicates its variances are.
Picture to_picture(const std::string& side, Image image);

// Reads a picture, or the mean of several renders of the same scene with other seeds and as many
// samples, whose scatter then is its noise. `part` as for read_image(). Throws ImageError.
Picture read_picture(const std::string& side, const std::vector<std::string>& files,
                     const std::string& part);

// Chooses the channels to compare: those that are wanted; or else R G B; or else all, which must be
// the same then. Returns their names. Throws ImageError if sizes or channels don't match, or if a
// value is not a finite number or, unless `negative` allows it, negative.
std::vector<std::string> match(Picture& test, Picture& reference,
                               const std::vector<std::string>& wanted, bool negative);

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
