// SPDX-License-Identifier: Apache-2.0

// Looks for the suspects that explain a picture best: many by a few samples, the best ones by more.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "cli/suspect_pictures.h"
#include "cli/suspect_score.h"
#include "cli/suspects.h"
#include "compare/picture.h"

namespace plumb::cli {

class SuspectSearch {
 public:
  // The reference has so many samples per pixel, and its picture, which is matched, is `healthy`.
  // `by_neighbours` says that the noise of `test` is as those tell. All of them outlive this.
  SuspectSearch(SuspectPictures& pictures, const Picture& test, const Picture& healthy,
                const Regions& regions, bool by_neighbours, int64_t samples);

  // The best of these suspects and of their other numbers and exposures, with films, the likeliest
  // first.
  std::vector<Suspect> look_for(std::vector<Suspect> suspects);

  // The suspect with each of the whole table that goes with it and changes anything.
  std::vector<Suspect> pairs_with(Suspect first) const;

  // What agrees first, then by what is left, after refute_what_is_worse(). Of suspects that differ
  // in their numbers alone the best one stays, and of those that add to one that agrees only what
  // is better by far.
  void rank(std::vector<Suspect>& suspects) const;

  // Renders it with so many samples and says whether it agrees.
  void examine(Suspect& suspect, int64_t samples);

  // How far the picture lies from the reference towards the suspect's, in standard errors.
  double towards(const Suspect& suspect) const;

  size_t tried() const { return tried_; }

  // A film as a model of the picture.
  Picture picture_of(const Film& film) const;

 private:
  // What was seen of a suspect and its other numbers and exposures; nothing if it is idle.
  struct Seen {
    std::vector<Suspect> suspects;
    size_t tried = 0;
  };

  std::optional<Picture> judge(Suspect& suspect, int64_t samples) const;
  void judge_all(std::vector<Suspect>& suspects, int64_t samples);
  Seen look_at(const Suspect& suspect, int64_t samples) const;
  bool look(Suspect suspect, int64_t samples, Seen& seen) const;
  void try_numbers(const Suspect& usual, size_t index, int64_t samples, Seen& seen) const;
  void add_exposed(const Suspect& suspect, const Picture& model, Seen& seen) const;
  std::vector<Suspect> best(std::vector<Suspect> suspects, size_t count) const;
  void fit_numbers(Suspect& suspect, int64_t samples);
  void agree_all(std::vector<Suspect>& suspects, int64_t few, int64_t samples);
  void agree(Suspect& suspect, double part = 1.0) const;
  Picture model_of(const Suspect& suspect, const Film& film) const;

  SuspectPictures& pictures_;
  const Picture& test_;
  const Picture& healthy_;
  const Regions& regions_;
  SuspectScore score_;
  bool by_neighbours_;
  int64_t samples_;
  size_t tried_ = 0;
  std::vector<Fault> idle_;  // which change nothing in this scene
};

}  // namespace plumb::cli
