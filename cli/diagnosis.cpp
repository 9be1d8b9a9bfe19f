// SPDX-License-Identifier: Apache-2.0

#include "cli/diagnosis.h"

#include <algorithm>
#include <bit>

#include <fmt/format.h>

#include "cli/film_image.h"
#include "cli/names.h"
#include "cli/scene_options.h"
#include "cli/suspect_pictures.h"
#include "cli/suspect_search.h"

namespace plumb::cli {
namespace {

constexpr uint32_t usual_seed = 0x706c6d62;  // hardly anybody's

// Samples of all pixels of the reference, some seconds; but not more than 1024 per pixel.
constexpr int64_t affordable_samples = int64_t{1} << 25;

// A second thing is looked for where the first explains so much.
constexpr double worth_a_pair = 0.1;

// If that leaves the most doubt, a picture that looks right is held against one of so many times
// the samples.
constexpr int64_t times_more = 4;

// In which direction a picture differs is known by a suspect, so that it may be seen where the
// margins of compare(), which ask in all directions, don't show that it does. Of normal noise 4.6
// standard errors are enough for hundreds of suspects; the rest is for noise that is not.
constexpr double sure = 6.0;

double total_noise(const Picture& picture) {
  double sum = 0.0;
  for (size_t i = 0; i < picture.image.pixel(0, picture.image.height); ++i) {
    for (size_t c = 0; c < picture.averaged; ++c) sum += picture.variance(i, c);
  }
  return sum;
}

// A film as the reference of the picture.
Picture matched(Picture& test, const Film& film) {
  Picture model = to_picture("reference", film);
  match(test, model, {"R", "G", "B"}, true);
  return model;
}

int64_t samples_of_reference(const Image& image) {
  const auto pixels = static_cast<uint64_t>(image.pixel(0, image.height));
  return std::clamp<int64_t>(
      static_cast<int64_t>(std::bit_floor(uint64_t{affordable_samples} / pixels)), 64, 1024);
}

Settings settings_for(const Scene& scene, const Picture& test) {
  return {.precision = fitting_precision(scene),
          .seed = usual_seed + (test.image.provenance.seed == int{usual_seed} ? 2U : 0U),
          .bounces = scene.request.bounces};
}

// Looks for one suspect, then for two, and renders what agrees as well as the reference, if its
// noise leaves the most doubt.
void find_suspects(SuspectSearch& search, const Scene& scene, const Picture& test, double tolerance,
                   int64_t samples, Diagnosis& result) {
  result.suspects = search.look_for(all_suspects(scene));
  if (result.suspects.empty()) return;
  const Suspect& first = result.suspects.front();
  if (first.agreement.is_refuted && first.explained > worth_a_pair) {
    for (Suspect& pair : search.look_for(search.pairs_with(first))) {
      result.suspects.push_back(std::move(pair));
    }
    search.rank(result.suspects);
  }
  Suspect& best = result.suspects.front();
  if (!best.agreement.is_refuted && best.agreement.within > tolerance &&
      total_noise(test) <= total_noise(search.picture_of(*best.film))) {
    search.examine(best, samples);
  }
  if (!best.agreement.is_refuted) {
    result.shared_noise = shared_noise(test, search.picture_of(*best.film)).sure();
  }
  result.tried = search.tried();
}

// Of a picture that looks right, but may not be: keeps what was found only if the picture surely
// lies in that direction.
void keep_what_is_sure(const SuspectSearch& search, Diagnosis& result) {
  if (!result.suspects.empty()) {
    const Suspect& best = result.suspects.front();
    const double errors = search.towards(best);
    if (!best.agreement.is_refuted && errors > sure) {
      result.healthy.is_refuted = true;
      result.healthy.rest = fmt::format(
          "by {:.0f} standard errors, seen all together in what {} changes", errors, name_of(best));
      return;
    }
  }
  result.suspects.clear();
  result.shared_noise = 0.0;
}

}  // namespace

std::optional<Diagnosis> diagnose(const Scene& original, Picture& test, double tolerance,
                                  const std::function<void(const std::string&)>& show,
                                  const std::atomic<bool>& stop) {
  Scene scene = original;
  scene.camera.width = test.image.width;
  scene.camera.height = test.image.height;
  RegionMask mask = region_mask(scene, RegionKind::side);
  const Regions regions{std::move(mask.names), std::move(mask.regions)};
  SuspectPictures pictures(scene, settings_for(scene, test), show, stop);
  const int64_t usual = samples_of_reference(test.image);
  Diagnosis result{.reference = Film(scene.camera.width, scene.camera.height)};
  Picture healthy;
  bool by_neighbours = false;
  try {
    for (const int64_t samples : {usual, times_more * usual}) {
      pictures.refine_reference(samples);
      healthy = matched(test, pictures.reference());
      if (samples == usual) by_neighbours = !test.knows_noise();
      if (by_neighbours) tell_noise_by_neighbours(test, healthy);
      result.healthy = agreement(test, healthy, regions, false_alarm / 2.0, by_neighbours);
      const bool is_enough = result.healthy.is_refuted || result.healthy.within <= tolerance;
      if (is_enough || total_noise(test) > total_noise(healthy)) break;
    }
    result.shared_noise = shared_noise(test, healthy).sure();
    const bool is_open = !by_neighbours && result.healthy.within > tolerance &&
                         result.shared_noise < much_shared_noise;
    if (result.healthy.is_refuted || is_open) {
      SuspectSearch search(pictures, test, healthy, regions, by_neighbours, usual);
      find_suspects(search, scene, test, tolerance, usual, result);
      if (!result.healthy.is_refuted) keep_what_is_sure(search, result);
    }
  } catch (const Stopped&) {
    return {};
  }
  result.reference = pictures.reference();
  return result;
}

}  // namespace plumb::cli
