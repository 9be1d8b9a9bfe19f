// SPDX-License-Identifier: Apache-2.0

// What was found out about a renderer: for people a page, for programs JSON and JUnit's XML.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "images/image.h"
#include "images/window.h"

namespace plumb {

// Of the questions that are asked. The next one is to have a higher number.
constexpr int certificate_version = 2;

// How a question ended. `failed` is a program that ended early, took too long or left no picture
// that is one; `cannot` one that says, or of which is said, that it can't draw this.
enum class Mark { right, wrong, noisy, cannot, failed };
const char* to_string(Mark mark);

// A block of a picture, 8 x 8 pixels, or a region, and how far one of its channels is off, as a
// part of what is right; half of the 95 % interval.
struct Place {
  std::string region;   // its name; empty for a block
  Window window;        // of a block
  std::string channel;  // "all" for the mean of R, G and B
  double bias = 0.0, error = 0.0;
  std::string text;  // "block at 8,16, R: +12 ± 0.4 %"
};

struct Answer {
  std::string name;   // of the scene or of what was tried
  std::string group;  // of questions, such as "closed forms"
  std::string about;  // what is asked for, and what may be wrong if the answer is: sentences
  Mark mark = Mark::failed;
  std::string text = {};            // the finding, such as "+0.03 ± 0.12 %", or the reason
  double bias = 0.0, error = 0.0;   // of the whole picture, parts of it; half of the 95 % interval
  std::optional<Place> worst = {};  // a block that is wrong most clearly, else a region
  int64_t samples_per_pixel = 0;    // of the last round
  double seconds = 0.0;             // of all rounds
  // Of what is noisy: its variance over that of our picture with as many samples; 0 if not known.
  double noise_ratio = 0.0;
  // Of what is wrong: a caption and the picture.
  std::vector<std::pair<std::string, Image>> pictures = {};
};

// Another renderer, or the same one, on this machine.
struct Pace {
  std::string name;
  double seconds_to_one_percent = 0.0;  // relative error of a picture of 256 x 256 pixels
  bool is_right = true;                 // its picture is not biased
};

struct Certificate {
  std::string renderer;
  std::string version;  // of the renderer, as it says
  std::string host;     // processor and threads
  double tolerance = 0.0;
  std::vector<Answer> answers;  // from the simplest question on
  std::vector<Pace> paces = {};
  std::string noise = {};   // how it falls, a sentence; empty if not known
  bool is_quick = false;    // some questions were not asked
  bool is_complete = true;  // else it was interrupted

  // Whether nothing is wrong and nothing has failed, and all closed forms and scenes that it can
  // draw are right. Stress scenes may be too noisy to tell.
  bool is_passed() const;

  // A sentence with the version, the tolerance and what is wrong first.
  std::string summary() const;

  // What would help where noise is many times ours, sentences; empty if it is nowhere.
  std::string advice() const;

  // As in `plumb compare`: 0 passed, 1 something is wrong or has failed, 3 too noisy to tell.
  int exit_code() const;
};

// From this noise_ratio on it is said.
constexpr double many_times = 20.0;

// The group whose questions may stay open.
constexpr const char* stress_group = "stress scenes";

// The text, and what is wrong most clearly.
std::string finding(const Answer& answer);

nlohmann::ordered_json to_json(const Certificate& certificate);
std::string to_junit(const Certificate& certificate);

// A page in one file.
std::string to_html(const Certificate& certificate);

}  // namespace plumb
