// SPDX-License-Identifier: Apache-2.0

#include "images/exr.h"

#include <ImfChannelList.h>
#include <ImfChromaticitiesAttribute.h>
#include <ImfDoubleAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfIntAttribute.h>
#include <ImfMultiPartInputFile.h>
#include <ImfName.h>
#include <ImfOutputFile.h>
#include <ImfPartType.h>
#include <ImfRgbaFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStdIO.h>
#include <ImfStringAttribute.h>
#include <ImfThreading.h>
#include <ImfVersion.h>
#include <ImfXdr.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <thread>
#include <tuple>

#include "images/printable.h"
#include "images/provenance_attributes.h"

namespace plumb {
namespace {

namespace fs = std::filesystem;
using Imath::Box2i;
using Imath::V2i;

void use_all_cores() {
  static std::once_flag once;
  std::call_once(once, [] {
    Imf::setGlobalThreadCount(static_cast<int>(std::thread::hardware_concurrency()));
  });
}

PixelWindow window(const Box2i& box) {
  return {box.min.x, box.min.y, int64_t{box.max.x} - box.min.x + 1,
          int64_t{box.max.y} - box.min.y + 1};
}

// A buffer of interleaved floats in the places of these pixels.
Imf::FrameBuffer frame_buffer(const std::vector<std::string>& channels, float* values,
                              const Box2i& box) {
  const size_t pixel = channels.size() * sizeof(float);
  const auto width = static_cast<size_t>(window(box).width);
  Imf::FrameBuffer buffer;
  for (size_t c = 0; c < channels.size(); ++c) {
    buffer.insert(channels[c], Imf::Slice::Make(Imf::FLOAT, values + c, box.min, int64_t(width),
                                                window(box).height, pixel, pixel * width));
  }
  return buffer;
}

Attributes attributes_of(const Imf::Header& header) {
  Attributes attributes;
  for (auto entry = header.begin(); entry != header.end(); ++entry) {
    const Imf::Attribute* attribute = &entry.attribute();
    if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(attribute)) {
      attributes.emplace_back(entry.name(), text->value());
    } else if (const auto* number = dynamic_cast<const Imf::IntAttribute*>(attribute)) {
      attributes.emplace_back(entry.name(), number->value());
    } else if (const auto* real = dynamic_cast<const Imf::DoubleAttribute*>(attribute)) {
      attributes.emplace_back(entry.name(), real->value());
    }
  }
  return attributes;
}

// Layers by name, the nameless first, and in each R, G, B, A and Z before the others.
std::vector<std::string> channels_in_order(const Imf::ChannelList& list) {
  std::vector<std::string> channels;
  for (auto channel = list.begin(); channel != list.end(); ++channel) {
    channels.emplace_back(channel.name());
  }
  std::ranges::sort(channels, {}, [](const std::string& name) {
    const size_t dot = name.rfind('.');
    const std::string layer = dot == std::string::npos ? "" : name.substr(0, dot);
    const std::string last = dot == std::string::npos ? name : name.substr(dot + 1);
    const size_t rank = last.size() == 1 ? std::string("RGBAZ").find(last) : std::string::npos;
    return std::tuple(layer, rank, last);
  });
  return channels;
}

bool is_subsampled(const Imf::ChannelList& list) {
  for (auto channel = list.begin(); channel != list.end(); ++channel) {
    if (channel.channel().xSampling != 1 || channel.channel().ySampling != 1) return true;
  }
  return false;
}

// Luminance and half as much chroma become R, G, B and A, in half precision.
void read_luminance_chroma(const fs::path& file, const Box2i& box, StoredImage& stored) {
  Imf::RgbaInputFile input(file.c_str());
  if ((input.channels() & Imf::WRITE_C) == 0 || !stored.image.other_parts.empty()) {
    fail(file, "cannot decode", "it has subsampled channels that are not Y, RY and BY of one part");
  }
  const auto width = static_cast<size_t>(stored.data.width);
  std::vector<Imf::Rgba> pixels(width * static_cast<size_t>(stored.data.height));
  input.setFrameBuffer(Imf::ComputeBasePointer(pixels.data(), box), 1, width);
  input.readPixels(box.min.y, box.max.y);
  const bool has_alpha = (input.channels() & Imf::WRITE_A) != 0;
  stored.image.channels = {"R", "G", "B"};
  if (has_alpha) stored.image.channels.emplace_back("A");
  stored.image.values.clear();
  for (const Imf::Rgba& pixel : pixels) {
    for (const float value : {pixel.r, pixel.g, pixel.b}) stored.image.values.push_back(value);
    if (has_alpha) stored.image.values.push_back(pixel.a);
  }
  stored.image.notes.emplace_back("Colours were made of luminance and subsampled chroma.");
}

void read_header(const Imf::Header& header, StoredImage& stored) {
  const Attributes attributes = attributes_of(header);
  Image& image = stored.image;
  image.provenance = to_provenance(attributes);
  image.channels = channels_in_order(header.channels());
  stored.data = window(header.dataWindow());
  stored.display = window(header.displayWindow());
  if (Imf::hasChromaticities(header)) {
    const Imf::Chromaticities& c = Imf::chromaticities(header);
    stored.chromaticities = {c.red.x,  c.red.y,  c.green.x, c.green.y,
                             c.blue.x, c.blue.y, c.white.x, c.white.y};
  }
  for (const auto& [name, value] : attributes) {
    if (name == "Orientation" && std::holds_alternative<int>(value)) {
      stored.orientation = std::get<int>(value);
    }
  }
  Imf::PixelType type = Imf::UINT;
  for (auto c = header.channels().begin(); c != header.channels().end(); ++c) {
    if (c.channel().type == Imf::FLOAT || type == Imf::UINT) type = c.channel().type;
  }
  image.encoding = type == Imf::FLOAT ? "float" : type == Imf::HALF ? "half" : "uint";
}

// OpenEXR makes room for all that an attribute says that it holds, up to 2 GB.
void check_attributes(Imf::IStream& stream, const fs::path& file) {
  using Imf::StreamIO;
  int magic = 0, version = 0, size = 0;
  Imf::Xdr::read<StreamIO>(stream, magic);
  Imf::Xdr::read<StreamIO>(stream, version);
  if (magic != Imf::MAGIC) return;
  // A header ends with an empty name, and the headers of several parts with another one.
  std::array<char, Imf::Name::SIZE> name{}, type{};
  bool is_end = !Imf::isMultiPart(version);
  for (;;) {
    Imf::Xdr::read<StreamIO>(stream, Imf::Name::MAX_LENGTH, name.data());
    if (name[0] == 0 && is_end) break;
    is_end = name[0] == 0 || !Imf::isMultiPart(version);
    if (name[0] == 0) continue;
    Imf::Xdr::read<StreamIO>(stream, Imf::Name::MAX_LENGTH, type.data());
    Imf::Xdr::read<StreamIO>(stream, size);
    if (size < 0 || uintmax_t(size) > fs::file_size(file)) {
      fail(file, "damaged EXR image", "an attribute is larger than the file");
    }
    stream.seekg(stream.tellg() + uint64_t(size));
  }
}

// How many times smaller a picture gets at most. Deflated data shrink by up to 1032 times, and
// before that DWA leaves 4 bytes of a block of 8 x 8 floats; all others shrink less.
double most_compression(Imf::Compression compression) {
  constexpr double deflated = 1032.0;
  const bool is_dwa = compression == Imf::DWAA_COMPRESSION || compression == Imf::DWAB_COMPRESSION;
  return is_dwa ? 64.0 * deflated : deflated;
}

// OpenEXR doesn't notice a chunk that holds less than the header says.
void check_bytes(const Imf::Header& header, const StoredImage& stored, const fs::path& file) {
  double bytes = 0.0;  // of a pixel
  for (auto c = header.channels().begin(); c != header.channels().end(); ++c) {
    const Imf::Channel& channel = c.channel();
    bytes += (channel.type == Imf::HALF ? 2.0 : 4.0) / channel.xSampling / channel.ySampling;
  }
  const double pixels = double(stored.data.width) * double(stored.data.height);
  const auto present = static_cast<double>(fs::file_size(file));
  if (pixels * bytes > most_compression(header.compression()) * present) {
    fail(file, "damaged EXR image",
         fmt::format("{} x {} pixels in {} bytes", stored.data.width, stored.data.height, present));
  }
}

void read_pixels(Imf::MultiPartInputFile& input, int number, const fs::path& file,
                 StoredImage& stored) {
  const Imf::Header& header = input.header(number);
  Image& image = stored.image;
  image.values.resize(static_cast<size_t>(stored.data.width * stored.data.height) *
                      image.channels.size());
  const Box2i& box = header.dataWindow();
  if (is_subsampled(header.channels())) return read_luminance_chroma(file, box, stored);
  Imf::InputPart part(input, number);
  part.setFrameBuffer(frame_buffer(image.channels, image.values.data(), box));
  part.readPixels(box.min.y, box.max.y);
}

}  // namespace

std::string encode_exr(const Image& image) {
  use_all_cores();
  const V2i corner(image.left, image.top);
  const Box2i box(corner, corner + V2i(image.width - 1, image.height - 1));
  const Window& shown = image.display;
  const V2i first = corner + V2i(shown.x, shown.y);
  const Box2i display(first, first + V2i(shown.width - 1, shown.height - 1));
  Imf::Header header(shown.width > 0 ? display : box, box);
  header.compression() = Imf::ZIP_COMPRESSION;
  header.insert("Software", Imf::StringAttribute("Plumbline " PLUMB_VERSION));
  const auto& c = rec709;
  Imf::addChromaticities(header, {{c[0], c[1]}, {c[2], c[3]}, {c[4], c[5]}, {c[6], c[7]}});
  for (const auto& [name, value] : to_attributes(image.provenance)) {
    std::visit(
        [&](const auto& typed) {
          header.insert(name, Imf::TypedAttribute<std::decay_t<decltype(typed)>>(typed));
        },
        value);
  }
  for (const std::string& channel : image.channels) {
    header.channels().insert(channel, Imf::Channel(Imf::FLOAT));
  }
  Imf::StdOSStream bytes;
  {
    Imf::OutputFile output(bytes, header);
    // OpenEXR takes what it only reads as not const.
    output.setFrameBuffer(
        frame_buffer(image.channels, const_cast<float*>(image.values.data()), box));
    output.writePixels(image.height);
  }
  return bytes.str();
}

StoredImage read_exr(const fs::path& file, const std::string& part, bool has_pixels) {
  use_all_cores();
  StoredImage stored;
  std::string problem = "not an EXR image";
  try {
    Imf::StdIFStream stream(file.c_str());
    check_attributes(stream, file);
    stream.seekg(0);
    Imf::MultiPartInputFile input(stream);
    problem = "damaged EXR image";
    std::vector<std::string> names;
    for (int i = 0; i < input.parts(); ++i) {
      const Imf::Header& header = input.header(i);
      names.push_back(header.hasName() ? printable(header.name()) : std::to_string(i));
    }
    const int number = find_part(names, part, file);
    stored.image.part = names[size_t(number)];
    names.erase(names.begin() + number);
    stored.image.other_parts = names;
    const Imf::Header& header = input.header(number);
    if (header.hasType() && Imf::isDeepData(header.type())) {
      fail(file, "cannot decode", "deep images hold no plain picture");
    }
    read_header(header, stored);
    if (has_pixels) {
      check_size(stored, stored.data, file);
      check_bytes(header, stored, file);
      read_pixels(input, number, file, stored);
    }
  } catch (const Iex::BaseExc& error) {
    fail(file, problem, error.what());
  }
  return stored;
}

}  // namespace plumb
