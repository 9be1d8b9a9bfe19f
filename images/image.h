// Pictures in files: linear float EXR that says how it was made, sRGB previews, and what other
// programs write.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "images/output_file.h"
#include "images/provenance.h"

namespace plumb {

// A value per channel and pixel; rows from the top, channels interleaved.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::string> channels;
  std::vector<float> values;
  Provenance provenance;
  std::string encoding = {};  // of the file that was read, such as "uint8, srgb, made linear"

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

// Writes a float32 EXR, or an 8-bit sRGB PNG of the first three channels times 2^exposure. Throws
// ImageError for what is no picture of that format, FileError as write_file() does.
void write_image(const Image& image, const std::filesystem::path& file, double exposure = 0.0);

// What becomes of integers in files: radiance, or codes / largest code.
enum class Integers { linear, codes };

// Reads all channels and the provenance that write_image() wrote, from any format that OpenImageIO
// knows by the file's extension. `part` is the name or the number of a part (subimage); empty for
// the first one. Throws ImageError, also for a header that asks for far more memory than the file
// could fill.
Image read_image(const std::filesystem::path& file, const std::string& part = "",
                 Integers integers = Integers::linear);

}  // namespace plumb
