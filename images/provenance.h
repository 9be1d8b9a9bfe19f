// SPDX-License-Identifier: Apache-2.0

// What a picture says of itself: who made it, of which scene, how, and at what cost. A picture by
// another program may say nothing: every field may be missing.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

struct Provenance {
  std::optional<std::string> renderer = {};  // "plumbline", or another program with its version
  std::optional<std::string> version = {};
  std::optional<std::string> scene = {};        // its name
  std::optional<std::string> scene_hash = {};   // SHA-1 of all of its files
  std::optional<std::string> scene_notes = {};  // what was taken how, a line each
  std::optional<std::string> method = {};       // these five in the command line's words
  std::optional<std::string> sampler = {};
  std::optional<std::string> precision = {};
  std::optional<std::string> bounces = {};  // "2:5", the last one included; "2:" for 2 and more
  std::optional<std::string> light = {};    // "from lamp" or "by left_wall,floor"; else all
  std::optional<std::string> quality = {};
  std::optional<std::string> settings = {};  // the other program's own that differ, NAME=NUMBER
  std::optional<int> seed = {};              // the first one if there are several
  std::optional<std::string> samples = {};   // of every pixel: "64:128", the last one left out
  std::optional<std::string> crop = {};   // "X,Y,W,H" of a picture of which it has no more pixels
  std::optional<double> brightness = {};  // of the scene's brightest lamp
  std::optional<int> replicates = {};     // independent pictures whose scatter gave the variance
  std::optional<double> relative_error = {};  // estimated, as for `plumb render --error`
  // By how much it may be wrong without any noise, as compare/card.h has it, in parts of 1.
  std::optional<double> image_floor = {}, region_floor = {};
  std::optional<double> wall_seconds = {};     // of rendering alone
  std::optional<double> cpu_seconds = {};      // of all threads
  std::optional<double> process_seconds = {};  // of whole processes, their start included
  std::optional<double> rays = {};
  std::optional<std::string> runs = {};   // JSON: each run's command and what it said it applied
  std::optional<std::string> host = {};   // processor, threads, instruction set
  std::optional<std::string> fault = {};  // the bug that was planted on purpose
  std::optional<std::string> scale = {};  // of a map of differences: what its end colours mean
  // Of a mask: each region's colour as "#RRGGBB", the sRGB codes, and its name.
  std::vector<std::pair<std::string, std::string>> regions = {};

  // 0 if the picture doesn't tell.
  double samples_per_pixel() const;

  bool operator==(const Provenance&) const = default;
};

// Whether the two tell of the same picture, wherever and whenever it was rendered: all is the same
// but costs, the machine and what was noted.
bool is_same_render(const Provenance& a, const Provenance& b);

// Adds the costs and the machine of a part of a render to those of the parts before. Samples and
// relative error are left to the caller. Throws std::invalid_argument, which names the field, if
// anything else differs: then the two are no parts of the same render.
void add_part(Provenance& whole, const Provenance& part);

}  // namespace plumb
