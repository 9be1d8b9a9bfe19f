// SPDX-License-Identifier: Apache-2.0

// Renders of one scene by several methods, compared with one reference: the data of convergence
// plots and of charts of speed against accuracy.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "compare/picture.h"
#include "compare/power_law.h"

namespace plumb {

// What a picture says about itself, or what is said about it.
struct Label {
  std::string series;          // the program and how it was set
  std::string step;            // its samples per pixel, or a quality
  double samples = 0;          // per pixel; 0: not known
  double seconds = 0;          // of rendering alone; 0: not known
  double startup_seconds = 0;  // of the program before and after; 0: not known
  std::string file = {};       // or what else sentences call the picture
};

Label label_of(const Picture& picture);

struct Render {
  Label label;

  // The relMSE of each channel, and their mean. The reference's noise is part of it.
  std::vector<double> errors;
};

// The renders of a series at one step.
struct Point {
  Label label;  // with the medians of the seconds
  size_t runs = 0;
  std::vector<double> errors;      // mean relMSE of the runs, without the reference's noise
  std::vector<double> deviations;  // its standard error by the scatter of the runs; 0 for one run
};

struct Series {
  std::string name;
  std::vector<Render> renders;
  std::vector<Point> points;  // sorted by samples, and then by seconds
};

// How the relMSE of a series falls in one channel, and where it stops.
//
// It is said to stop if its floor exceeds the reference's noise by twice the half width of the 95 %
// interval, and if at the end of the series it falls more slowly than 1 / N. The second condition
// is needed because a fit takes an error for a floor that falls ever more slowly, as that of
// quasi-random samples does; but no unbiased picture's noise falls more slowly than 1 / N.
struct Convergence {
  PowerLaw law;    // if the error does not stop, its floor is fixed at the reference's noise
  Interval floor;  // as a fit finds it that does not know of the reference's noise
  Interval bias;   // the root of the floor without that noise; negative where the floor is less
  bool stops = false;
};

// relMSE = mean (x - r)^2 / (r^2 + 0.01), with x the render and r the reference.
class Study {
 public:
  explicit Study(Picture reference) : reference_(std::move(reference)) {}

  const Picture& reference() const { return reference_; }

  // Adds a render. It is left out, with a sentence, if it is the reference, or if it shares samples
  // with it: then the two have part of their noise in common, and their difference is less than the
  // error. Throws ImageError if it can't be compared with the reference.
  void add(Picture picture, const Label& label);

  // A sentence for each render that was left out.
  const std::vector<std::string>& left_out() const { return left_out_; }

  // The names of the compared channels, and "all" for their mean.
  const std::vector<std::string>& channels() const { return channels_; }

  // All series, in the order of their first renders. Throws ImageError if there is none.
  std::vector<Series> series() const;

  // For each channel the relMSE that a perfect picture would have.
  const std::vector<double>& reference_noise() const { return noise_; }

  // Fits one channel of a series. Throws std::invalid_argument, with the reason, if it has too few
  // renders.
  Convergence convergence(const Series& series, size_t channel) const;

 private:
  void measure_reference();

  Picture reference_;
  std::vector<std::string> channels_;
  std::vector<double> noise_, noise_deviations_;
  std::vector<Series> series_;
  std::vector<std::string> left_out_;
};

}  // namespace plumb
