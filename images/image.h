// Pictures in files: linear float EXR that says how it was made, and sRGB previews.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace plumb {

// In the order in which it was added or, read from a file, of the names. Names in the file carry
// the prefix "plumbline:".
using Metadata = std::vector<std::pair<std::string, std::variant<std::string, int, double>>>;

// A value per channel and pixel; rows from the top, channels interleaved.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::string> channels;
  std::vector<float> values;
  Metadata metadata;
};

class ImageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

enum class ImageFormat { exr, png };

// By the file's extension. Throws ImageError if that is neither .exr nor .png.
ImageFormat image_format(const std::filesystem::path& file);

// Throws ImageError if no file can be created beside `file`, before any work is put into it.
void check_writable(const std::filesystem::path& file);

// Writes a float32 EXR, or an 8-bit sRGB PNG of the first three channels times 2^exposure. The file
// appears under its name whole or not at all: a full disk or a kill leaves what was there before.
// Throws ImageError.
void write_image(const Image& image, const std::filesystem::path& file, double exposure = 0.0);

// Reads all channels and the metadata that write_image() wrote. Throws ImageError.
Image read_image(const std::filesystem::path& file);

}  // namespace plumb
