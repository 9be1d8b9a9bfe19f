// SPDX-License-Identifier: Apache-2.0

#include "images/other_formats.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <OpenImageIO/strutil.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string_view>
#include <utility>

#include "images/printable.h"

namespace plumb {
namespace {

namespace fs = std::filesystem;

// The transfer function that the file states, for which OpenImageIO 3 has other names than 2.4.
void read_transfer(const OIIO::ImageSpec& spec, StoredImage& stored) {
  const std::string stated = spec.get_string_attribute("oiio:ColorSpace");
  const std::string name = OIIO::Strutil::lower(stated);
  stored.transfer = printable(stated);
  if (name == "srgb" || name == "srgb_rec709_scene") stored.transfer = "srgb";
  if (name == "rec709") stored.transfer = "rec709";
  if (name == "linear" || name == "lin_rec709_scene" || name == "lin_rec709" ||
      name == "lin_srgb") {
    stored.transfer = "linear";
  }
  const bool is_gamma = name.starts_with("g") && name.ends_with("_rec709_scene");
  if (is_gamma || name.starts_with("gamma")) {
    const float digits = OIIO::Strutil::stof(name.substr(std::min(name.size(), size_t{5})));
    stored.gamma = is_gamma || digits == 0.0F ? spec.get_float_attribute("oiio:Gamma") : digits;
    stored.transfer = stored.gamma == 1.0F ? "linear" : "gamma";
  }
}

PixelWindow data_window(const OIIO::ImageSpec& spec) {
  return {spec.x, spec.y, spec.width, spec.height};
}

// Without a display window of its own a picture is shown whole.
PixelWindow display_window(const OIIO::ImageSpec& spec) {
  if (spec.full_width <= 0 || spec.full_height <= 0) return data_window(spec);
  return {spec.full_x, spec.full_y, spec.full_width, spec.full_height};
}

Provenance provenance_of(const OIIO::ImageSpec& spec) {
  Attributes attributes;
  for (const OIIO::ParamValue& attribute : spec.extra_attribs) {
    const std::string name = attribute.name().string();
    if (attribute.type() == OIIO::TypeDesc::STRING) {
      attributes.emplace_back(name, attribute.get_string());
    } else if (attribute.type() == OIIO::TypeDesc::INT) {
      attributes.emplace_back(name, attribute.get_int());
    } else if (attribute.type() == OIIO::TypeDesc::DOUBLE) {
      attributes.emplace_back(name, attribute.get<double>());
    }
  }
  return to_provenance(attributes);
}

uint32_t read_number(std::istream& stream, int bytes, bool is_little_endian = false) {
  uint32_t number = 0;
  for (int i = 0; i < bytes; ++i) {
    const uint32_t byte = static_cast<unsigned char>(stream.get());
    number = is_little_endian ? number | byte << 8 * i : number << 8 | byte;
  }
  return number;
}

// A PNG's own, which OpenImageIO doesn't tell. A profile stands above them.
std::optional<Chromaticities> png_chromaticities(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::optional<Chromaticities> found;
  std::string chunk(4, ' ');
  for (std::streamoff next = 8; stream.seekg(next);) {
    next += 12 + std::streamoff{read_number(stream, 4)};
    if (!stream.read(chunk.data(), 4) || chunk == "IDAT") return found;
    if (chunk == "iCCP" || chunk == "sRGB") return std::nullopt;
    if (chunk != "cHRM") continue;
    found.emplace();
    for (float& x : *found) x = float(read_number(stream, 4)) / 1e5F;
    std::ranges::rotate(*found, found->begin() + 2);  // from white, red, green, blue
  }
  return found;
}

// Those of a part of a TIFF, which OpenImageIO doesn't tell either. Each has a directory of fields
// and the place of the next one. White is that of Rec. 709 where the file states primaries alone.
std::optional<Chromaticities> tiff_chromaticities(const fs::path& file, int part) {
  constexpr uint32_t white = 318, primaries = 319, profile = 34675;
  std::ifstream stream(file, std::ios::binary);
  const bool is_little_endian = stream.get() == 'I';
  const auto number = [&](int bytes) { return read_number(stream, bytes, is_little_endian); };
  stream.seekg(2);
  if (number(2) != 42) return std::nullopt;  // 43 is BigTIFF
  stream.seekg(number(4));
  for (; part > 0; --part) {
    stream.seekg(12 * number(2), std::ios::cur);
    stream.seekg(number(4));
  }
  Chromaticities found = rec709;
  bool has_primaries = false;
  for (uint32_t fields = number(2); fields > 0 && stream; --fields) {
    const uint32_t tag = number(2);
    stream.seekg(6, std::ios::cur);  // type and count
    const uint32_t place = number(4);
    if (tag == profile) return std::nullopt;
    if (tag != white && tag != primaries) continue;
    has_primaries |= tag == primaries;
    const auto next = stream.tellg();
    stream.seekg(place);
    for (size_t i = tag == white ? 6 : 0; i < (tag == white ? 8U : 6U); ++i) {
      const auto numerator = static_cast<float>(number(4));
      found[i] = numerator / static_cast<float>(number(4));
    }
    stream.seekg(next);
  }
  return has_primaries ? std::optional(found) : std::nullopt;
}

StoredImage read_header(const OIIO::ImageSpec& spec) {
  StoredImage stored;
  Image& image = stored.image;
  image.channels = spec.channelnames;
  image.provenance = provenance_of(spec);
  image.encoding = spec.format.c_str();
  stored.data = data_window(spec);
  stored.display = display_window(spec);
  stored.orientation = spec.get_int_attribute("Orientation", 1);
  stored.is_integer = !spec.format.is_floating_point();
  stored.alpha = spec.alpha_channel < spec.nchannels ? spec.alpha_channel : -1;
  stored.is_alpha_straight = spec.get_int_attribute("oiio:UnassociatedAlpha") != 0;
  read_transfer(spec, stored);
  const auto* colours = spec.find_attribute("chromaticities");
  if (colours != nullptr && colours->type() == OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8)) {
    std::copy_n(static_cast<const float*>(colours->data()), 8,
                stored.chromaticities.emplace().begin());
  }
  if (const auto* profile = spec.find_attribute("ICCProfile")) {
    const std::string_view bytes(static_cast<const char*>(profile->data()),
                                 static_cast<size_t>(profile->datasize()));
    if (bytes.find("sRGB") == std::string_view::npos) {
      image.notes.emplace_back(
          "Its ICC profile was not applied: its colours were taken as sRGB's.");
    }
  }
  return stored;
}

// Goes to the part.
void seek(OIIO::ImageInput& input, const std::string& part, const fs::path& file, Image& image) {
  std::vector<std::string> names;
  for (int i = 0; input.seek_subimage(i, 0); ++i) {
    const std::string name = input.spec().get_string_attribute("name");
    names.push_back(name.empty() ? std::to_string(i) : printable(name));
  }
  const int number = find_part(names, part, file);
  input.seek_subimage(number, 0);
  image.part = names[size_t(number)];
  names.erase(names.begin() + number);
  image.other_parts = names;
}

StoredImage read(const fs::path& file, const std::string& format, const std::string& part) {
  const std::string name = OIIO::Strutil::upper(format);
  const auto input = OIIO::ImageInput::create(format);
  if (input == nullptr) fail(file, "unknown image format", OIIO::geterror());
  OIIO::ImageSpec config;
  config["oiio:UnassociatedAlpha"] = 1;
  OIIO::ImageSpec spec;
  if (!input->open(file.string(), spec, config)) {
    fail(file, fmt::format("not a {} image", name), input->geterror());
  }
  Image parts;
  seek(*input, part, file, parts);
  spec = input->spec();
  if (spec.deep) fail(file, "cannot decode", "deep images hold no plain picture");
  StoredImage stored = read_header(spec);
  // What OpenImageIO says of its curve is that of PNM's codes.
  const bool is_pfm = !stored.is_integer && input->format_name() == std::string("pnm");
  if (is_pfm) stored.transfer = "linear";
  Image& image = stored.image;
  image.part = parts.part;
  image.other_parts = parts.other_parts;
  if (format == "png" && !stored.chromaticities) stored.chromaticities = png_chromaticities(file);
  if (format == "tif" || format == "tiff") {
    stored.chromaticities = tiff_chromaticities(file, input->current_subimage());
  }
  check_size(stored, stored.data, file);
  image.values.resize(spec.image_pixels() * static_cast<size_t>(spec.nchannels));
  if (!input->read_image(input->current_subimage(), 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT,
                         image.values.data())) {
    fail(file, fmt::format("damaged {} image", name), input->geterror());
  }
  return stored;
}

std::vector<unsigned char> encode_png(int width, int height,
                                      const std::vector<unsigned char>& codes,
                                      const Attributes& attributes, const fs::path& file) {
  OIIO::ImageSpec spec(width, height, 3, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  spec.attribute("Software", "Plumbline " PLUMB_VERSION);
  for (const auto& [name, value] : attributes) {
    if (const auto* real = std::get_if<double>(&value)) {
      spec.attribute(name, OIIO::TypeDesc::DOUBLE, real);
    } else if (const auto* number = std::get_if<int>(&value)) {
      spec.attribute(name, *number);
    } else {
      spec.attribute(name, std::get<std::string>(value));
    }
  }
  std::vector<unsigned char> bytes;
  OIIO::Filesystem::IOVecOutput memory(bytes);
  const auto output = OIIO::ImageOutput::create("png");
  if (output == nullptr) fail(file, "cannot encode", OIIO::geterror());
  // The name is for messages only: the bytes go to `memory`.
  if (!output->set_ioproxy(&memory) || !output->open(file.string(), spec) ||
      !output->write_image(spec.format, codes.data()) || !output->close()) {
    fail(file, "cannot encode", output->geterror());
  }
  return bytes;
}

}  // namespace
}  // namespace plumb

const plumb::OtherFormats plumb_other_formats = {plumb::read, plumb::encode_png};
