// SPDX-License-Identifier: Apache-2.0

// Puts a renderer to the questions of `plumb certify`.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "certificate/certificate.h"
#include "compare/picture.h"
#include "other_renderers/runner.h"

namespace plumb::cli {

// What a renderer is asked to draw.
struct Question {
  std::string name;
  std::string group;
  std::string about;
  Scene scene;
  std::filesystem::path file;
  BounceRange bounces;
  std::function<Picture()> truth;  // with its noise, unless it has none
  bool is_uniform = false;         // the same radiance in all pixels
  bool is_beyond_float = false;    // float need not hold
};

struct Terms {
  double tolerance = 0.005;  // of the mean of the picture, of each of its regions and blocks
  double seconds = 30.0;     // for each question; the first round may take longer
};

// Draws pictures of one renderer. Each has a seed that no other one has.
class Examiner {
 public:
  Examiner(const OtherRenderer& renderer, const Terms& terms, size_t questions,
           const Watcher& watcher);

  // How the program keeps to its description: seeds that differ, bits that are the same where they
  // are promised, noise that is what it seems. The last answer decides how ask() finds the noise of
  // a picture.
  std::vector<Answer> try_protocol(const std::filesystem::path& scene_file);

  // Draws with more and more samples, until the answer is sure or the time is over: as many as a
  // round before tells that it takes. The rounds share the chance of a false alarm, a half for the
  // first one, a quarter for the next. After a stop the answer is noisy.
  Answer ask(const Question& question);

  // A round of ask(), which tells how noise falls and how fast.
  struct Round {
    double samples = 0.0;   // of a pixel
    double seconds = 0.0;   // of rendering
    double variance = 0.0;  // the mean, relative to the truth, over the pixels: relMSE without bias
  };
  const std::vector<Round>& rounds() const { return rounds_; }  // of the last question

  const std::string& version() const { return version_; }

 private:
  Reference draw(const Question& question, int samples, int seeds, int first_seed, int threads = 0);
  Picture look(const Question& question, int samples, int seeds, Answer& answer);
  std::vector<std::string> match_with_truth(Picture& test, Picture& truth, int seeds) const;
  void ask_in_rounds(const Question& question, Answer& answer);

  const OtherRenderer& renderer_;
  const Terms terms_;
  const double false_alarm_;  // of each question
  const Watcher& watcher_;
  int next_seed_ = 1;
  bool are_seeds_heeded_ = true;   // pictures of two seeds differ, where there is noise
  bool is_scatter_honest_ = true;  // pixels of one picture are independent of each other
  double slowest_ = 0.0;           // seconds of rendering that a path took, at most
  std::string version_;
  std::vector<Round> rounds_;
};

}  // namespace plumb::cli
