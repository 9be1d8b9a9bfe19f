// SPDX-License-Identifier: Apache-2.0

#include "cli/render_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <optional>
#include <span>
#include <tuple>
#include <utility>

#include "cli/film_image.h"
#include "cli/names.h"
#include "images/relative_error.h"
#include "images/rgb.h"

namespace plumb::cli {
namespace {

struct Part {
  std::string file;
  Window window;
  SampleRange samples;
  bool has_sums;
};

// Of the same pixels, ordered by samples.
using Group = std::span<const Part>;

struct Headers {
  Window picture;
  Provenance provenance;  // of all parts
  std::vector<Part> parts;
};

[[noreturn]] void fail(const std::string& file, const std::string& what) {
  throw ImageError(fmt::format("{}: {}", file, what));
}

void add_header(Headers& all, const std::string& file) {
  const Image image = read_data_window(file, false);
  const Window picture{0, 0, image.display.width, image.display.height};
  const Window window{-image.display.x, -image.display.y, image.width, image.height};
  if (!image.provenance.samples) fail(file, "not a part of a render: lacks samples");
  if (intersection(window, picture) != window) fail(file, "has pixels outside of its picture");
  if (all.parts.empty()) {
    all.picture = picture;
    all.provenance = image.provenance;
  } else {
    if (picture != all.picture) fail(file, "not the same size as the parts before");
    try {
      add_part(all.provenance, image.provenance);
    } catch (const std::invalid_argument& error) {
      fail(file, error.what());
    }
  }
  all.parts.push_back({file, window, parse_samples(*image.provenance.samples), has_sums(image)});
}

std::vector<Group> group(std::vector<Part>& parts) {
  std::ranges::sort(parts, {}, [](const Part& part) {
    const Window& w = part.window;
    return std::tuple(w.y, w.x, w.height, w.width, part.samples.first);
  });
  std::vector<Group> groups;
  for (auto first = parts.begin(); first != parts.end();) {
    const auto is_of_others = [&](const Part& part) { return part.window != first->window; };
    const auto last = std::find_if(first, parts.end(), is_of_others);
    groups.emplace_back(first, last);
    first = last;
  }
  return groups;
}

// The samples that the parts make up.
SampleRange join(Group parts, bool is_whole) {
  for (size_t i = 1; i < parts.size(); ++i) {
    const Part &before = parts[i - 1], &part = parts[i];
    for (const Part* one : {&before, &part}) {
      if (!one->has_sums) fail(one->file, lacks_sums);
    }
    if (part.samples.first == before.samples.last) continue;
    throw ImageError(
        fmt::format("samples {} and {}{} {}", to_string(before.samples), to_string(part.samples),
                    is_whole ? "" : fmt::format(" of pixels {}", to_string(part.window)),
                    part.samples.first < before.samples.last ? "overlap" : "leave a gap"));
  }
  return {parts.front().samples.first, parts.back().samples.last};
}

SampleRange join(const std::vector<Group>& groups, const Window& picture) {
  std::optional<SampleRange> all;
  for (const Group parts : groups) {
    const Window& window = parts.front().window;
    const SampleRange samples = join(parts, window == picture);
    if (!all) all = samples;
    if (samples.first == all->first && samples.last == all->last) continue;
    throw ImageError(fmt::format("pixels {} have samples {}, pixels {} {}",
                                 to_string(groups.front().front().window), to_string(*all),
                                 to_string(window), to_string(samples)));
  }
  return *all;
}

void refuse_overlaps(const std::vector<Group>& groups) {
  for (size_t i = 0; i < groups.size(); ++i) {
    const Window& a = groups[i].front().window;
    // They are ordered by their first rows.
    for (size_t k = i + 1; k < groups.size(); ++k) {
      const Window& b = groups[k].front().window;
      if (b.y >= a.y + a.height) break;
      const Window both = intersection(a, b);
      if (both.width <= 0) continue;
      throw ImageError(fmt::format("{} and {} overlap: both have pixels {}", groups[i].front().file,
                                   groups[k].front().file, to_string(both)));
    }
  }
}

std::vector<Window> windows_of(const std::vector<Group>& groups) {
  std::vector<Window> windows;
  for (const Group parts : groups) windows.push_back(parts.front().window);
  return windows;
}

// The first rectangle in this row, and below, that none of the windows has; of no width if they
// have all of the row.
Window gap_in_row(int row, const std::vector<Window>& windows, const Window& all) {
  std::vector<Window> in_row;
  std::ranges::copy_if(windows, std::back_inserter(in_row),
                       [&](const Window& w) { return row >= w.y && row < w.y + w.height; });
  std::ranges::sort(in_row, {}, &Window::x);
  Window gap{all.x, row, all.width, all.y + all.height - row};
  for (const Window& w : in_row) {
    if (w.x > gap.x) {
      gap.width = w.x - gap.x;
      break;
    }
    gap.x = w.x + w.width;
    gap.width = all.x + all.width - gap.x;
  }
  for (const Window& w : windows) {
    if (w.y > row && intersection(w, gap).width > 0) gap.height = std::min(gap.height, w.y - row);
  }
  return gap;
}

void refuse_gaps(const std::vector<Window>& windows, const Window& all) {
  int64_t count = 0;
  std::vector<int> rows{all.y};  // where a gap may begin
  for (const Window& w : windows) {
    count += w.pixel_count();
    if (w.y + w.height < all.y + all.height) rows.push_back(w.y + w.height);
  }
  if (count == all.pixel_count()) return;
  std::ranges::sort(rows);
  for (const int row : rows) {
    const Window gap = gap_in_row(row, windows, all);
    if (gap.width > 0) throw ImageError(fmt::format("no part has pixels {}", to_string(gap)));
  }
}

Window bounds_of(const std::vector<Window>& windows) {
  Window all = windows.front();
  for (const Window& w : windows) {
    const int right = std::max(all.x + all.width, w.x + w.width);
    const int bottom = std::max(all.y + all.height, w.y + w.height);
    all.x = std::min(all.x, w.x);
    all.y = std::min(all.y, w.y);
    all.width = right - all.x;
    all.height = bottom - all.y;
  }
  return all;
}

// Parts of the same pixels as one.
Image merge_samples(Group parts, double brightness, bool keeps_sums) {
  const Window& window = parts.front().window;
  if (parts.size() == 1) {
    Image image = read_data_window(parts.front().file);
    return keeps_sums ? image : without_sums(std::move(image));
  }
  Film film(window);
  film.set_brightness(brightness);
  for (const Part& part : parts) {
    const Image image = read_data_window(part.file);
    try {
      add_part(film, image, part.samples);
    } catch (const ImageError& error) {
      fail(part.file, error.what());
    }
  }
  return to_image(film, keeps_sums);
}

// Puts a piece with the whole's channels, in whatever order, where `at` lies in `window`.
void paste(const Image& piece, const Window& at, Image& whole, const Window& window) {
  const size_t stride = whole.channels.size();
  for (size_t c = 0; c < stride; ++c) {
    const auto found = std::ranges::find(piece.channels, whole.channels[c]);
    if (piece.channels.size() != stride || found == piece.channels.end()) {
      throw ImageError(fmt::format("pixels {} have other channels", to_string(at)));
    }
    const auto from = static_cast<size_t>(found - piece.channels.begin());
    for_each_pixel({0, 0, at.width, at.height}, [&](int x, int y) {
      const size_t to = whole.pixel(at.x - window.x + x, at.y - window.y + y);
      whole.values[to * stride + c] = piece.values[piece.pixel(x, y) * stride + from];
    });
  }
}

double relative_error(const Image& image) {
  const std::vector<float> variance = rgb_of(image, "variance.");
  if (variance.empty()) return std::numeric_limits<double>::infinity();
  const std::vector<float> mean = rgb_of(image);
  RelativeError error;
  for (size_t i = 0; i < mean.size(); ++i) error.add(variance[i], mean[i]);
  return error.value();
}

}  // namespace

Image merge_parts(const std::vector<std::string>& files, bool is_last) {
  Headers headers;
  for (const std::string& file : files) add_header(headers, file);
  const std::vector<Group> groups = group(headers.parts);
  const std::vector<Window> windows = windows_of(groups);
  const bool is_whole = is_last && windows.size() > 1;
  const Window window = is_whole ? headers.picture : bounds_of(windows);
  Provenance& provenance = headers.provenance;
  provenance.samples = to_string(join(groups, headers.picture));
  refuse_overlaps(groups);
  refuse_gaps(windows, window);
  const bool keeps_sums = !is_last && std::ranges::all_of(headers.parts, &Part::has_sums);

  Image whole{window.width, window.height, {}, {}, {}};
  for (const Group parts : groups) {
    const Image piece = merge_samples(parts, provenance.brightness.value_or(1.0), keeps_sums);
    if (whole.channels.empty()) {
      whole.channels = piece.channels;
      whole.values.resize(whole.pixel(0, whole.height) * whole.channels.size());
    }
    paste(piece, parts.front().window, whole, window);
  }
  provenance.relative_error = relative_error(whole);
  provenance.crop.reset();
  whole.provenance = std::move(provenance);
  put_into_picture(whole, window, headers.picture.width, headers.picture.height);
  return whole;
}

}  // namespace plumb::cli
