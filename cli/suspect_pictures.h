// SPDX-License-Identifier: Apache-2.0

// Renders what suspects would make of a scene, with the same samples as what is right, so that only
// what they change is noisy.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "cli/suspects.h"
#include "renderer/film.h"
#include "renderer/settings.h"
#include "scene/scene.h"

namespace plumb::cli {

// Thrown where a render was stopped.
struct Stopped {};

class SuspectPictures {
 public:
  // `show` is called with what is rendered; both it and `stop` outlive this.
  SuspectPictures(Scene scene, const Settings& settings,
                  const std::function<void(const std::string&)>& show,
                  const std::atomic<bool>& stop);

  // Adds samples to the reference until it has so many per pixel.
  void refine_reference(int64_t samples);
  const Film& reference() const { return *reference_; }
  const Scene& scene() const { return scene_; }
  const Settings& settings() const { return settings_; }

  // Renders what of() needs for these suspects beside their own films.
  void prepare(const std::vector<Suspect>& suspects, int64_t samples);

  // What is rendered for a suspect, without what is done to finished pictures; null if that changes
  // no pixel. It is the suspect's own film of so many samples or, if that has less noise, reference
  // + film - a healthy one of the same samples. After prepare() several threads may ask at once;
  // what was asked last is remembered.
  std::shared_ptr<const Film> of(const Suspect& suspect, int64_t samples);

 private:
  using Means = std::array<std::vector<float>, Film::replicates>;  // of a film's replicates
  using Key = std::pair<Method, int64_t>;

  static Key key_of(const Suspect& suspect, int64_t samples);
  void draw(const Scene& scene, const Settings& settings, int64_t samples, const std::string& what,
            Film& film);
  std::shared_ptr<const Film> drawn(const Suspect& what, int64_t samples);
  std::shared_ptr<const Film> steadied(Film film, const Means& base) const;

  Scene scene_;
  Settings settings_;
  const std::function<void(const std::string&)>& show_;
  const std::atomic<bool>& stop_;
  std::shared_ptr<Film> reference_;
  Means reference_means_;
  std::map<Key, Means> bases_;
  std::mutex mutex_;  // of what is shown and remembered
  std::deque<std::pair<std::string, std::shared_ptr<const Film>>> last_;
};

}  // namespace plumb::cli
