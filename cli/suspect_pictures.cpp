// SPDX-License-Identifier: Apache-2.0

#include "cli/suspect_pictures.h"

#include <fmt/format.h>

#include <algorithm>

#include "images/relative_error.h"
#include "renderer/render.h"

namespace plumb::cli {
namespace {

// Films that are remembered: of a fault's pairs with what is done to finished pictures there is one
// in turns with others.
constexpr size_t remembered = 4;

std::array<std::vector<float>, Film::replicates> means_of(const Film& film) {
  std::array<std::vector<float>, Film::replicates> means;
  for (size_t r = 0; r < means.size(); ++r) means[r] = film.replicate_mean(static_cast<int>(r));
  return means;
}

double scatter(const std::array<std::vector<float>, Film::replicates>& means) {
  double sum = 0.0;
  for (size_t r = 1; r < means.size(); ++r) {
    for (size_t i = 0; i < means[r].size(); ++i) {
      const double mean = 0.5 * (double{means[r][i]} + double{means[r - 1][i]});
      const double off = double{means[r][i]} - double{means[r - 1][i]};
      sum += relative_square(off * off, mean);
    }
  }
  return sum;
}

}  // namespace

SuspectPictures::SuspectPictures(Scene scene, const Settings& settings,
                                 const std::function<void(const std::string&)>& show,
                                 const std::atomic<bool>& stop)
    : scene_(std::move(scene)),
      settings_(settings),
      show_(show),
      stop_(stop),
      reference_(std::make_shared<Film>(scene_.camera.width, scene_.camera.height)) {}

// The reference has a seed of its own, so that its noise is not that of the bases.
void SuspectPictures::refine_reference(int64_t samples) {
  Settings other = settings_;
  ++other.seed;
  draw(scene_, other, samples, "reference", *reference_);
  reference_means_ = means_of(*reference_);
}

// Adds what the film lacks of the samples.
void SuspectPictures::draw(const Scene& scene, const Settings& settings, int64_t samples,
                           const std::string& what, Film& film) {
  const auto show = [&](const Progress& progress) {
    const std::scoped_lock lock(mutex_);
    show_(fmt::format("{}: {} of {} spp", what, progress.samples_per_pixel, samples));
  };
  render(scene, settings, {.samples = {film.samples_per_pixel(), samples}}, film, show, &stop_);
  if (stop_) throw Stopped();
}

SuspectPictures::Key SuspectPictures::key_of(const Suspect& suspect, int64_t samples) {
  return {suspect.has_mis ? Method::mis : Method::nee, samples};
}

void SuspectPictures::prepare(const std::vector<Suspect>& suspects, int64_t samples) {
  for (const Suspect& suspect : suspects) {
    const Key key = key_of(suspect, samples);
    if (bases_.contains(key) || std::ranges::none_of(suspect.plantings, is_drawn)) continue;
    Settings healthy = settings_;
    healthy.method = key.first;
    Film film(scene_.camera.width, scene_.camera.height);
    draw(scene_, healthy, samples, "reference", film);
    bases_.emplace(key, means_of(film));
  }
}

std::shared_ptr<const Film> SuspectPictures::of(const Suspect& suspect, int64_t samples) {
  Suspect what{suspect.plantings, suspect.has_mis};
  std::erase_if(what.plantings, [](const Planting& p) { return !is_drawn(p); });
  if (what.plantings.empty()) return reference_;
  const std::string key = fmt::format("{} {}", name_of(what), samples);
  {
    const std::scoped_lock lock(mutex_);
    const auto known = std::ranges::find(last_, key, [](const auto& each) { return each.first; });
    if (known != last_.end()) return known->second;
  }
  std::shared_ptr<const Film> film = drawn(what, samples);
  const std::scoped_lock lock(mutex_);
  last_.emplace_front(key, film);
  if (last_.size() > remembered) last_.pop_back();
  return film;
}

std::shared_ptr<const Film> SuspectPictures::drawn(const Suspect& what, int64_t samples) {
  Scene scene = scene_;
  Settings settings = settings_;
  if (!what.has_mis) settings.method = Method::nee;
  for (const Planting& p : what.plantings) plant(p.fault, scene, settings, p.number);
  if (settings.tracer != nullptr) settings.precision = Precision::float32;
  Film film(scene.camera.width, scene.camera.height);
  draw(scene, settings, samples, name_of(what), film);
  for (const Planting& p : what.plantings) {
    film = spoil(p.fault, film, scene, settings, p.number);
  }
  return steadied(std::move(film), bases_.at(key_of(what, samples)));
}

std::shared_ptr<const Film> SuspectPictures::steadied(Film film, const Means& base) const {
  const Means own = means_of(film);
  if (own[0] == base[0]) return nullptr;
  Means steady = own;
  for (size_t r = 0; r < own.size(); ++r) {
    for (size_t i = 0; i < own[r].size(); ++i) steady[r][i] += reference_means_[r][i] - base[r][i];
  }
  if (scatter(own) <= scatter(steady)) return std::make_shared<const Film>(std::move(film));
  auto sum = std::make_shared<Film>(film.width(), film.height());
  for (size_t r = 0; r < own.size(); ++r) {
    const int64_t those = reference_->samples_per_replicate()[r];
    sum->add_sums(static_cast<int>(r), those, steady[r], double(those));
  }
  return sum;
}

}  // namespace plumb::cli
