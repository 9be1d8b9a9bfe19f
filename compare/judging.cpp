// SPDX-License-Identifier: Apache-2.0

#include "compare/judging.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <stdexcept>

#include "compare/card.h"
#include "compare/shared_samples.h"

namespace plumb {
namespace {

// What was assumed about a picture, a line.
std::string notes(const Picture& picture) {
  std::string text;
  if (picture.image.encoding.find(',') != std::string::npos) {
    text += fmt::format("{}: {}\n", picture.side, picture.image.encoding);
  }
  std::string unknown;  // channels
  for (size_t c = picture.averaged; c < picture.channel_count(); ++c) {
    if (!picture.knows_noise(c)) {
      unknown += " " + picture.image.channels[picture.value_channels[c]];
    }
  }
  if (!picture.knows_noise()) {
    text += fmt::format("{}: noise not known\n", picture.side);
  } else if (!unknown.empty()) {
    text += fmt::format("{}: noise not known of{}\n", picture.side, unknown);
  }
  for (const std::string& note : picture.image.notes) {
    text += fmt::format("{}: {}\n", picture.side, note);
  }
  if (!picture.left_out.empty()) {
    text += fmt::format("{}: not compared: {}\n", picture.side, fmt::join(picture.left_out, " "));
  }
  if (picture.has_few_samples()) {
    text += fmt::format("{}: too few samples to know its noise\n", picture.side);
  }
  return text;
}

// Takes the floors that the reference states, or the card beside it; says so in a line.
std::string take_floors(const std::optional<std::filesystem::path>& file, const Picture& reference,
                        Judgement& judgement) {
  const Provenance& told = reference.image.provenance;
  const bool tells = told.image_floor && told.region_floor;
  std::optional<CardFloors> floors;
  if (tells) {
    floors = {{*told.image_floor}, {*told.region_floor}};
  } else if (file) {
    floors = floors_of_card(*file);
  }
  if (!floors) return "";
  judgement.image_floor = floors->image;
  judgement.floor = floors->region;
  return fmt::format(
      "reference: floor {:.3g} % of the image, {:.3g} % elsewhere, by its "
      "{}\n",
      100.0 * floors->image.value, 100.0 * floors->region.value,
      tells ? "own account" : "card.json");
}

}  // namespace

std::string Judged::explanation() const { return explain(comparison, files) + files.notes; }

void bring_together(Picture& test, Picture& reference, const ComparisonTerms& terms) {
  leave_out_overscan(test, reference);
  if (!terms.other_scene) refuse_other_scenes(test, reference);
}

Judged judge(Picture& test, Picture& reference, const Regions& regions,
             const ComparisonTerms& terms,
             const std::optional<std::filesystem::path>& reference_file) {
  const Image& image = test.image;
  const Window window = terms.crop.value_or(Window{0, 0, image.width, image.height});
  keep_only(test, reference, window, regions);
  const auto channels = match(test, reference, terms.selection);
  if (window.width > image.width - window.x || window.height > image.height - window.y) {
    throw std::invalid_argument("--crop reaches beyond the picture");
  }
  Judgement judgement = terms.judgement;
  std::string floor_note;
  if (!judgement.floor && !reference.knows_noise()) {
    floor_note = take_floors(reference_file, reference, judgement);
  }
  if (!terms.flip && (judgement.flip_mean || judgement.flip_p95)) {
    throw std::invalid_argument("--flip-mean and --flip-p95 need --flip ldr or hdr");
  }
  Judged judged{window, compare(test, reference, channels, window, regions, judgement), {}};
  if (terms.flip) {
    add_flip(judged.comparison,
             flip(*terms.flip, test, reference, window, regions, terms.pixels_per_degree),
             judgement);
  }
  judged.files = {.test = "test",
                  .reference = "reference",
                  .notes = notes(test) + notes(reference) + floor_note,
                  .samples_per_pixel = test.samples_per_pixel(),
                  .left_out_of_test = test.left_out,
                  .left_out_of_reference = reference.left_out};
  return judged;
}

}  // namespace plumb
