// SPDX-License-Identifier: Apache-2.0

#include "compare/picture.h"

#include <OpenImageIO/color.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <ranges>
#include <string_view>
#include <utility>

#include "images/replicates.h"

namespace plumb {
namespace {

using Names = std::vector<std::string>;

constexpr size_t pixels_for_hit = size_t{1} << 16;  // are enough

std::optional<size_t> place_of(const Image& image, const std::string& channel) {
  const auto found = std::ranges::find(image.channels, channel);
  if (found == image.channels.end()) return std::nullopt;
  return static_cast<size_t>(found - image.channels.begin());
}

Names pictured_channels(const Image& image) {
  Names names = image.channels;
  std::erase_if(names, tells_noise);
  return names;
}

Names without(Names names, const Names& others) {
  std::erase_if(names, [&](const auto& name) { return std::ranges::count(others, name) > 0; });
  return names;
}

// Its size, and where it lies.
std::string frame(const Image& image) {
  return fmt::format("{} x {} pixels at {},{}", image.width, image.height, image.left, image.top);
}

// `whole` gets the channels of a further part.
void append(Image& whole, const Image& part, const std::string& name) {
  if (frame(part) != frame(whole)) {
    throw FramesError(fmt::format("part {} has {}, part {} {}: --part {} chooses one", whole.part,
                                  frame(whole), name, frame(part), whole.part));
  }
  const size_t stride = whole.channels.size(), more = part.channels.size();
  std::vector<float> values;
  values.reserve(whole.values.size() + part.values.size());
  for (size_t p = 0; p * stride < whole.values.size(); ++p) {
    std::copy_n(&whole.values[p * stride], stride, std::back_inserter(values));
    std::copy_n(&part.values[p * more], more, std::back_inserter(values));
  }
  whole.values = std::move(values);
  for (const std::string& channel : part.channels) {
    const bool is_noise = channel.starts_with("variance.");
    whole.channels.push_back(is_noise ? fmt::format("variance.{}.{}", name, channel.substr(9))
                                      : fmt::format("{}.{}", name, channel));
  }
}

// Channels of pbrt's film `gbuffer` and of Mitsuba's integrator `moment`, which tell how single
// samples scatter, but not how the picture does. pbrt's are of what its sensor saw before that
// became R, G and B, and of samples that met a surface; Mitsuba's are of X, Y and Z, filtered, of a
// number of samples that the file does not tell.
bool tells_noise_of_samples(const std::string& channel) {
  constexpr std::string_view beginnings[] = {"Variance.", "RelativeVariance.", "m2_"};
  return std::ranges::any_of(beginnings, [&](auto text) { return channel.starts_with(text); });
}

void note_noise_of_samples(Image& image) {
  Names names = image.channels;
  std::erase_if(names, [](const auto& name) { return !tells_noise_of_samples(name); });
  if (names.empty()) return;
  image.notes.push_back(
      fmt::format("{} tell of samples, not of how noisy the mean is: they were left out.",
                  fmt::join(names, " ")));
}

// All parts, or the wanted one.
Image read_parts(const std::string& file, const std::string& wanted, Integers integers) {
  Image image = read_image(file, wanted, integers);
  if (!wanted.empty()) return image;
  for (const std::string& part : std::exchange(image.other_parts, {})) {
    append(image, read_image(file, part, integers), part);
  }
  return image;
}

void check_frames(const Picture& test, const Picture& reference) {
  if (frame(test.image) == frame(reference.image)) return;
  throw ImageError(
      fmt::format("the test shows {}, the reference {}: one has to be rendered or cut "
                  "anew, in the other's window",
                  frame(test.image), frame(reference.image)));
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

struct Checked {
  size_t place;  // of a channel
  bool may_be_negative;
};

void refuse_poison(const Picture& picture, const std::vector<Checked>& channels,
                   const std::vector<float>& values) {
  const size_t stride = picture.image.channels.size();
  using Found = std::pair<size_t, size_t>;  // how many, and where the first one is
  const auto [count, first] = tbb::parallel_reduce(
      tbb::blocked_range<size_t>(0, values.size() / stride), Found(),
      [&](const tbb::blocked_range<size_t>& pixels, Found found) {
        for (size_t p = pixels.begin(); p < pixels.end(); ++p) {
          for (const auto& [place, may_be_negative] : channels) {
            const float value = values[p * stride + place];
            const float least = may_be_negative ? std::numeric_limits<float>::lowest() : 0.0F;
            const bool is_good = value >= least && value <= std::numeric_limits<float>::max();
            if (!is_good && found.first++ == 0) found.second = p * stride + place;  // NaN, too
          }
        }
        return found;
      },
      [](const Found& a, const Found& b) {
        return Found(a.first + b.first, a.first > 0 ? a.second : b.second);
      });
  if (count == 0) return;
  const auto width = static_cast<size_t>(picture.image.width);
  const bool is_negative = values[first] < 0.0F && std::isfinite(values[first]);
  throw ImageError(fmt::format(
      "the {} has {} values that are NaN, infinite or negative; the first, {}, is at {},{} in {}{}",
      picture.side, count, values[first], first / stride % width, first / stride / width,
      picture.image.channels[first % stride],
      is_negative ? "; --negative allows negative ones" : ""));
}

double hit(const Picture& picture, size_t channel) {
  std::vector<double> ratios;
  const size_t pixels = picture.image.values.size() / picture.image.channels.size();
  for (size_t p = 0; p < pixels; p += (pixels / pixels_for_hit) | 1) {
    const double value = picture.value(p, channel), variance = picture.variance(p, channel);
    if (value > 0.0 && variance > 0.0) ratios.push_back(variance / value);
  }
  if (ratios.empty()) return 0.0;
  const auto rank = ratios.begin() + std::ptrdiff_t(ratios.size() * 99 / 100);
  std::ranges::nth_element(ratios, rank);
  return *rank;
}

void choose(Picture& picture, const Names& channels, size_t averaged) {
  picture.averaged = averaged;
  picture.value_channels.clear();
  picture.variance_channels.clear();
  for (const std::string& channel : channels) {
    const auto place = place_of(picture.image, channel);
    if (!place) {
      throw ImageError(fmt::format("the {} has no channel {}, only {}", picture.side, channel,
                                   fmt::join(picture.image.channels, " ")));
    }
    picture.value_channels.push_back(*place);
    picture.variance_channels.push_back(
        picture.file_variances.empty() ? place_of(picture.image, "variance." + channel) : place);
  }
  // The noise of all is known with that of each of them.
  auto noise = picture.variance_channels | std::views::take(averaged);
  const auto is_known = [](const auto& place) { return place.has_value(); };
  if (!std::ranges::all_of(noise, is_known)) std::ranges::fill(noise, std::nullopt);
  picture.hits.clear();
  for (size_t c = 0; c < channels.size(); ++c) picture.hits.push_back(hit(picture, c));
  picture.left_out = without(pictured_channels(picture.image), channels);
}

void refuse_poison(const Picture& picture, const Names& channels, bool negative) {
  std::vector<Checked> values, variances;
  for (size_t c = 0; c < channels.size(); ++c) {
    const bool is_data = kind_of(channels[c], channels) == ChannelKind::data;
    values.push_back({picture.value_channels[c], negative || is_data});
    if (picture.knows_noise(c)) variances.push_back({*picture.variance_channels[c], false});
  }
  refuse_poison(picture, values, picture.image.values);
  refuse_poison(picture, variances, picture.noise_values());
}

// The picture's colours, which are those of the unnamed layer or else of the first one with any, in
// their usual order before all else; without any colours all channels stay as they are. Returns how
// many "all" is the mean of.
size_t put_colours_first(std::vector<std::pair<std::string, std::string>>& pairs) {
  Names names, layers;
  for (const auto& [test, reference] : pairs) names.push_back(test);
  const auto is_colour = [&](const std::string& name) {
    return kind_of(name, names) == ChannelKind::colour;
  };
  for (const std::string& name : names) {
    if (is_colour(name)) layers.push_back(layer_of(name));
  }
  if (layers.empty()) return pairs.size();
  const std::string layer = std::ranges::count(layers, "") > 0 ? "" : layers.front();
  const auto is_main = [&](const auto& pair) {
    return is_colour(pair.first) && layer_of(pair.first) == layer;
  };
  const auto rank = [&](const auto& pair) {
    constexpr std::string_view order = "RrGgBbYy";
    return is_main(pair) ? order.find(pair.first.back()) : order.size();
  };
  std::ranges::stable_sort(pairs, {}, rank);
  return static_cast<size_t>(std::ranges::count_if(pairs, is_main));
}

// Channels, and what is left of their names in the selected layers, that both pictures have.
Names common_channels(const Picture& test, const Picture& reference, const Selection& selection) {
  const auto in_layer = [&](const Image& image, const std::string& layer) {
    Names names = pictured_channels(image);
    if (!selection.layer) return names;
    std::erase_if(names, [&](const std::string& name) { return layer_of(name) != layer; });
    for (std::string& name : names) name = name.substr(layer.empty() ? 0 : layer.size() + 1);
    return names;
  };
  const auto layers = name_on_each_side(selection.layer.value_or(""));
  const Names in_test = in_layer(test.image, layers.first);
  const Names in_reference = in_layer(reference.image, layers.second);
  const Names more = without(in_test, in_reference), less = without(in_reference, in_test);
  const Names common = without(in_test, more);
  if (common.empty()) {
    throw ImageError(fmt::format("nothing to compare: the test has channels {}, the reference {}",
                                 fmt::join(test.image.channels, " "),
                                 fmt::join(reference.image.channels, " ")));
  }
  for (const auto& [extra, picture] : {std::pair(&more, &test), {&less, &reference}}) {
    if (extra->empty()) continue;
    throw ImageError(fmt::format("only the {} has {}: --channels {} compares the rest",
                                 picture->side, fmt::join(*extra, " "), fmt::join(common, ",")));
  }
  return common;
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

Picture mean_of(const std::string& side, size_t count, const std::function<Image(size_t)>& image) {
  Picture picture = to_picture(side, image(0));
  if (count == 1) return picture;
  picture.degrees_of_freedom = static_cast<double>(count) - 1.0;
  std::vector<Replicates<float>> all(picture.image.values.size());
  join(all, picture.image, picture);
  for (size_t i = 1; i < count; ++i) join(all, image(i), picture);
  for (size_t i = 0; i < all.size(); ++i) {
    picture.image.values[i] = all[i].mean;
    picture.file_variances.push_back(all[i].variance());
  }
  return picture;
}

Picture read_picture(const std::string& side, const Names& files, const std::string& part,
                     Integers integers) {
  return mean_of(side, files.size(), [&](size_t i) {
    Image image = read_parts(files[i], part, integers);
    if (i == 0) note_noise_of_samples(image);
    return image;
  });
}

bool tells_noise(const std::string& channel) {
  return channel.starts_with("variance.") || channel.starts_with("replicate") ||
         tells_noise_of_samples(channel);
}

std::string layer_of(const std::string& channel) {
  const size_t dot = channel.rfind('.');
  return dot == std::string::npos ? "" : channel.substr(0, dot);
}

ChannelKind kind_of(const std::string& channel, const Names& all) {
  const std::string layer = layer_of(channel);
  const std::string name = channel.substr(layer.empty() ? 0 : layer.size() + 1);
  const Names colours = {"R", "G", "B", "r", "g", "b"};
  if (std::ranges::count(colours, name) > 0) return ChannelKind::colour;
  if (name == "A" || name == "a" || name == "alpha") return ChannelKind::alpha;
  // Y is the luminance, but also a vector's second component.
  const bool is_vector = std::ranges::count(all, channel.substr(0, channel.size() - 1) + "X") > 0;
  return name == "Y" && !is_vector ? ChannelKind::colour : ChannelKind::data;
}

std::pair<std::string, std::string> name_on_each_side(const std::string& text) {
  const size_t sign = text.find('=');
  if (sign == std::string::npos) return {text, text};
  return {text.substr(0, sign), text.substr(sign + 1)};
}

Names match(Picture& test, Picture& reference, const Selection& selection) {
  check_frames(test, reference);
  std::vector<std::pair<std::string, std::string>> pairs;
  for (const std::string& name : selection.channels) pairs.push_back(name_on_each_side(name));
  if (pairs.empty()) {
    for (const std::string& name : common_channels(test, reference, selection)) {
      pairs.emplace_back(name, name);
    }
  }
  const auto layers = name_on_each_side(selection.layer.value_or(""));
  for (auto& [in_test, in_reference] : pairs) {
    if (!layers.first.empty()) in_test = layers.first + "." + in_test;
    if (!layers.second.empty()) in_reference = layers.second + "." + in_reference;
  }
  const size_t averaged = put_colours_first(pairs);
  Names of_test, of_reference;
  for (const auto& [in_test, in_reference] : pairs) {
    of_test.push_back(in_test);
    of_reference.push_back(in_reference);
  }
  choose(test, of_test, averaged);
  choose(reference, of_reference, averaged);
  refuse_poison(test, of_test, selection.negative || test.image.is_converted);
  refuse_poison(reference, of_reference, selection.negative || reference.image.is_converted);
  return of_test;
}

Names match(Picture& test, Picture& reference, const Names& wanted, bool negative) {
  if (!wanted.empty()) return match(test, reference, {.channels = wanted, .negative = negative});
  Names colours = {"R", "G", "B"};
  const auto is_there = [&](const auto& name) { return place_of(test.image, name).has_value(); };
  if (!std::ranges::all_of(colours, is_there)) colours.clear();
  return match(test, reference, {.channels = colours, .negative = negative});
}

void reframe(Picture& picture, const Window& w) {
  Image& image = picture.image;
  const size_t stride = image.channels.size();
  const int left = std::max(w.x, 0), right = std::max(left, std::min(w.x + w.width, image.width));
  const int top = std::max(w.y, 0), bottom = std::min(w.y + w.height, image.height);
  for (std::vector<float>* values : {&image.values, &picture.file_variances}) {
    if (values->empty()) continue;
    std::vector<float> framed(size_t(w.pixel_count()) * stride);
    for (int y = top; y < bottom; ++y) {
      const size_t to = size_t(y - w.y) * size_t(w.width) + size_t(left - w.x);
      std::copy_n(&(*values)[image.pixel(left, y) * stride], size_t(right - left) * stride,
                  &framed[to * stride]);
    }
    *values = std::move(framed);
  }
  image.width = w.width;
  image.height = w.height;
  image.left += w.x;
  image.top += w.y;
}

void leave_out_overscan(Picture& test, Picture& reference) {
  if (frame(test.image) == frame(reference.image)) return;
  for (Picture* picture : {&test, &reference}) {
    const Window& display = picture->image.display;
    if (display.width == 0) continue;  // was not read: there is none
    if (display.width == picture->image.width && display.height == picture->image.height) continue;
    const bool has_overscan = display.x >= 0 && display.y >= 0;
    reframe(*picture, display);
    picture->image.notes.emplace_back(
        has_overscan ? "What lies outside its display window was left out: the other picture has "
                       "another frame."
                     : "What it lacks of its display window was taken as 0.");
  }
}

void keep_only(Picture& test, Picture& reference, const Window& w, const Regions& regions) {
  check_frames(test, reference);
  const bool is_whole =
      w.x == 0 && w.y == 0 && w.width == test.image.width && w.height == test.image.height;
  if (is_whole && regions.of_pixel.empty()) return;
  for (Picture* picture : {&test, &reference}) {
    const size_t stride = picture->image.channels.size();
    for (std::vector<float>* values : {&picture->image.values, &picture->file_variances}) {
      for (size_t i = 0; i < values->size(); i += stride) {
        const int x = int(i / stride % size_t(picture->image.width));
        const int y = int(i / stride / size_t(picture->image.width));
        const bool is_inside = x >= w.x && x < w.x + w.width && y >= w.y && y < w.y + w.height;
        if (!is_inside || !regions.hold(i / stride))
          std::fill_n(values->begin() + std::ptrdiff_t(i), stride, 0.0F);
      }
    }
  }
}

Regions read_regions(const std::filesystem::path& mask, int width, int height) {
  const Image image = read_image(mask, "", Integers::codes);
  if (image.width != width || image.height != height) {
    throw ImageError(fmt::format("{}: a mask of {} x {} pixels is needed, this has {} x {}",
                                 mask.string(), width, height, image.width, image.height));
  }
  if (image.channels.size() < 3) {
    throw ImageError(fmt::format("{}: a mask in colour (R G B) is needed, this has only {}",
                                 mask.string(), fmt::join(image.channels, " ")));
  }
  const bool is_linear = image.encoding == "float" || image.encoding == "half";
  Regions regions;
  regions.excludes_rest = image.provenance.regions.empty();
  std::map<long, int> indices{{0, -1}};
  for (size_t i = 0; i < image.values.size(); i += image.channels.size()) {
    long colour = 0;
    for (size_t c = 0; c < 3; ++c) {
      const float value = image.values[i + c];
      const float code = std::round((is_linear ? OIIO::linear_to_sRGB(value) : value) * 255);
      if (!(code >= 0.0F && code <= 255.0F)) {
        throw ImageError(
            fmt::format("{}: a mask's values are from 0 to 1, not {}", mask.string(), value));
      }
      colour = colour * 256 + static_cast<long>(code);
    }
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
