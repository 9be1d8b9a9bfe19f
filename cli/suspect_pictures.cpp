// SPDX-License-Identifier: Apache-2.0

#include "cli/suspect_pictures.h"

#include <fmt/format.h>

#include <array>
#include <vector>

#include "images/relative_error.h"
#include "renderer/render.h"

namespace plumb::cli {
namespace {

// The film or, if that has less noise, reference + film - base, replicate by replicate.
Film steadied(const Film& reference, Film film, const Film& base) {
  using Values = std::vector<float>;
  std::array<Values, Film::replicates> own, steady;
  for (size_t r = 0; r < own.size(); ++r) {
    const int replicate = static_cast<int>(r);
    own[r] = steady[r] = film.replicate_mean(replicate);
    const Values more = reference.replicate_mean(replicate), less = base.replicate_mean(replicate);
    for (size_t i = 0; i < more.size(); ++i) steady[r][i] += more[i] - less[i];
  }
  const auto scatter = [](const std::array<Values, Film::replicates>& all) {
    double sum = 0.0;
    for (size_t r = 1; r < all.size(); ++r) {
      for (size_t i = 0; i < all[r].size(); ++i) {
        const double mean = 0.5 * (double{all[r][i]} + double{all[r - 1][i]});
        const double off = double{all[r][i]} - double{all[r - 1][i]};
        sum += relative_square(off * off, mean);
      }
    }
    return sum;
  };
  if (scatter(own) <= scatter(steady)) return film;
  Film sum(reference.width(), reference.height());
  for (size_t r = 0; r < own.size(); ++r) {
    const int64_t samples = reference.samples_per_replicate()[r];
    sum.add_sums(static_cast<int>(r), samples, steady[r], double(samples));
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
      reference_(scene_.camera.width, scene_.camera.height) {}

// The reference has a seed of its own, so that its noise is not that of the bases.
void SuspectPictures::refine_reference(int64_t samples) {
  Settings other = settings_;
  ++other.seed;
  draw(scene_, other, samples, "reference", reference_);
}

// Adds what the film lacks of the samples.
void SuspectPictures::draw(const Scene& scene, const Settings& settings, int64_t samples,
                           const std::string& what, Film& film) const {
  const auto show = [&](const Progress& progress) {
    show_(fmt::format("{}: {} of {} spp", what, progress.samples_per_pixel, samples));
  };
  render(scene, settings, {.samples = {film.samples_per_pixel(), samples}}, film, show, &stop_);
  if (stop_) throw Stopped();
}

const Film& SuspectPictures::base(Method method, int64_t samples) {
  const auto key = std::pair(method, samples);
  if (!bases_.contains(key)) {
    Settings healthy = settings_;
    healthy.method = method;
    Film film(scene_.camera.width, scene_.camera.height);
    draw(scene_, healthy, samples, "reference", film);
    bases_.emplace(key, std::move(film));
  }
  return bases_.at(key);
}

const std::optional<Film>& SuspectPictures::of(const Suspect& suspect, int64_t samples) {
  Suspect what = suspect;
  std::erase_if(what.plantings, [](const Planting& p) { return !is_drawn(p); });
  const std::string key = fmt::format("{} {} {}", name_of(what), samples, what.has_mis);
  if (key == last_key_) return last_;
  last_key_.clear();
  last_ = reference_;
  if (!what.plantings.empty()) {
    Scene scene = scene_;
    Settings settings = settings_;
    if (!what.has_mis) settings.method = Method::nee;
    for (const Planting& p : what.plantings) plant(p.fault, scene, settings, p.number);
    if (settings.tracer != nullptr) settings.precision = Precision::float32;
    Film film(scene.camera.width, scene.camera.height);
    draw(scene, settings, samples, name_of(suspect), film);
    for (const Planting& p : what.plantings) {
      film = spoil(p.fault, std::move(film), scene, settings, p.number);
    }
    const Film& healthy = base(what.has_mis ? Method::mis : Method::nee, samples);
    if (film.replicate_mean(0) == healthy.replicate_mean(0)) {
      last_.reset();
    } else {
      last_ = steadied(reference_, std::move(film), healthy);
    }
  }
  last_key_ = key;
  return last_;
}

}  // namespace plumb::cli
