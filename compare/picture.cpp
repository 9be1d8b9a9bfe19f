#include "compare/picture.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "images/replicates.h"

namespace plumb {
namespace {

using Names = std::vector<std::string>;

std::optional<size_t> place_of(const Image& image, const std::string& channel) {
  const auto found = std::ranges::find(image.channels, channel);
  if (found == image.channels.end()) return std::nullopt;
  return static_cast<size_t>(found - image.channels.begin());
}

// All channels but those that tell of noise, sorted.
Names pictured_channels(const Image& image) {
  std::set<std::string> names(image.channels.begin(), image.channels.end());
  std::erase_if(names, [](const std::string& name) {
    return name.starts_with("variance.") || name.starts_with("replicate");
  });
  return {names.begin(), names.end()};
}

// `all` gets another replicate of each value of the picture.
void join(std::vector<Replicates<float>>& all, const Image& next, const Picture& picture) {
  const Image& first = picture.image;
  if (next.width != first.width || next.channels != first.channels ||
      next.values.size() != all.size()) {
    throw ImageError(fmt::format("the {}'s replicates differ in size or channels", picture.side));
  }
  for (size_t i = 0; i < all.size(); ++i) all[i].add(next.values[i]);
}

void refuse_poison(const Picture& picture, const std::vector<size_t>& places,
                   const std::vector<float>& values, bool negative) {
  const size_t stride = picture.image.channels.size();
  const float least = negative ? std::numeric_limits<float>::lowest() : 0.0F;
  size_t count = 0;
  size_t first = 0;
  for (size_t p = 0; p < values.size(); p += stride) {
    for (const size_t place : places) {
      const float value = values[p + place];
      if (value >= least && value <= std::numeric_limits<float>::max()) continue;  // not NaN either
      if (count++ == 0) first = p + place;
    }
  }
  if (count == 0) return;
  const auto width = static_cast<size_t>(picture.image.width);
  throw ImageError(fmt::format(
      "the {} has {} values that are NaN, infinite or negative; the first, {}, is at {},{} in {}",
      picture.side, count, values[first], first / stride % width, first / stride / width,
      picture.image.channels[first % stride]));
}

void choose(Picture& picture, const Names& channels) {
  picture.value_channels.clear();
  picture.variance_channels.clear();
  for (const std::string& channel : channels) {
    const auto place = place_of(picture.image, channel);
    const auto variance =
        picture.file_variances.empty() ? place_of(picture.image, "variance." + channel) : place;
    if (!place) {
      throw ImageError(fmt::format("the {} has no channel {}, only {}", picture.side, channel,
                                   fmt::join(picture.image.channels, " ")));
    }
    picture.value_channels.push_back(*place);
    if (variance) picture.variance_channels.push_back(*variance);
  }
  if (picture.variance_channels.size() < channels.size()) picture.variance_channels.clear();
}

}  // namespace

bool Picture::has_few_samples() const {
  const double files = file_variances.empty() ? 1.0 : degrees_of_freedom + 1.0;
  const double samples = files * samples_per_pixel();
  return samples > 0.0 && samples < enough_samples;
}

Picture to_picture(const std::string& side, Image image, std::optional<int> replicates) {
  double count = replicates.value_or(image.provenance.replicates.value_or(2));
  const double samples = image.provenance.samples_per_pixel();
  if (samples > 0.0) count = std::min(count, samples);
  const double degrees_of_freedom = std::max(count, 2.0) - 1.0;
  return {.side = side, .image = std::move(image), .degrees_of_freedom = degrees_of_freedom};
}

Picture read_picture(const std::string& side, const Names& files, const std::string& part) {
  Picture picture = to_picture(side, read_image(files.front(), part));
  if (files.size() == 1) return picture;
  picture.degrees_of_freedom = static_cast<double>(files.size()) - 1.0;
  std::vector<Replicates<float>> all(picture.image.values.size());
  join(all, picture.image, picture);
  for (size_t i = 1; i < files.size(); ++i) join(all, read_image(files[i], part), picture);
  for (size_t i = 0; i < all.size(); ++i) {
    picture.image.values[i] = all[i].mean;
    picture.file_variances.push_back(all[i].variance());
  }
  return picture;
}

Names match(Picture& test, Picture& reference, const Names& wanted, bool negative) {
  if (test.image.width != reference.image.width || test.image.height != reference.image.height) {
    throw ImageError(fmt::format("the test has {} x {} pixels, the reference {} x {}",
                                 test.image.width, test.image.height, reference.image.width,
                                 reference.image.height));
  }
  Names channels = wanted;
  if (channels.empty()) {
    channels = pictured_channels(test.image);
    const Names others = pictured_channels(reference.image);
    if (channels != others) {
      throw ImageError(fmt::format("the test has channels {}, the reference {}: --channels chooses",
                                   fmt::join(channels, " "), fmt::join(others, " ")));
    }
    const Names rgb = {"R", "G", "B"};
    const auto is_there = [&](const auto& name) { return place_of(test.image, name).has_value(); };
    if (std::ranges::all_of(rgb, is_there)) channels = rgb;
  }
  for (Picture* picture : {&test, &reference}) {
    choose(*picture, channels);
    refuse_poison(*picture, picture->value_channels, picture->image.values,
                  negative || picture->image.is_converted);
    refuse_poison(*picture, picture->variance_channels, picture->noise_values(), false);
  }
  return channels;
}

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
      const auto& named = image.provenance.regions;
      const auto found = std::ranges::find(named, code, [](const auto& r) { return r.first; });
      regions.names.push_back(found == named.end() ? code : found->second);
    }
    regions.of_pixel.push_back(entry->second);
  }
  return regions;
}

}  // namespace plumb
