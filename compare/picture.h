// SPDX-License-Identifier: Apache-2.0

// One side of a comparison: a picture from anyone's file, checked, with its noise where it is
// known; and named parts of it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "images/image.h"

namespace plumb {

struct Picture {
  std::string side;  // "test" or "reference"
  Image image;

  // If the image is the mean of several files, the variances of all its values; else empty.
  std::vector<float> file_variances = {};

  // Which of the image's channels are compared, and which channels hold the variances of these, in
  // the image or in `file_variances`. match() finds them. The first `averaged` ones are the
  // picture's colours; "all" is their mean.
  std::vector<size_t> value_channels = {};
  std::vector<std::optional<size_t>> variance_channels = {};  // of each compared channel
  size_t averaged = 0;

  // What one sample that met light adds to a pixel's radiance, in each compared channel: the ratio
  // of variance to radiance that 1 % of the pixels exceed. match() finds it.
  std::vector<double> hits = {};

  std::vector<std::string> left_out = {};  // the channels that match() was told not to compare

  double degrees_of_freedom = 1;  // of each variance

  bool knows_noise(size_t channel = 0) const {
    return channel < variance_channels.size() && variance_channels[channel].has_value();
  }
  size_t channel_count() const { return value_channels.size(); }

  // Of the compared channel with this number: radiance, and the variance of that (0 if not known).
  double value(size_t pixel, size_t channel) const {
    return double{image.values[pixel * image.channels.size() + value_channels[channel]]};
  }
  double variance(size_t pixel, size_t channel) const {
    if (!knows_noise(channel)) return 0.0;
    return double{noise_values()[pixel * image.channels.size() + *variance_channels[channel]]};
  }

  // Likewise, if this is the pixel's truth. One whose samples all missed the light is nearly black
  // and claims next to no noise. Rare hits are Poisson distributed, and so have this variance.
  double variance(size_t pixel, size_t channel, double truth) const {
    const double claimed = variance(pixel, channel);
    constexpr double nearly_black = 0.25;
    if (!knows_noise(channel) || value(pixel, channel) >= nearly_black * truth) return claimed;
    return std::max(claimed, truth * hits[channel]);
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

// The mean of so many images, which are renders of the same scene with different seeds and equally
// many samples; their scatter is its noise. `image` makes them one after the other. Throws
// ImageError if they differ in size or channels.
Picture mean_of(const std::string& side, size_t count, const std::function<Image(size_t)>& image);

// Parts of one file that have no common frame.
class FramesError : public ImageError {
 public:
  using ImageError::ImageError;
};

// Reads a picture; of several files it is mean_of() them. `part` is the same as in
// read_image(); if it is empty, the channels of all parts are read, those of further parts by names
// such as "depth.Z", with the part's name or, without one, its number. Throws FramesError if these
// have other frames than the first, and ImageError.
Picture read_picture(const std::string& side, const std::vector<std::string>& files,
                     const std::string& part, Integers integers = Integers::linear);

// What a channel holds, and so in which unit it is judged: radiance, coverage from 0 to 1, or
// anything else with a sign (depth, normals).
enum class ChannelKind { colour, alpha, data };

// The kind of a channel of the picture that has all of these, by the last part of its name.
ChannelKind kind_of(const std::string& channel, const std::vector<std::string>& all);

// Whether a channel holds no picture but how noisy one is, in this renderer's files, pbrt's or
// Mitsuba's.
bool tells_noise(const std::string& channel);

// What stands before the last dot of a channel's name: "diffuse" for "diffuse.R", "" for "R".
std::string layer_of(const std::string& channel);

// "TEST=REFERENCE", or one name that is the same on both sides.
std::pair<std::string, std::string> name_on_each_side(const std::string& text);

// What of two pictures is compared; channels and layer may have different names on each side.
struct Selection {
  std::vector<std::string> channels = {};  // empty: all
  std::optional<std::string> layer = {};   // that these are channels of
  bool negative = false;                   // colours and alpha may be negative
};

// Chooses the channels to compare and returns their names in the test, those of the picture's
// colours first. Channels that tell of noise are never compared. Throws ImageError if sizes do not
// match, if nothing is left to compare, if only one side has a channel and the selection does not
// leave it out, or if a value is not finite or, where that is not allowed, negative.
std::vector<std::string> match(Picture& test, Picture& reference, const Selection& selection);

// Likewise, but silent about what is left out: the wanted channels; if none are wanted, R G B;
// without these, all.
std::vector<std::string> match(Picture& test, Picture& reference,
                               const std::vector<std::string>& wanted, bool negative);

struct Regions {
  std::vector<std::string> names;
  std::vector<int> of_pixel;   // the index of its region's name, or -1; empty without any regions
  bool excludes_rest = false;  // whether pixels in no region are not compared at all

  // Whether a pixel is compared.
  bool hold(size_t pixel) const {
    return !excludes_rest || of_pixel.empty() || of_pixel[pixel] >= 0;
  }
};

// Makes a picture one of this window; black where it has no pixels.
void reframe(Picture& picture, const Window& window);

// Unless both have the same frame, makes them what they show: leaves out what lies outside the
// display windows, takes what they lack of them as black, and notes that.
void leave_out_overscan(Picture& test, Picture& reference);

// Blackens on both sides what is not compared, so that no bad value there counts: pixels outside
// the window, or that the regions don't hold. Throws ImageError if sizes differ.
void keep_only(Picture& test, Picture& reference, const Window& window, const Regions& regions);

// Reads a mask, which has a colour for each region and black for pixels in none. These are not
// compared, unless the mask names its regions, as those of 'plumb render --aov' do: there black
// pixels see an edge or nothing. A region's name is that of its colour in the provenance or,
// without one, "#RRGGBB", the sRGB codes of the colour. Throws ImageError, also if the mask does
// not have this size.
Regions read_regions(const std::filesystem::path& mask, int width, int height);

}  // namespace plumb
