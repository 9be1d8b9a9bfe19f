// SPDX-License-Identifier: Apache-2.0

// Any bytes as a picture: of the format that their beginning names, as a mask, and held against
// itself.
#include <fmt/format.h>
#include <sys/resource.h>

#include <string_view>
#include <utility>

#include "compare/comparison.h"
#include "compare/report.h"
#include "tests/fuzz/stored.h"

namespace {

using namespace plumb;

// Without DPX, for whose user data OpenImageIO makes as much room as a header says, up to 8 GB.
const char* extension_of(std::string_view bytes) {
  constexpr std::pair<std::string_view, const char*> formats[] = {{"\x76\x2f\x31\x01", "exr"},
                                                                  {"\x89PNG", "png"},
                                                                  {"\xff\xd8", "jpg"},
                                                                  {"II*", "tif"},
                                                                  {"MM", "tif"},
                                                                  {"#?", "hdr"},
                                                                  {"RIFF", "webp"},
                                                                  {"BM", "bmp"},
                                                                  {"SDPX", "dpx"},
                                                                  {"XPDS", "dpx"},
                                                                  {"Pf", "pfm"},
                                                                  {"PF", "pfm"},
                                                                  {"P", "ppm"}};
  for (const auto& [beginning, extension] : formats) {
    if (bytes.starts_with(beginning)) return extension;
  }
  return "tga";
}

}  // namespace

// Of what is damaged.
extern "C" const char* __lsan_default_suppressions() { return "leak:libOpenImageIO"; }

// The readers refuse what takes more than half of this.
extern "C" int LLVMFuzzerInitialize(int*, char***) {
  const rlimit memory{1 << 18, RLIM_INFINITY};
  return setrlimit(RLIMIT_RSS, &memory);
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const auto file = store(fmt::format("a.{}", extension_of(bytes)), data, size);
  try {
    Picture test = read_picture("test", {file}, "");
    Picture reference = test;
    const Window window{0, 0, test.image.width, test.image.height};
    Regions regions;
    try {
      regions = read_regions(file, window.width, window.height);
    } catch (const ImageError&) {
    }
    keep_only(test, reference, window, regions);
    const auto channels = match(test, reference, {.negative = true});
    const Comparison comparison = compare(test, reference, channels, window, regions, {});
    const ComparedFiles files{"test", "reference", test.image.encoding};
    to_json(comparison, files).dump();
    to_text(comparison, files);
  } catch (const ImageError&) {
  } catch (const std::invalid_argument&) {  // no pixel in any region
  }
  return 0;
}
