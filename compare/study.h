// Renders of one scene by several methods, held against one reference: the data of convergence
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
};

Label label_of(const Picture& picture);

struct Render {
  Label label;
  std::vector<double>
      errors;  // relMSE of each channel, and their mean; the reference's noise in it
};

// The renders of a series at one step.
struct Point {
  Label label;  // with the medians of the seconds
  size_t runs = 0;
  std::vector<double> errors;      // means, without the reference's noise
  std::vector<double> deviations;  // the means' standard errors by the runs' scatter; 0 of one run
};

struct Series {
  std::string name;
  std::vector<Render> renders;
  std::vector<Point> points;  // by samples, and then by seconds
};

// How a series' relMSE falls in one channel, and what is left of it without end: the square of
// `bias`, without the reference's noise. Below that noise it is negative.
//
// It stops if its floor is above the reference's noise by twice the 95 % interval, and if at its
// end it falls slower than 1 / N, than which no unbiased picture's noise falls slower: a fit takes
// what falls ever less fast, as quasi-random samples' error does, for a floor. If it does not stop,
// the law is that without any floor but the reference's noise.
struct Convergence {
  PowerLaw law;
  Interval floor;  // with the reference's noise, as the fit without that knowledge finds it
  Interval bias;
  bool stops = false;
};

// relMSE = mean (x - r)^2 / (r^2 + 0.01), with x the render and r the reference.
class Study {
 public:
  explicit Study(Picture reference) : reference_(std::move(reference)) {}

  // Throws ImageError if the picture can't be compared with the reference.
  void add(Picture picture, const Label& label);

  // The channels that are compared, and "all" for their mean.
  const std::vector<std::string>& channels() const { return channels_; }

  // In the order in which they were added first. Throws ImageError if none was.
  std::vector<Series> series() const;

  // What a perfect picture's relMSE would be, of each channel.
  const std::vector<double>& reference_noise() const { return noise_; }

  // Throws std::invalid_argument with the reason if the series has too few renders.
  Convergence convergence(const Series& series, size_t channel) const;

 private:
  void measure_reference();

  Picture reference_;
  std::vector<std::string> channels_;
  std::vector<double> noise_, noise_deviations_;
  std::vector<Series> series_;
};

}  // namespace plumb
