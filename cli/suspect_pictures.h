// SPDX-License-Identifier: Apache-2.0

// Renders what suspects would make of a scene, with the same samples as what is right, so that only
// what they change is noisy.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>

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
  const Film& reference() const { return reference_; }
  const Scene& scene() const { return scene_; }
  const Settings& settings() const { return settings_; }

  // What is rendered for a suspect, without what is done to finished pictures; nothing if that
  // changes no pixel. It is the suspect's own film of so many samples or, if that has less noise,
  // reference + film - a healthy one of the same samples. It is kept until the next call.
  const std::optional<Film>& of(const Suspect& suspect, int64_t samples);

 private:
  void draw(const Scene& scene, const Settings& settings, int64_t samples, const std::string& what,
            Film& film) const;
  const Film& base(Method method, int64_t samples);

  Scene scene_;
  Settings settings_;
  const std::function<void(const std::string&)>& show_;
  const std::atomic<bool>& stop_;
  Film reference_;
  std::map<std::pair<Method, int64_t>, Film> bases_;
  std::string last_key_;
  std::optional<Film> last_;
};

}  // namespace plumb::cli
