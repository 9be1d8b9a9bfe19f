// One side of a comparison: a picture from anyone's file, checked, with its noise where it is
// known; and named parts of it.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "images/image.h"

namespace plumb {

struct Picture {
  std::string side;  // "test" or "reference"
  Image image;

  // If the image is the mean of several files, the variances of all its values; else empty.
  std::vector<float> file_variances = {};

  // Which of the image's channels are compared, and which channels hold the variances of these, in
  // the image or in `file_variances`. match() finds them.
  std::vector<size_t> value_channels = {};
  std::vector<size_t> variance_channels = {};  // empty if the noise is not known

  double degrees_of_freedom = 1;  // of each variance

  bool knows_noise() const { return !variance_channels.empty(); }
  size_t channel_count() const { return value_channels.size(); }

  // Of the compared channel with this number: radiance, and the variance of that (0 if not known).
  double value(size_t pixel, size_t channel) const {
    return double{image.values[pixel * image.channels.size() + value_channels[channel]]};
  }
  double variance(size_t pixel, size_t channel) const {
    if (!knows_noise()) return 0.0;
    return double{noise_values()[pixel * image.channels.size() + variance_channels[channel]]};
  }

  // What `variance_channels` are channels of.
  const std::vector<float>& noise_values() const {
    return file_variances.empty() ? image.values : file_variances;
  }

  // 0 if the file does not tell. Of several files, those of one.
  double samples_per_pixel() const { return image.provenance.samples_per_pixel(); }

  // Whether it says that it has so few samples per pixel, of all files, that all of them may have
  // missed the same light: then the noise that it claims is less than it has.
  bool has_few_samples() const;
};

// The least that are not few.
constexpr double enough_samples = 16;

// Makes a picture from an image whose variances are from so many replicates. If that is not given,
// the image's metadata may tell; else two are assumed. There are no more replicates than samples.
Picture to_picture(const std::string& side, Image image, std::optional<int> replicates = {});

// Reads a picture. Several files are renders of the same scene with different seeds and equally
// many samples: the picture is their mean, and their scatter is its noise. `part` is the same as in
// read_image(). Throws ImageError.
Picture read_picture(const std::string& side, const std::vector<std::string>& files,
                     const std::string& part);

// Chooses the channels to compare and returns their names: the wanted ones; if none are wanted, R G
// B; without these, all channels, which then must be the same in both pictures. Throws ImageError
// if sizes or channels do not match, or if a value is not finite or, unless `negative` allows that,
// negative.
std::vector<std::string> match(Picture& test, Picture& reference,
                               const std::vector<std::string>& wanted, bool negative);

// The pixels x to x + width - 1 and y to y + height - 1; y points down.
struct Window {
  int x = 0, y = 0, width = 0, height = 0;
};

struct Regions {
  std::vector<std::string> names;
  std::vector<int> of_pixel;  // the index of its region's name, or -1; empty without any regions
};

// Reads a mask, which has a colour for each region and black for pixels in none. A region's name is
// the mask's metadata "plumbline:region#RRGGBB" or, without that, "#RRGGBB" itself, with the sRGB
// codes of the colour. Throws ImageError, also if the mask does not have this size.
Regions read_regions(const std::filesystem::path& mask, int width, int height);

}  // namespace plumb
