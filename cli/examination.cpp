// SPDX-License-Identifier: Apache-2.0

#include "cli/examination.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "cli/film_image.h"
#include "compare/comparison.h"
#include "compare/explanation.h"
#include "compare/maps.h"
#include "compare/markdown.h"
#include "compare/report.h"
#include "compare/sums.h"
#include "images/relative_error.h"
#include "images/replicates.h"
#include "images/rgb.h"
#include "renderer/render.h"
#include "scene_files/region_mask.h"
#include "scene_files/scene_reader.h"

namespace plumb::cli {
namespace {

namespace fs = std::filesystem;

constexpr double false_alarm = 1e-3;  // the chance that noise makes any answer wrong
constexpr double few_pixels = 1e-3;   // of all: few samples of so many may all have missed light
constexpr int scene_seeds = 4;        // of a picture whose variance they tell
constexpr int noise_seeds = 8;        // that tell whether noise is honest
constexpr double most_of_a_run = 1 << 22;  // samples: some programs hold them in memory at once

double pixels_of(const Question& question) {
  return double{1} * question.scene.camera.width * question.scene.camera.height;
}

Regions regions_of(const Question& question) {
  if (question.is_uniform) return {};
  RegionMask mask = region_mask(question.scene, RegionKind::side);
  return {std::move(mask.names), std::move(mask.regions)};
}

bool has_noise(const Image& image) {
  const auto variances = rgb_of(image, "variance.");
  return std::ranges::any_of(variances, [](float variance) { return variance > 0.0f; });
}

// The mean of what the variance of each value is to its square.
double relative_variance(const Picture& test, const Picture& truth) {
  double sum = 0.0;
  const size_t pixels = test.image.pixel(0, test.image.height);
  for (size_t i = 0; i < pixels; ++i) {
    const PixelPair pair = pixel_pair(test, truth, i, test.channel_count());
    sum += relative_square(pair.test_variance, pair.reference);
  }
  return sum / double(pixels);
}

// What `plumb compare` says of why, in its first line and without the verdict.
std::string reason(const Comparison& comparison, double samples) {
  const std::string text = explain(comparison, {"", "", "", samples});
  const std::string line = text.substr(0, text.find('\n'));
  return line.substr(line.find(": ") + 2);
}

// The block that differs most clearly; if none surely does, the region.
std::optional<Place> worst_place(const Comparison& comparison) {
  for (const Unit unit : {Unit::block, Unit::region}) {
    const auto level = std::ranges::find(comparison.levels, unit, &Level::unit);
    if (level == comparison.levels.end() || level->worst.empty()) continue;
    const Finding& f = level->worst.front();
    const double scale = f.scale > 0.0 ? f.scale : 1.0;
    Place place{.region = f.name,
                .window = f.window,
                .channel = f.channel,
                .bias = f.estimate.difference / scale,
                .error = f.estimate.confidence / scale,
                .text = f.name};
    if (f.name.empty()) place.text = fmt::format("block at {},{}", f.window.x, f.window.y);
    place.text += fmt::format(", {}: {}", f.channel,
                              percent_with_error(100.0 * place.bias, 100.0 * place.error, 2));
    return place;
  }
  return {};
}

// Half of the interval, of all that is averaged; how far that is off; and what was decided.
void note(const Comparison& comparison, double tolerance, double samples, Answer& answer) {
  const Estimate& whole = comparison.image.back().estimate;
  const double mean = std::abs(whole.reference) > 0.0 ? std::abs(whole.reference) : 1.0;
  answer.bias = whole.difference / mean;
  answer.error = whole.confidence / mean;
  answer.text = percent_with_error(100.0 * answer.bias, 100.0 * answer.error, 2);
  if (comparison.verdict == Verdict::same || comparison.is_same_but_for_pixels) {
    answer.mark = Mark::right;
    const int64_t pixels = comparison.levels.back().different;
    if (pixels > 0)
      answer.text += fmt::format(", but for {} single pixel{}", pixels, pixels == 1 ? "" : "s");
    return;
  }
  switch (comparison.verdict) {
    case Verdict::different:
      answer.mark = Mark::wrong;
      answer.worst = worst_place(comparison);
      // What the worst place does not tell: a region that is clearer than it, or a single pixel.
      if (std::abs(answer.bias) - answer.error <= tolerance) {
        const std::string why = reason(comparison, samples);
        const std::string told = !answer.worst                  ? "nothing"
                                 : answer.worst->region.empty() ? "block"
                                                                : "region";
        if (!why.starts_with(told)) answer.text += "; " + why;
      }
      break;
    default:
      answer.mark = Mark::noisy;
      answer.text += std::isfinite(comparison.samples_factor)
                         ? fmt::format("; about {} times the samples would tell",
                                       rounded(comparison.samples_factor, 2))
                         : ": too close to the tolerance";
  }
}

// The variance of a program's picture over that of ours with as many samples. 0 in scenes without
// lamps that we could sample.
double noise_against_ours(const Question& question, const Examiner::Round& round, Picture& truth,
                          const std::atomic<bool>& stop) {
  constexpr int64_t most_samples = 256;  // with more the variance is taken to fall as N^-1
  if (std::ranges::none_of(question.scene.shapes, &Shape::is_lamp)) return 0.0;
  const int64_t samples = std::clamp<int64_t>(std::llround(round.samples), 16, most_samples);
  Film film(question.scene.camera.width, question.scene.camera.height);
  render(question.scene, {.bounces = question.bounces}, {.samples = {0, samples}}, film, {}, &stop);
  if (stop) return 0.0;
  Picture ours = to_picture("test", film);
  match(ours, truth, {}, true);
  const double variance = relative_variance(ours, truth) * double(samples);
  return variance > 0.0 ? round.variance * round.samples / variance : 0.0;
}

// As large as the scale below a map, which else dwarfs it.
void magnify(Image& image) {
  constexpr int usual = 96;
  const int times = std::max(1, usual / std::max(image.width, image.height));
  Image larger = image;
  larger.width *= times;
  larger.height *= times;
  larger.values.clear();
  const size_t channels = image.channels.size();
  for (int y = 0; y < larger.height; ++y) {
    for (int x = 0; x < larger.width; ++x) {
      const float* pixel = &image.values[image.pixel(x / times, y / times) * channels];
      larger.values.insert(larger.values.end(), pixel, pixel + channels);
    }
  }
  image = std::move(larger);
}

void add_pictures(Picture test, Picture truth, Answer& answer) {
  for (Picture* picture : {&test, &truth}) magnify(picture->image);
  const Window whole{0, 0, test.image.width, test.image.height};
  answer.pictures = {{"the program's", test.image},
                     {"what is right", truth.image},
                     {"difference: blue too dark, red too bright",
                      draw_map(MapKind::difference, test, truth, whole)}};
}

}  // namespace

Examiner::Examiner(const OtherRenderer& renderer, const Terms& terms, size_t questions,
                   const Watcher& watcher)
    : renderer_(renderer),
      terms_(terms),
      false_alarm_(false_alarm / double(std::max<size_t>(questions, 1))),
      watcher_(watcher) {}

Reference Examiner::draw(const Question& question, int samples, int seeds, int first_seed,
                         int threads) {
  ReferenceSettings settings{.quality = Quality::good,
                             .first_seed = first_seed,
                             .bounces = question.bounces,
                             .threads = threads};
  if (renderer_.has_samples) {
    settings.samples_per_pixel = samples;
    settings.seeds = seeds;
  }
  const fs::path log = fs::temp_directory_path() / fmt::format("plumb-{}.log", renderer_.word);
  Reference reference =
      render_reference(renderer_, question.scene, question.file, settings, log, watcher_);
  if (!reference.program.empty()) version_ = reference.program;
  if (version_.find(reference.version) == std::string::npos) version_ += " " + reference.version;
  return reference;
}

// Draws anew. Where the picture doesn't tell its noise, it has none, or match_with_truth() finds
// it.
Picture Examiner::look(const Question& question, int samples, int seeds, Answer& answer) {
  Reference reference = draw(question, samples, seeds, next_seed_);
  next_seed_ += seeds;
  answer.seconds += reference.process_seconds;
  answer.samples_per_pixel = reference.samples_per_pixel;
  const double paths = double{1} * reference.samples_per_pixel * pixels_of(question);
  if (paths > 0.0) slowest_ = std::max(slowest_, reference.wall_seconds / paths);
  rounds_.push_back({double{1} * reference.samples_per_pixel, reference.wall_seconds, 0.0});
  if (reference.seeds == 0) return {};
  reference.image.provenance.samples = fmt::format("0:{}", reference.samples_per_pixel);
  return to_picture("test", std::move(reference.image), reference.seeds);
}

std::vector<std::string> Examiner::match_with_truth(Picture& test, Picture& truth,
                                                    int seeds) const {
  const auto channels = match(test, truth, {}, true);
  const bool is_known = has_noise(test.image) || (are_seeds_heeded_ && seeds > 1);
  if (renderer_.has_samples && !is_known) tell_noise_by_neighbours(test, truth);
  return channels;
}

void Examiner::ask_in_rounds(const Question& question, Answer& answer) {
  Picture truth = question.truth();
  const Regions regions = regions_of(question);
  const double pixels = pixels_of(question);
  const bool is_one_enough = question.is_uniform && is_scatter_honest_;
  const int least_seeds = is_one_enough ? 1 : scene_seeds;
  // Of a pixel: what is worth a start of the program, unless that takes too long.
  const double affordable_at_once = terms_.seconds / 4.0 / (slowest_ * pixels);
  double samples =
      std::max(16.0 * least_seeds, std::min(double(1 << 18) / pixels, affordable_at_once));
  const double most = std::max(1.0, most_of_a_run / pixels);
  for (int round = 0; !watcher_.stop; ++round) {
    const int seeds = std::max(least_seeds, int(std::ceil(samples / most)));
    const double before = answer.seconds;
    Picture test = look(question, int(samples / seeds), seeds, answer);
    if (watcher_.stop) break;
    const auto channels = match_with_truth(test, truth, seeds);
    rounds_.back().variance = relative_variance(test, truth);
    Judgement judgement;
    judgement.tolerance.value = terms_.tolerance;
    judgement.false_alarm = false_alarm_ / std::exp2(round + 1);
    const bool is_guess = !test.file_variances.empty();  // noise, which tells little of one pixel
    judgement.max_outliers = {is_guess ? 1.0 : few_pixels, true};
    judgement.floor = Amount{0.0, true};  // what tells no noise has none
    const Comparison comparison = compare(
        test, truth, channels, {0, 0, test.image.width, test.image.height}, regions, judgement);
    note(comparison, terms_.tolerance, samples, answer);
    if (answer.mark == Mark::wrong) add_pictures(test, truth, answer);
    if (answer.mark != Mark::noisy || !renderer_.has_samples) return;
    // A round takes some time even without samples, which makes this careful.
    const double affordable = (terms_.seconds - answer.seconds) / (answer.seconds - before);
    const double factor = std::min({1.5 * comparison.samples_factor, 64.0, affordable});
    if (!(factor >= 1.5)) break;
    samples *= std::max(factor, 2.0);
  }
  if (watcher_.stop) {
    answer.text = "interrupted";
    return;
  }
  answer.noise_ratio = noise_against_ours(question, rounds_.back(), truth, watcher_.stop);
  if (answer.noise_ratio < many_times) return;
  answer.text += fmt::format("; its variance is {:.0f} times ours", answer.noise_ratio);
}

Answer Examiner::ask(const Question& question) {
  Answer answer{question.name, question.group, question.about, Mark::noisy};
  rounds_.clear();
  if (question.is_beyond_float && renderer_.is_single_precision) {
    answer.mark = Mark::cannot;
    answer.text = "asks for more than single precision";
    return answer;
  }
  try {
    ask_in_rounds(question, answer);
  } catch (const std::invalid_argument& error) {
    answer.mark = Mark::cannot;
    answer.text = error.what();
  } catch (const std::exception& error) {
    answer.mark = Mark::failed;
    answer.text = error.what();
  }
  return answer;
}

namespace {

Answer protocol(const std::string& name, const std::string& about) {
  return {name, "the program", about};
}

void decide(Answer& answer, bool is_right, const std::string& right, const std::string& wrong) {
  answer.mark = is_right ? Mark::right : Mark::wrong;
  answer.text = is_right ? right : wrong;
}

// The variance of the picture's mean by several pictures, over what the scatter of their pixels
// makes of it. It is 1 if pixels are independent, and more if neighbours err alike.
double noise_ratio(const std::vector<std::vector<float>>& pictures) {
  Replicates<double> means;
  std::vector<Replicates<double>> values(pictures[0].size());
  for (const std::vector<float>& picture : pictures) {
    double sum = 0.0;
    for (size_t i = 0; i < picture.size(); ++i) {
      values[i].add(double{picture[i]});
      sum += double{picture[i]};
    }
    means.add(sum / double(picture.size()));
  }
  double variance = 0.0;  // of the mean of grey pixels, whose channels err alike
  for (const Replicates<double>& value : values) variance += value.variance();
  variance *= 3.0 / double(values.size()) / double(values.size());
  return variance > 0.0 ? means.variance() / variance : 1.0;
}

}  // namespace

std::vector<Answer> Examiner::try_protocol(const fs::path& scene_file) {
  const Question question{"", "", "", read_scene(scene_file), scene_file, {}, {}};
  constexpr int samples = 64;
  std::vector<Answer> answers;
  Answer runs = protocol("runs",
                         "It reads a scene and leaves a picture of the scene's size, with "
                         "numbers in it, within its time limit.");
  try {
    std::vector<std::vector<float>> pictures;
    for (int i = 0; i < (renderer_.has_samples ? noise_seeds : 1) && !watcher_.stop; ++i) {
      const Reference drawn = draw(question, samples, 1, next_seed_++);
      if (watcher_.stop) return answers;
      runs.seconds += drawn.process_seconds;
      pictures.push_back(rgb_of(drawn.image));
    }
    decide(runs, true, fmt::format("{} pictures", pictures.size()), "");
    answers.push_back(runs);
    if (!renderer_.has_samples) return answers;

    const bool differ = are_seeds_heeded_ = pictures[0] != pictures[1];
    if (renderer_.has_seeds) {
      Answer seeds = protocol("seeds", "Pictures of two seeds differ.");
      decide(seeds, differ, "they differ", "two seeds gave the same picture");
      answers.push_back(seeds);
    }
    if (renderer_.promises_same_bits) {
      Answer bits = protocol("same bits",
                             "A seed gives the same picture again, and with one "
                             "thread as with many.");
      const int seed = next_seed_++;
      const auto many = rgb_of(draw(question, samples, 1, seed).image);
      const auto one = rgb_of(draw(question, samples, 1, seed, 1).image);
      decide(bits, many == one && !many.empty(), "they are", "they are not, though promised");
      answers.push_back(bits);
    }
    if (differ) {
      // Of 8 pictures: chi-square / 7 is above that once in ten thousand times.
      constexpr double too_much = 4.3;
      const double ratio = noise_ratio(pictures);
      Answer noise = protocol("honest noise",
                              "Pixels err independently: the mean of a picture scatters as its "
                              "pixels' scatter says.\nIf not, neighbours share random numbers.");
      is_scatter_honest_ = ratio < too_much;
      decide(noise, is_scatter_honest_,
             fmt::format("the mean varies {} times as much as its pixels say", rounded(ratio, 2)),
             fmt::format("the mean's variance is {} times that", rounded(ratio, 2)));
      answers.push_back(noise);
    }
  } catch (const std::exception& error) {
    runs.mark = Mark::failed;
    runs.text = error.what();
    answers.push_back(runs);
  }
  return answers;
}

}  // namespace plumb::cli
