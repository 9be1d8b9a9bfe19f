#include "images/image.h"

#include <OpenImageIO/color.h>
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <OpenImageIO/strutil.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <memory>
#include <string_view>
#include <system_error>

#include "images/output_file.h"
#include "images/provenance_attributes.h"

namespace plumb {
namespace {

namespace fs = std::filesystem;

using Bytes = std::vector<unsigned char>;

constexpr const char* software = "Plumbline " PLUMB_VERSION;

// Rec. 709: x and y of red, green, blue and white (D65).
constexpr std::array<float, 8> chromaticities = {0.640F, 0.330F, 0.300F,  0.600F,
                                                 0.150F, 0.060F, 0.3127F, 0.3290F};

[[noreturn]] void fail(const fs::path& file, std::string_view what, std::string_view reason) {
  throw ImageError(fmt::format("{}: {}: {}", file.string(), what, reason));
}

[[noreturn]] void fail(const fs::path& file, std::string_view what, int error = errno) {
  fail(file, what, std::generic_category().message(error));
}

// Encoding.

Bytes encode(const char* format, const OIIO::ImageSpec& spec, const void* pixels,
             const fs::path& file) {
  Bytes bytes;
  OIIO::Filesystem::IOVecOutput memory(bytes);
  const auto output = OIIO::ImageOutput::create(format);
  if (output == nullptr) fail(file, "cannot encode", OIIO::geterror());
  // The name is for messages only: the bytes go to `memory`.
  if (!output->set_ioproxy(&memory) || !output->open(file.string(), spec) ||
      !output->write_image(spec.format, pixels) || !output->close()) {
    fail(file, "cannot encode", output->geterror());
  }
  return bytes;
}

Bytes encode_exr(const Image& image, const fs::path& file) {
  OIIO::ImageSpec spec(image.width, image.height, static_cast<int>(image.channels.size()),
                       OIIO::TypeDesc::FLOAT);
  spec.channelnames = image.channels;
  spec.attribute("compression", "zip");
  spec.attribute("Software", software);
  spec.attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, chromaticities.size()),
                 chromaticities.data());
  write_attributes(image.provenance, spec);
  return encode("exr", spec, image.values.data(), file);
}

// The sRGB code of a linear value; 0 for what is no number.
unsigned char srgb_code(double linear) {
  const double displayed = linear > 0.0 ? std::min(linear, 1.0) : 0.0;
  return static_cast<unsigned char>(
      std::lround(255.0F * OIIO::linear_to_sRGB(static_cast<float>(displayed))));
}

Bytes encode_png(const Image& image, const fs::path& file, double exposure) {
  if (image.channels.size() < 3) fail(file, "cannot encode", "a PNG needs three channels");
  const double gain = std::exp2(exposure);
  Bytes pixels;
  pixels.reserve(image.values.size());
  for (size_t p = 0; p < image.values.size(); p += image.channels.size()) {
    for (size_t c = 0; c < 3; ++c) pixels.push_back(srgb_code(image.values[p + c] * gain));
  }
  OIIO::ImageSpec spec(image.width, image.height, 3, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  spec.attribute("Software", software);
  write_attributes(image.provenance, spec);
  return encode("png", spec, pixels.data(), file);
}

// Decoding.

// The file's colour space as OpenImageIO 2.4 names it; 3 has other names.
std::string colour_space(const OIIO::ImageSpec& spec) {
  const std::string name = OIIO::Strutil::lower(spec.get_string_attribute("oiio:ColorSpace"));
  if (name.empty() || name == "srgb_rec709_scene") return "srgb";
  if (name == "lin_rec709_scene" || name == "lin_rec709" || name == "lin_srgb") return "linear";
  if (name.starts_with("g") && name.ends_with("_rec709_scene")) {
    return fmt::format("gamma{}", spec.get_float_attribute("oiio:Gamma"));
  }
  return name;
}

// Undoes the transfer function that the file states, and says so.
void make_linear(const OIIO::ImageSpec& spec, Image& image) {
  const std::string stated = spec.get_string_attribute("oiio:ColorSpace");
  const std::string space = colour_space(spec);
  const float gamma = space.starts_with("gamma") ? OIIO::Strutil::stof(space.substr(5)) : 0.0F;
  image.encoding += (stated.empty() ? ", assumed to be " : ", ") + space;
  if (space == "linear" || gamma == 1.0F) return;
  if (space != "srgb" && space != "rec709" && gamma <= 0.0F) {
    throw ImageError("unknown colour space " + stated);
  }
  image.encoding += ", made linear";
  for (size_t i = 0; i < image.values.size(); ++i) {
    const size_t channel = i % image.channels.size();
    if (static_cast<int>(channel) == spec.alpha_channel) continue;
    float& value = image.values[i];
    value = space == "srgb"     ? OIIO::sRGB_to_linear(value)
            : space == "rec709" ? OIIO::Rec709_to_linear(value)
                                : std::pow(value, gamma);
  }
}

// Goes to the part and gives its header.
OIIO::ImageSpec seek(OIIO::ImageInput& input, const std::string& part, const fs::path& file) {
  std::string names;
  for (int i = 0; input.seek_subimage(i, 0); ++i) {
    const std::string name = input.spec().get_string_attribute("name");
    if (part.empty() || part == name || part == std::to_string(i)) return input.spec();
    names += fmt::format("{}{} '{}'", names.empty() ? "" : ", ", i, name);
  }
  fail(file, fmt::format("no part '{}'", part), "it has " + names);
}

// A header can claim any size. Compression by more than a factor of 4000 happens to small pictures
// of a single colour only.
void check_plausible(const OIIO::ImageSpec& spec, const fs::path& file) {
  const double wanted = double(spec.width) * spec.height * spec.nchannels * sizeof(float);
  const auto present = static_cast<double>(fs::file_size(file));
  if (wanted > 4000.0 * present + 1e8) {
    fail(file, "damaged image",
         fmt::format("{} x {} pixels of {} channels in {} bytes", spec.width, spec.height,
                     spec.nchannels, present));
  }
}

Image decode(const fs::path& file, const std::string& format, const std::string& part,
             Integers integers) {
  const std::string kind = (format == "exr" ? "an " : "a ") + OIIO::Strutil::upper(format);
  const auto input = OIIO::ImageInput::create(format);
  if (input == nullptr) fail(file, "unknown image format", OIIO::geterror());
  if (fs::file_size(file) == 0) fail(file, fmt::format("not {} image", kind), "the file is empty");
  OIIO::ImageSpec config;
  config["oiio:UnassociatedAlpha"] = 1;
  OIIO::ImageSpec spec;
  if (!input->open(file.string(), spec, config)) {
    fail(file, fmt::format("not {} image", kind), input->geterror());
  }
  spec = seek(*input, part, file);
  if (spec.deep) fail(file, "cannot decode", "deep images hold no plain picture");
  check_plausible(spec, file);
  Image image{spec.width, spec.height, spec.channelnames, {}, read_attributes(spec)};
  image.encoding = spec.format.c_str();
  image.values.resize(spec.image_pixels() * static_cast<size_t>(spec.nchannels));
  if (!input->read_image(input->current_subimage(), 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT,
                         image.values.data())) {
    fail(file, fmt::format("damaged {} image", OIIO::Strutil::upper(format)), input->geterror());
  }
  if (!spec.format.is_floating_point() && integers == Integers::linear) make_linear(spec, image);
  return image;
}

}  // namespace

ImageFormat image_format(const std::filesystem::path& file) {
  const std::string extension = OIIO::Strutil::lower(file.extension().string());
  if (extension == ".exr") return ImageFormat::exr;
  if (extension == ".png") return ImageFormat::png;
  fail(file, "unknown image format", "the name must end in .exr or .png");
}

void write_image(const Image& image, const std::filesystem::path& file, double exposure) {
  const auto pixels = static_cast<size_t>(image.width) * static_cast<size_t>(image.height);
  if (pixels == 0 || image.values.size() != pixels * image.channels.size()) {
    fail(file, "cannot encode",
         fmt::format("{} values for {} x {} pixels of {} channels", image.values.size(),
                     image.width, image.height, image.channels.size()));
  }
  const Bytes bytes = image_format(file) == ImageFormat::exr ? encode_exr(image, file)
                                                             : encode_png(image, file, exposure);
  write_file(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

Image read_image(const fs::path& file, const std::string& part, Integers integers) {
  const std::string extension = OIIO::Strutil::lower(file.extension().string());
  const std::string format = extension.empty() ? "" : extension.substr(1);
  const fs::file_status status = fs::status(file);
  if (!fs::exists(status)) fail(file, "cannot open", ENOENT);
  if (fs::is_directory(status)) fail(file, "cannot read", EISDIR);
  if (!fs::is_regular_file(status)) fail(file, "cannot read", "not a regular file");
  if (::access(file.c_str(), R_OK) != 0) fail(file, "cannot open");
  try {
    return decode(file, format, part, integers);
  } catch (const ImageError&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    fail(file, "damaged image", error.what());
  }
}

}  // namespace plumb
