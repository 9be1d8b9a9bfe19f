// SPDX-License-Identifier: Apache-2.0

#include "images/image.h"

#include <OpenImageIO/color.h>
#include <dlfcn.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <string_view>
#include <system_error>
#include <tuple>
#include <utility>

#include "images/exr.h"
#include "images/linear_colours.h"
#include "images/other_formats.h"
#include "images/output_file.h"
#include "images/printable.h"

namespace plumb {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail_with(const fs::path& file, std::string_view what, int error = errno) {
  fail(file, what, std::generic_category().message(error));
}

// Without the dot, in lower case.
std::string extension_of(const fs::path& file) {
  std::string extension = file.extension().string();
  for (char& letter : extension) letter = static_cast<char>(std::tolower(letter));
  return extension.empty() ? "" : extension.substr(1);
}

const OtherFormats& other_formats(const fs::path& file) {
  // Found in the run path of the program that this library is linked to; stays loaded.
  static void* const module = ::dlopen(PLUMB_FORMATS_MODULE, RTLD_NOW | RTLD_LOCAL);
  if (module == nullptr) fail(file, "cannot read or write formats other than EXR", ::dlerror());
  return *static_cast<const OtherFormats*>(::dlsym(module, "plumb_other_formats"));
}

// The sRGB code of a linear value; 0 for what is no number.
unsigned char srgb_code(double linear) {
  const double displayed = linear > 0.0 ? std::min(linear, 1.0) : 0.0;
  return static_cast<unsigned char>(
      std::lround(255.0F * OIIO::linear_to_sRGB(static_cast<float>(displayed))));
}

void write_png(const Image& image, const fs::path& file, double exposure) {
  if (image.channels.size() < 3) fail(file, "cannot encode", "a PNG needs three channels");
  const double gain = std::exp2(exposure);
  std::vector<unsigned char> codes;
  codes.reserve(image.values.size());
  for (size_t p = 0; p < image.values.size(); p += image.channels.size()) {
    for (size_t c = 0; c < 3; ++c) codes.push_back(srgb_code(image.values[p + c] * gain));
  }
  const std::vector<unsigned char> bytes = other_formats(file).encode_png(
      image.width, image.height, codes, to_attributes(image.provenance), file);
  write_file(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

// Where a pixel of a picture that is stored as width x height gets to when that is turned upright.
std::pair<int64_t, int64_t> turn(int64_t x, int64_t y, const PixelWindow& frame, int orientation) {
  const bool swaps = orientation >= 5;
  const auto [width, height] =
      swaps ? std::pair(frame.height, frame.width) : std::pair(frame.width, frame.height);
  if (swaps) std::swap(x, y);
  const bool mirrors_x =
      orientation == 2 || orientation == 3 || orientation == 6 || orientation == 7;
  const bool mirrors_y =
      orientation == 3 || orientation == 4 || orientation == 7 || orientation == 8;
  return {mirrors_x ? width - 1 - x : x, mirrors_y ? height - 1 - y : y};
}

void note_place(StoredImage& stored, const PixelWindow& frame) {
  std::vector<std::string>& notes = stored.image.notes;
  const PixelWindow &data = stored.data, &display = stored.display;
  if (frame != data) {
    notes.push_back(fmt::format(
        "It has {} x {} pixels at {},{} of {} x {}; the rest was taken as 0.", data.width,
        data.height, data.x - frame.x, data.y - frame.y, frame.width, frame.height));
  }
  if (frame != display) {
    notes.push_back(fmt::format("It reaches beyond its display window, which is {} x {} at {},{}.",
                                display.width, display.height, display.x - frame.x,
                                display.y - frame.y));
  }
  if (stored.orientation != 1) {
    notes.push_back(fmt::format("It was turned upright from orientation {}.", stored.orientation));
  }
}

// Puts the pixels where the file shows them, in a frame of both windows.
void place(StoredImage& stored, const fs::path& file) {
  const PixelWindow frame = unite(stored.data, stored.display);
  check_size(stored, frame, file);
  if (stored.orientation < 1 || stored.orientation > 8) stored.orientation = 1;
  note_place(stored, frame);
  Image& image = stored.image;
  const bool swaps = stored.orientation >= 5;
  image.width = static_cast<int>(swaps ? frame.height : frame.width);
  image.height = static_cast<int>(swaps ? frame.width : frame.height);
  const int64_t left = stored.display.x - frame.x, top = stored.display.y - frame.y;
  const auto [x0, y0] = turn(left, top, frame, stored.orientation);
  const auto [x1, y1] = turn(left + stored.display.width - 1, top + stored.display.height - 1,
                             frame, stored.orientation);
  image.display = {int(std::min(x0, x1)), int(std::min(y0, y1)), int(std::abs(x1 - x0)) + 1,
                   int(std::abs(y1 - y0)) + 1};
  image.left = static_cast<int>(stored.display.x) - image.display.x;
  image.top = static_cast<int>(stored.display.y) - image.display.y;
  if (frame == stored.data && stored.orientation == 1) return;
  const size_t count = image.channels.size();
  std::vector<float> placed(size_t(image.width) * size_t(image.height) * count);
  auto from = image.values.begin();
  for (int64_t row = 0; row < stored.data.height; ++row) {
    for (int64_t column = 0; column < stored.data.width; ++column, from += long(count)) {
      const auto [x, y] = turn(column + stored.data.x - frame.x, row + stored.data.y - frame.y,
                               frame, stored.orientation);
      std::copy_n(from, count, placed.begin() + (y * image.width + x) * long(count));
    }
  }
  image.values = std::move(placed);
}

void check_readable(const fs::path& file) {
  const fs::file_status status = fs::status(file);
  if (!fs::exists(status)) fail_with(file, "cannot open", ENOENT);
  if (fs::is_directory(status)) fail_with(file, "cannot read", EISDIR);
  if (!fs::is_regular_file(status)) fail(file, "cannot read", "not a regular file");
  if (::access(file.c_str(), R_OK) != 0) fail_with(file, "cannot open");
  if (fs::file_size(file) == 0) fail(file, "cannot read", "the file is empty");
}

}  // namespace

ImageFormat image_format(const std::filesystem::path& file) {
  const std::string extension = extension_of(file);
  if (extension == "exr") return ImageFormat::exr;
  if (extension == "png") return ImageFormat::png;
  fail(file, "unknown image format", "the name must end in .exr or .png");
}

void write_image(const Image& image, const std::filesystem::path& file, double exposure) {
  const auto pixels = static_cast<size_t>(image.width) * static_cast<size_t>(image.height);
  if (pixels == 0 || image.values.size() != pixels * image.channels.size()) {
    fail(file, "cannot encode",
         fmt::format("{} values for {} x {} pixels of {} channels", image.values.size(),
                     image.width, image.height, image.channels.size()));
  }
  if (image_format(file) == ImageFormat::png) return write_png(image, file, exposure);
  write_file(file, encode_exr(image));
}

Image read_image(const fs::path& file, const std::string& part, Integers integers) {
  check_readable(file);
  const std::string format = extension_of(file);
  try {
    StoredImage stored =
        format == "exr" ? read_exr(file, part) : other_formats(file).read(file, format, part);
    if (integers == Integers::linear) make_linear(stored);
    place(stored, file);
    for (std::string& name : stored.image.channels) name = printable(name);
    return std::move(stored.image);
  } catch (const ImageError&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    fail(file, "damaged image", error.what());
  }
}

Image read_data_window(const fs::path& file, bool has_pixels) {
  check_readable(file);
  StoredImage stored = read_exr(file, "", has_pixels);
  const PixelWindow &data = stored.data, &display = stored.display;
  Image& image = stored.image;
  std::tie(image.left, image.top) = std::pair(int(data.x), int(data.y));
  std::tie(image.width, image.height) = std::pair(int(data.width), int(data.height));
  image.display = {int(display.x - data.x), int(display.y - data.y), int(display.width),
                   int(display.height)};
  return std::move(image);
}

}  // namespace plumb
