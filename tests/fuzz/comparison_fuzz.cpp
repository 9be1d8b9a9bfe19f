// SPDX-License-Identifier: Apache-2.0

// Two pictures with any values, channels, regions and provenance, and all that is made of them.
#include <fuzzer/FuzzedDataProvider.h>

#include <cstring>
#include <stdexcept>

#include "compare/comparison.h"
#include "compare/maps.h"
#include "compare/report.h"
#include "compare/shared_samples.h"
#include "images/printable.h"

namespace {

using namespace plumb;

// One of its bytes chooses a usual value or any bits.
float draw_value(FuzzedDataProvider& input) {
  const int kind = input.ConsumeIntegralInRange(0, 3);
  if (kind > 0) return static_cast<float>(kind) * 0.5F * input.ConsumeProbability<float>();
  const auto bits = input.ConsumeIntegral<uint32_t>();
  float value = 0.0F;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

Picture draw_picture(FuzzedDataProvider& input, const std::string& side, int width, int height) {
  const std::vector<std::vector<std::string>> sets = {
      {"R", "G", "B"},
      {"Y"},
      {"R", "G", "B", "A", "Z", "variance.R", "variance.G", "variance.B"},
      {"a.R", "a.G", "a.B", "N.X", "N.Y", "N.Z", printable(input.ConsumeRandomLengthString(8))}};
  Image image{width, height, input.PickValueInArray({sets[0], sets[1], sets[2], sets[3]}), {}, {}};
  const size_t count = image.pixel(0, height) * image.channels.size();
  for (size_t i = 0; i < count; ++i) image.values.push_back(draw_value(input));
  if (input.ConsumeBool()) {
    image.provenance.sampler = "sobol";
    image.provenance.seed = input.ConsumeIntegral<int>();
    image.provenance.samples = input.ConsumeRandomLengthString(8);
    image.provenance.replicates = input.ConsumeIntegral<int>();
  }
  return to_picture(side, std::move(image));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  FuzzedDataProvider input(data, size);
  const int width = input.ConsumeIntegralInRange(1, 12),
            height = input.ConsumeIntegralInRange(1, 9);
  Judgement judgement;
  judgement.tolerance = {input.ConsumeProbability<double>(), input.ConsumeBool()};
  if (input.ConsumeBool()) judgement.floor = {input.ConsumeProbability<double>(), true};
  if (input.ConsumeBool()) judgement.hard_limit = {input.ConsumeProbability<double>(), true};
  const bool has_regions = input.ConsumeBool();
  Regions regions{{}, {}, input.ConsumeBool()};
  for (int i = 0; has_regions && i < width * height; ++i) {
    regions.of_pixel.push_back(input.ConsumeIntegralInRange(-1, 2));
  }
  if (has_regions) regions.names = {"a", "b", "c"};
  Window window{input.ConsumeIntegralInRange(0, width - 1),
                input.ConsumeIntegralInRange(0, height - 1), 1, 1};
  window.width = input.ConsumeIntegralInRange(1, width - window.x);
  window.height = input.ConsumeIntegralInRange(1, height - window.y);
  const auto kind = input.PickValueInArray({FlipKind::ldr, FlipKind::hdr});
  const auto map =
      input.PickValueInArray({MapKind::difference, MapKind::z, MapKind::blocks, MapKind::flip});
  const bool negative = input.ConsumeBool();
  Picture test = draw_picture(input, "test", width, height);
  Picture reference = draw_picture(input, "reference", width, height);
  try {
    refuse_other_scenes(test, reference);
    keep_only(test, reference, window, regions);
    const auto channels = match(test, reference, {.negative = negative});
    Comparison comparison = compare(test, reference, channels, window, regions, judgement);
    if (map == MapKind::flip && (test.averaged == 3 || test.averaged == 1)) {
      constexpr double pixels_per_degree = 5.0;  // which are few, to be quick
      add_flip(comparison, flip(kind, test, reference, window, regions, pixels_per_degree),
               judgement);
    }
    const ComparedFiles files{"test", "reference", "", test.samples_per_pixel()};
    to_text(comparison, files);
    to_json(comparison, files).dump();
    draw_map(map, test, reference, window, comparison.flip);
  } catch (const ImageError&) {
  } catch (const std::invalid_argument&) {  // no pixel, or no FLIP
  }
  return 0;
}
