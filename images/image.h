// SPDX-License-Identifier: Apache-2.0

// Pictures in files: linear float EXR that says how it was made, sRGB previews, and what other
// programs write.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "images/output_file.h"
#include "images/provenance.h"
#include "images/window.h"

namespace plumb {

// A value per channel and pixel; rows from the top, channels interleaved. What was read is linear,
// has the primaries of Rec. 709, and colours are multiplied by alpha.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::string> channels;
  std::vector<float> values;
  Provenance provenance;

  // Of what was read alone, but left, top and display:
  std::string encoding = {};  // as it was in the file, such as "uint8, srgb, made linear"
  std::string part = {};      // its name in the file or, without one, its number from 0
  std::vector<std::string> other_parts = {};  // of the file, which were not read
  std::vector<std::string> notes = {};        // what was converted or assumed, a sentence each
  // What its numbers were taken as, by what the file may say of them: "transfer function", "alpha"
  // and "primaries".
  std::map<std::string, std::string> tags = {};
  bool is_converted = false;  // from other primaries: colours that Rec. 709 lacks are negative
  int left = 0, top = 0;      // where the first pixel lies in the coordinates of the file's windows
  // What the file shows, from the first pixel on; what lies around it is overscan. Of width 0: all.
  Window display = {};

  // The number of a pixel.
  size_t pixel(int x, int y) const { return size_t(y) * size_t(width) + size_t(x); }
};

class ImageError : public FileError {
 public:
  using FileError::FileError;
};

enum class ImageFormat { exr, png };

// By the file's extension. Throws ImageError if that is neither .exr nor .png.
ImageFormat image_format(const std::filesystem::path& file);

// Writes a float32 EXR, or an 8-bit sRGB PNG of the first three channels times 2^exposure: the same
// bytes for the same picture. Throws ImageError for what is no picture of that format, FileError as
// write_file() does.
void write_image(const Image& image, const std::filesystem::path& file, double exposure = 0.0);

// What becomes of integers in files: radiance, or codes / largest code.
enum class Integers { linear, codes };

// Reads all channels and the provenance that write_image() wrote, from any format that OpenImageIO
// knows by the file's extension. `part` is the name or the number of a part (subimage); empty for
// the first one.
//
// The image is what the file shows: the display window and what lies around it, black and
// transparent where the file has no pixels; turned upright as the file says. Layers of colours are
// in all channels that end in R, G and B. With Integers::codes, windows and orientation are applied
// and colours are left as they are stored.
//
// Throws ImageError, also for a picture that needs more than half of this machine's memory.
Image read_image(const std::filesystem::path& file, const std::string& part = "",
                 Integers integers = Integers::linear);

// Reads an EXR file as write_image() was given it: the pixels that it has, which may be some of
// those that it shows, as they are stored. Without pixels, what its header says. Throws ImageError
// as read_image() does.
Image read_data_window(const std::filesystem::path& file, bool has_pixels = true);

}  // namespace plumb
