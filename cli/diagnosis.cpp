// SPDX-License-Identifier: Apache-2.0

#include "cli/diagnosis.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "cli/film_image.h"
#include "cli/names.h"
#include "cli/scene_options.h"
#include "compare/sums.h"
#include "images/relative_error.h"
#include "renderer/render.h"

namespace plumb::cli {
namespace {

constexpr double false_alarm = 1e-3;
constexpr uint32_t usual_seed = 0x706c6d62;  // hardly anybody's

// Samples of all pixels of the reference, some seconds; but not more than 1024 per pixel.
constexpr int64_t affordable_samples = int64_t{1} << 25;

// The first look takes a part of the reference's samples; the best
// suspects get more in two steps, and as many as the reference what is claimed.
constexpr int64_t first_part = 64, second_part = 16, last_part = 4;
constexpr size_t kept_first = 6, kept_second = 3, kept_numbers = 3;

// Suspects whose squares are above the best one's by so many of their standard deviations are out.
constexpr double out = 5.0;

// Samples of all pixels that the first look takes at least, if that is not too many for each.
constexpr int64_t first_look = int64_t{1} << 19;

// A second thing is looked for where the first explains so much.
constexpr double worth_a_pair = 0.1;

// If that leaves the most doubt, a picture that looks right is held against one of so many times
// the samples.
constexpr int64_t times_more = 4;

struct Stopped {};

// Filters, unless they are sampled, and what works like one.
bool may_share_noise(Fault fault) {
  constexpr Fault those[] = {Fault::gaussian_filter, Fault::blackman_harris_filter,
                             Fault::mitchell_filter, Fault::blurred,
                             Fault::smeared,         Fault::denoised};
  return std::ranges::find(those, fault) != std::end(those);
}

bool is_drawn(const Planting& p) { return description(p.fault).site != FaultSite::picture; }

Picture model_picture(const Film& film) { return to_picture("reference", film); }

double total_noise(const Picture& picture) {
  double sum = 0.0;
  for (size_t i = 0; i < picture.image.pixel(0, picture.image.height); ++i) {
    for (size_t c = 0; c < picture.averaged; ++c) sum += picture.variance(i, c);
  }
  return sum;
}

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

// Each row of the table, with its usual number.
std::vector<Suspect> all_suspects(const Scene& scene) {
  const bool has_glass = std::ranges::any_of(
      scene.shapes, [](const Shape& shape) { return shape.bsdf.kind == Bsdf::Kind::dielectric; });
  const auto samples_lamps = [](Fault fault) {
    return fault == Fault::emitter_cosine || fault == Fault::inverse_pi ||
           fault == Fault::half_lamp_area || fault == Fault::inverse_square;
  };
  std::vector<Suspect> suspects;
  for (const FaultDescription& row : faults()) {
    if (row.is_of_glass && !has_glass) continue;
    suspects.push_back({{{row.fault}}});
    if (samples_lamps(row.fault)) suspects.push_back({{{row.fault}}, false});
  }
  return suspects;
}

// Nothing if they exclude each other.
std::optional<Suspect> both(const Suspect& a, const Suspect& b) {
  Suspect sum{a.plantings, a.has_mis && b.has_mis};
  sum.plantings.insert(sum.plantings.end(), b.plantings.begin(), b.plantings.end());
  std::ranges::sort(sum.plantings, {}, &Planting::fault);
  const auto of_integrator = [](const Planting& p) {
    return description(p.fault).site == FaultSite::integrator;
  };
  const bool is_twice =
      std::ranges::adjacent_find(sum.plantings, {}, &Planting::fault) != sum.plantings.end();
  if (is_twice || std::ranges::count_if(sum.plantings, of_integrator) > 1) return {};
  return sum;
}

// Whether a has what b has, and more.
bool adds_to(const Suspect& a, const Suspect& b) {
  return a.plantings.size() > b.plantings.size() &&
         std::ranges::includes(a.plantings, b.plantings, {}, &Planting::fault, &Planting::fault);
}

bool have_same_faults(const Suspect& a, const Suspect& b) {
  return std::ranges::equal(a.plantings, b.plantings, {}, &Planting::fault, &Planting::fault);
}

class Search {
 public:
  Search(const Scene& scene, Picture& test, const std::function<void(const std::string&)>& show,
         const std::atomic<bool>& stop)
      : scene_(scene), test_(test), show_(show), stop_(stop) {
    scene_.camera.width = test.image.width;
    scene_.camera.height = test.image.height;
    const auto pixels = static_cast<uint64_t>(test.image.pixel(0, test.image.height));
    samples_ = std::clamp<int64_t>(
        static_cast<int64_t>(std::bit_floor(uint64_t{affordable_samples} / pixels)), 64, 1024);
    values_ = 3.0 * static_cast<double>(pixels);
    settings_.bounces = scene.request.bounces;
    settings_.precision = fitting_precision(scene);
    settings_.seed = usual_seed + (test.image.provenance.seed == int{usual_seed} ? 2 : 0);
  }

  Diagnosis run(double tolerance) {
    RegionMask mask = region_mask(scene_, RegionKind::side);
    regions_ = {std::move(mask.names), std::move(mask.regions)};
    Settings other = settings_;
    ++other.seed;
    Diagnosis result{.reference = Film(scene_.camera.width, scene_.camera.height)};
    reference_ = &result.reference;
    Picture healthy;
    by_neighbours_ = false;
    for (const int64_t samples : {samples_, times_more * samples_}) {
      draw(scene_, other, samples, "reference", result.reference);
      healthy = matched(result.reference);
      if (samples == samples_) by_neighbours_ = !test_.knows_noise();
      if (by_neighbours_) tell_noise_by_neighbours(test_, healthy);
      result.healthy = agreement(test_, healthy, regions_, false_alarm / 2.0, by_neighbours_);
      const bool is_enough = result.healthy.is_refuted || result.healthy.within <= tolerance;
      if (is_enough || total_noise(test_) > total_noise(healthy)) break;
    }
    result.shared_noise = shared_noise(test_, healthy);
    if (!result.healthy.is_refuted) return result;
    yardstick_.emplace(test_, healthy);
    choose_side(healthy);
    result.suspects = look_for(all_suspects(scene_));
    if (result.suspects.empty()) return result;
    const bool is_explained = !result.suspects.front().agreement.is_refuted;
    if (!is_explained && result.suspects.front().explained > worth_a_pair) {
      Suspect first = result.suspects.front();
      for (Planting& p : first.plantings) {  // whose numbers stay
        if (const auto& numbers = description(p.fault).numbers; !numbers.empty()) {
          p.number = p.number.value_or(numbers.front());
        }
      }
      std::vector<Suspect> pairs;
      for (const Suspect& second : all_suspects(scene_)) {
        const auto pair = both(first, second);
        if (pair && std::ranges::count(idle_, second.plantings[0].fault) == 0) {
          pairs.push_back(*pair);
        }
      }
      for (Suspect& pair : look_for(std::move(pairs))) result.suspects.push_back(std::move(pair));
      rank(result.suspects);
    }
    Suspect& best = result.suspects.front();
    refine(best, tolerance);
    if (!best.agreement.is_refuted) result.shared_noise = shared_noise(test_, matched(*best.film));
    result.tried = tried_;
    return result;
  }

 private:
  // Adds what the film lacks of the samples.
  void draw(const Scene& scene, const Settings& settings, int64_t samples, const std::string& what,
            Film& film) {
    const auto show = [&](const Progress& progress) {
      show_(fmt::format("{}: {} of {} spp", what, progress.samples_per_pixel, samples));
    };
    render(scene, settings, {.samples = {film.samples_per_pixel(), samples}}, film, show, &stop_);
    if (stop_) throw Stopped();
  }

  // As the picture's reference.
  Picture matched(const Film& film) {
    Picture model = model_picture(film);
    match(test_, model, {"R", "G", "B"}, true);
    return model;
  }

  // Whose noise is not known where random numbers repeat themselves in all replicates.
  Picture model_of(const Suspect& suspect, const Film& film) {
    Picture model = matched(film);
    const auto repeats = [](const Planting& p) {
      return p.fault == Fault::webgl_random || p.fault == Fault::webgl_demo;
    };
    if (std::ranges::any_of(suspect.plantings, repeats)) {
      std::ranges::fill(model.variance_channels, std::nullopt);
    }
    return model;
  }

  const Film& base(const Settings& settings, int64_t samples) {
    const auto key = std::pair(settings.method, samples);
    if (!bases_.contains(key)) {
      Settings healthy = settings_;
      healthy.method = settings.method;
      Film film(scene_.camera.width, scene_.camera.height);
      draw(scene_, healthy, samples, "reference", film);
      bases_.emplace(key, std::move(film));
    }
    return bases_.at(key);
  }

  // What is rendered for a suspect; nothing if that changes no pixel. The samples are those of the
  // base, so that only what the suspect changes is noisy. It is remembered for the next call.
  const std::optional<Film>& drawn(const Suspect& suspect, int64_t samples) {
    Suspect what = suspect;
    std::erase_if(what.plantings, [](const Planting& p) { return !is_drawn(p); });
    const std::string key = fmt::format("{} {} {}", name_of(what), samples, what.has_mis);
    if (key == last_key_) return last_drawn_;
    last_key_.clear();
    last_drawn_ = *reference_;
    if (!what.plantings.empty()) {
      Scene scene = scene_;
      Settings settings = settings_;
      if (!what.has_mis) settings.method = Method::nee;
      for (const Planting& p : what.plantings) plant(p.fault, scene, settings, p.number);
      if (settings.tracer != nullptr) settings.precision = Precision::float32;
      Film film(scene.camera.width, scene.camera.height);
      draw(scene, settings, samples, name_of(suspect), film);
      for (const Planting& p : what.plantings) {
        film = spoil(p.fault, std::move(film), scene, p.number);
      }
      settings.method = what.has_mis ? Method::mis : Method::nee;
      const Film& healthy = base(settings, samples);
      if (film.replicate_mean(0) == healthy.replicate_mean(0)) {
        last_drawn_.reset();
      } else {
        last_drawn_ = steadied(*reference_, std::move(film), healthy);
      }
    }
    last_key_ = key;
    return last_drawn_;
  }

  // Judges a suspect by so many samples; returns whether it changes anything. An exposure that
  // comes last gets the best number.
  bool judge(Suspect& suspect, int64_t samples) {
    const std::optional<Film>& film = drawn(suspect, samples);
    if (!film) return false;
    Film model = *film;
    for (Planting& p : suspect.plantings) {
      if (is_drawn(p)) continue;
      if (p.fault == Fault::exposure && &p == &suspect.plantings.back()) {
        const auto factor = yardstick_->best_factor(test_, matched(model));
        p.number = factor.value;
        suspect.number_error = factor.error;
      }
      model = spoil(p.fault, std::move(model), scene_, p.number);
    }
    const Picture& picture = last_model_ = model_of(suspect, model);
    const double penalty = penalty_of(suspect);
    suspect.blocks = yardstick_->squares(test_, picture, block_side) + penalty;
    suspect.pixels = yardstick_->squares(test_, picture, 1) + penalty;
    suspect.blocks_error = deviation(block_side, picture);
    suspect.pixels_error = deviation(1, picture);
    const double left = (side_ == 1 ? suspect.pixels : suspect.blocks) - penalty - noise_;
    suspect.explained = std::clamp(1.0 - left / all_, 0.0, 1.0);
    suspect.film = std::move(model);
    return true;
  }

  // Blocks or pixels, whichever shows the difference more clearly: a slow change is lost in the
  // noise of pixels, and an edge in the middle of a block.
  void choose_side(const Picture& healthy) {
    double clearest = 0.0;
    for (const int side : {block_side, 1}) {
      const double noise = by_neighbours_ ? 0.0 : yardstick_->noise(test_, side);
      const double all = yardstick_->squares(test_, healthy, side) - noise;
      const double clear = all / deviation(side);
      if (clear <= clearest) continue;
      clearest = clear;
      side_ = side;
      noise_ = noise;
      all_ = all;
    }
  }

  // Of squares that are noise.
  double deviation(int side) const { return std::sqrt(2.0 * values_) / side; }

  // The same with the noise of a model.
  double deviation(int side, const Picture& model) const {
    return deviation(side) * (1.0 + yardstick_->noise(model, side) * side * side / values_);
  }

  double penalty_of(const Suspect& suspect) const {
    double choices = 0.0;
    for (const Planting& p : suspect.plantings) {
      choices += description(p.fault).numbers.empty() ? 1.0 : 2.0;
    }
    return choices * std::log(values_);
  }

  // The best suspects, with films, the likeliest first.
  std::vector<Suspect> look_for(std::vector<Suspect> suspects) {
    const int64_t pixels = int64_t{test_.image.width} * test_.image.height;
    const int64_t last = samples_ / last_part;
    const int64_t first = std::clamp(first_look / pixels, samples_ / first_part, last);
    const int64_t second = std::max(first, samples_ / second_part);
    std::vector<Suspect> seen;
    for (const Suspect& suspect : suspects) {
      if (!look(suspect, first, seen)) {
        idle_.push_back(suspect.plantings.front().fault);
        continue;
      }
      for (size_t i = 0; i < suspect.plantings.size(); ++i) {
        if (!suspect.plantings[i].number) try_numbers(suspect, i, first, seen);
      }
    }
    if (seen.empty()) return seen;
    seen = best(std::move(seen), kept_first);
    judge_all(seen, second);
    seen = best(std::move(seen), kept_second);
    fit_numbers(*std::ranges::min_element(seen, {}, measure()), second);
    judge_all(seen, last);
    for (Suspect& suspect : seen) agree(suspect);
    rank(seen);
    return seen;
  }

  double Suspect::*measure() const { return side_ == 1 ? &Suspect::pixels : &Suspect::blocks; }

  void judge_all(std::vector<Suspect>& suspects, int64_t samples) {
    for (Suspect& suspect : suspects) judge(suspect, samples);
  }

  bool look(Suspect suspect, int64_t samples, std::vector<Suspect>& seen) {
    ++tried_;
    if (!judge(suspect, samples)) return false;
    add_exposed(suspect, seen);
    suspect.film.reset();
    seen.push_back(std::move(suspect));
    return true;
  }

  // Of the planting with this index: on from the usual one to both sides as long as blocks become
  // better, if they are ordered; else all.
  void try_numbers(const Suspect& usual, size_t index, int64_t samples,
                   std::vector<Suspect>& seen) {
    const FaultDescription& row = description(usual.plantings[index].fault);
    if (row.numbers.size() < 2 || row.fault == Fault::exposure) return;
    const auto blocks_with = [&](double number) {
      Suspect other = usual;
      other.plantings[index].number = number;
      if (!look(std::move(other), samples, seen)) return std::numeric_limits<double>::infinity();
      return seen.back().blocks;
    };
    const double at_usual = seen.back().blocks;
    std::vector<double> numbers = row.numbers;
    if (!row.has_order()) {
      for (size_t i = 1; i < numbers.size() && std::isfinite(blocks_with(numbers[i]));) ++i;
      return;
    }
    std::ranges::sort(numbers);
    const auto start = std::ranges::find(numbers, row.numbers.front()) - numbers.begin();
    for (const int step : {-1, 1}) {
      double before = at_usual;
      for (auto i = start + step; i >= 0 && i < std::ssize(numbers); i += step) {
        const double blocks = blocks_with(numbers[static_cast<size_t>(i)]);
        if (!(blocks < before)) break;
        before = blocks;
      }
    }
  }

  // The same as was judged last with another exposure, if that is better by far for blocks.
  void add_exposed(const Suspect& suspect, std::vector<Suspect>& seen) {
    auto exposed = both(suspect, {{{Fault::exposure}}});
    if (!exposed || exposed->plantings.back().fault != Fault::exposure) return;
    const auto factor = yardstick_->best_factor(test_, last_model_);
    exposed->plantings.back().number = factor.value;
    exposed->blocks = factor.squares + penalty_of(*exposed);
    exposed->pixels = std::numeric_limits<double>::infinity();  // not known yet
    ++tried_;
    if (exposed->blocks < suspect.blocks) seen.push_back(*exposed);
  }

  // By blocks and by pixels, so many of each, with few numbers of the same faults, and of what is
  // out at most one. What adds to another one has to be better by far.
  std::vector<Suspect> best(std::vector<Suspect> suspects, size_t count) const {
    std::vector<Suspect> those;
    for (const int side : {block_side, 1}) {
      const auto by = side == 1 ? &Suspect::pixels : &Suspect::blocks;
      const auto error = side == 1 ? &Suspect::pixels_error : &Suspect::blocks_error;
      std::ranges::sort(suspects, {}, by);
      size_t taken = 0;
      for (const Suspect& suspect : suspects) {
        const bool is_out =
            suspect.*by - out * suspect.*error > suspects.front().*by + out * deviation(side);
        if (taken == count || (taken > 1 && is_out)) break;
        const auto is_like = [&](const Suspect& other) { return have_same_faults(suspect, other); };
        const auto is_known = [&](const Suspect& other) {
          return name_of(suspect) == name_of(other);
        };
        const auto suffices = [&](const Suspect& other) {
          return adds_to(suspect, other) && other.*by - out * other.*error < suspect.*by;
        };
        if (std::ranges::any_of(suspects, suffices)) continue;
        const bool is_new = std::ranges::none_of(those, is_known);
        if (is_new && std::ranges::count_if(those, is_like) >= std::ptrdiff_t{kept_numbers}) {
          continue;
        }
        ++taken;
        if (is_new) those.push_back(suspect);
      }
    }
    return those;
  }

  // What agrees first, then by what is left. Of suspects that differ in their numbers alone the
  // best one stays, and nothing that adds to one that agrees.
  void rank(std::vector<Suspect>& suspects) const {
    std::ranges::stable_sort(suspects, {}, [by = measure()](const Suspect& s) {
      return std::pair(s.agreement.is_refuted, s.*by);
    });
    std::vector<Suspect> those;
    for (Suspect& suspect : suspects) {
      const auto makes_idle = [&](const Suspect& better) {
        return have_same_faults(suspect, better) ||
               (!better.agreement.is_refuted && adds_to(suspect, better));
      };
      if (std::ranges::none_of(those, makes_idle)) those.push_back(std::move(suspect));
    }
    suspects = std::move(those);
  }

  // Finds the number of each continuous fault between those that were tried.
  void fit_numbers(Suspect& suspect, int64_t samples) {
    for (size_t i = 0; i < suspect.plantings.size(); ++i) {
      const FaultDescription& row = description(suspect.plantings[i].fault);
      const bool follows = row.fault == Fault::exposure && i + 1 == suspect.plantings.size();
      if (!row.is_continuous || follows) continue;
      std::vector<double> numbers = row.numbers;
      std::ranges::sort(numbers);
      numbers.insert(numbers.begin(), numbers.front() * numbers.front() / numbers[1]);
      numbers.push_back(numbers.back() * numbers.back() / numbers[numbers.size() - 2]);
      const double start = suspect.plantings[i].number.value_or(row.numbers.front());
      const auto at = std::clamp(std::ranges::lower_bound(numbers, start) - numbers.begin(),
                                 std::ptrdiff_t{1}, std::ssize(numbers) - 2);
      const auto left = [&](double log) {
        suspect.plantings[i].number = std::exp(log);
        judge(suspect, samples);
        return suspect.*measure();
      };
      constexpr int bits = 10;
      std::uintmax_t steps = 12;
      const auto found = boost::math::tools::brent_find_minima(
          left, std::log(numbers[size_t(at) - 1]), std::log(numbers[size_t(at) + 1]), bits, steps);
      suspect.plantings[i].number = std::exp(found.first);
    }
  }

  void agree(Suspect& suspect) {
    const Picture model = model_of(suspect, *suspect.film);
    const bool shares_noise =
        std::ranges::any_of(suspect.plantings, may_share_noise, &Planting::fault) &&
        shared_noise(test_, model) > much_shared_noise;
    suspect.agreement = agreement(test_, model, regions_,
                                  false_alarm / static_cast<double>(std::max<size_t>(tried_, 1)),
                                  by_neighbours_, shares_noise ? block_side : 1);
  }

  // Renders what agrees as well as the reference, if its noise leaves the most doubt.
  void refine(Suspect& suspect, double tolerance) {
    if (suspect.agreement.is_refuted || suspect.agreement.within <= tolerance) return;
    if (total_noise(test_) > total_noise(matched(*suspect.film))) return;
    judge(suspect, samples_);
    agree(suspect);
  }

  Scene scene_;
  Picture& test_;
  const std::function<void(const std::string&)>& show_;
  const std::atomic<bool>& stop_;
  Settings settings_{.bounces = {}};
  int64_t samples_;
  Regions regions_;
  bool by_neighbours_ = false;
  const Film* reference_ = nullptr;
  std::optional<Yardstick> yardstick_;
  double values_ = 0.0;  // how many the picture has
  int side_ = 1;         // of what is measured
  // The squared difference of picture and reference without the noise of either, and the noise.
  double all_ = 0.0, noise_ = 0.0;
  size_t tried_ = 0;
  std::vector<Fault> idle_;  // which change nothing in this scene
  std::map<std::pair<Method, int64_t>, Film> bases_;
  Picture last_model_;  // that was judged
  std::string last_key_;
  std::optional<Film> last_drawn_;
};

// A number, or the one of those usual ones that it may be.
std::string number_text(double number, const std::vector<double>& usual, double error) {
  constexpr double pi = std::numbers::pi;
  for (const double known : usual) {
    if (std::abs(number / known - 1.0) > std::max(1e-3, 3.0 * error / number)) continue;
    for (const auto& [word, value] :
         {std::pair("pi", pi), {"1/pi", 1 / pi}, {"4/pi", 4 / pi}, {"pi/4", pi / 4}}) {
      if (known == value) return fmt::format("{:.4g}, {}", number, word);
    }
  }
  return std::isfinite(number) ? fmt::format("{:.4g}", number) : "all";
}

}  // namespace

std::string name_of(const Suspect& suspect) {
  std::string name;
  for (const auto& [fault, number] : suspect.plantings) {
    const FaultDescription& row = description(fault);
    name += fmt::format("{}`{}`", name.empty() ? "" : " and ", row.name);
    const bool is_told = number && (fault == Fault::exposure || *number != row.numbers.front());
    if (is_told) name += " (" + number_text(*number, row.numbers, suspect.number_error) + ")";
  }
  return name + (suspect.has_mis ? "" : " without MIS");
}

std::optional<Diagnosis> diagnose(const Scene& scene, Picture& test, double tolerance,
                                  const std::function<void(const std::string&)>& show,
                                  const std::atomic<bool>& stop) {
  try {
    return Search(scene, test, show, stop).run(tolerance);
  } catch (const Stopped&) {
    return {};
  }
}

}  // namespace plumb::cli
