// SPDX-License-Identifier: Apache-2.0

#include "cli/suspect_search.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>

#include "cli/film_image.h"
#include "compare/sums.h"

namespace plumb::cli {
namespace {

// The first look takes a part of the reference's samples; the best
// suspects get more in two steps, and as many as the reference what is claimed.
constexpr int64_t first_part = 64, second_part = 16, last_part = 4;
constexpr size_t kept_first = 6, kept_second = 3, kept_numbers = 3;

// The part of a false alarm's chance with which few samples may refute what more would not.
constexpr double early_part = 0.01;

// Samples of all pixels that the first look takes at least, if that is not too many for each.
constexpr int64_t first_look = int64_t{1} << 19;

// Calls `use` with each number below `count`, two at once: while one film is judged, which takes
// one thread, another one is drawn. More would hold more films.
template <typename Use>
void for_each_at_once(size_t count, Use use) {
  std::atomic<size_t> next = 0;
  tbb::parallel_for(0, 2, [&](int) {
    for (size_t i = next++; i < count; i = next++) use(i);
  });
}

}  // namespace

SuspectSearch::SuspectSearch(SuspectPictures& pictures, const Picture& test, const Picture& healthy,
                             const Regions& regions, bool by_neighbours, int64_t samples)
    : pictures_(pictures),
      test_(test),
      healthy_(healthy),
      regions_(regions),
      score_(test, healthy, by_neighbours),
      by_neighbours_(by_neighbours),
      samples_(samples) {}

Picture SuspectSearch::picture_of(const Film& film) const {
  Picture model = to_picture("reference", film);
  model.value_channels = healthy_.value_channels;
  model.variance_channels = healthy_.variance_channels;
  model.hits.assign(healthy_.hits.size(), 0.0);  // it is no picture of single hits, but a sum
  model.averaged = healthy_.averaged;
  return model;
}

Picture SuspectSearch::model_of(const Suspect& suspect, const Film& film) const {
  Picture model = picture_of(film);
  if (repeats_noise(suspect)) std::ranges::fill(model.variance_channels, std::nullopt);
  return model;
}

// Judges a suspect by so many samples; returns its picture, or nothing if it changes nothing. An
// exposure that comes last gets the best number.
std::optional<Picture> SuspectSearch::judge(Suspect& suspect, int64_t samples) const {
  suspect.film = pictures_.of(suspect, samples);
  if (!suspect.film) return {};
  for (Planting& p : suspect.plantings) {
    if (is_drawn(p)) continue;
    if (p.fault == Fault::exposure && &p == &suspect.plantings.back()) {
      const auto factor = score_.best_factor(picture_of(*suspect.film));
      p.number = factor.value;
      suspect.number_error = factor.error;
    }
    suspect.film = std::make_shared<const Film>(
        spoil(p.fault, *suspect.film, pictures_.scene(), pictures_.settings(), p.number));
  }
  Picture model = model_of(suspect, *suspect.film);
  score_.measure(suspect, model);
  return model;
}

void SuspectSearch::judge_all(std::vector<Suspect>& suspects, int64_t samples) {
  pictures_.prepare(suspects, samples);
  for_each_at_once(suspects.size(), [&](size_t i) { judge(suspects[i], samples); });
}

std::vector<Suspect> SuspectSearch::look_for(std::vector<Suspect> suspects) {
  const int64_t pixels = int64_t{test_.image.width} * test_.image.height;
  const int64_t last = samples_ / last_part;
  const int64_t first = std::clamp(first_look / pixels, samples_ / first_part, last);
  const int64_t second = std::max(first, samples_ / second_part);
  std::vector<Seen> looks(suspects.size());
  pictures_.prepare(suspects, first);
  for_each_at_once(suspects.size(), [&](size_t i) { looks[i] = look_at(suspects[i], first); });
  std::vector<Suspect> seen;
  for (size_t i = 0; i < looks.size(); ++i) {
    tried_ += looks[i].tried;
    if (looks[i].suspects.empty()) idle_.push_back(suspects[i].plantings.front().fault);
    std::ranges::move(looks[i].suspects, std::back_inserter(seen));
  }
  if (seen.empty()) return seen;
  seen = best(std::move(seen), kept_first);
  judge_all(seen, second);
  seen = best(std::move(seen), kept_second);
  fit_numbers(*std::ranges::min_element(seen, {}, score_.what_counts()), second);
  agree_all(seen, second, last);
  rank(seen);
  return seen;
}

// Of suspects that were judged by a few samples. What these refute needs no more, but for the
// likeliest one, whose rest is told.
void SuspectSearch::agree_all(std::vector<Suspect>& suspects, int64_t few, int64_t samples) {
  const auto likeliest = std::ranges::min_element(suspects, {}, score_.what_counts());
  std::iter_swap(suspects.begin(), likeliest);
  pictures_.prepare(suspects, samples);
  for_each_at_once(suspects.size(), [&](size_t i) {
    const bool is_clear = i > 0 && samples > few && !repeats_noise(suspects[i]);
    if (is_clear) agree(suspects[i], early_part);
    if (is_clear && suspects[i].agreement.is_refuted) return;
    judge(suspects[i], samples);
    agree(suspects[i]);
  });
}

SuspectSearch::Seen SuspectSearch::look_at(const Suspect& suspect, int64_t samples) const {
  Seen seen;
  if (!look(suspect, samples, seen)) return seen;
  for (size_t i = 0; i < suspect.plantings.size(); ++i) {
    if (!suspect.plantings[i].number) try_numbers(suspect, i, samples, seen);
  }
  return seen;
}

bool SuspectSearch::look(Suspect suspect, int64_t samples, Seen& seen) const {
  ++seen.tried;
  const std::optional<Picture> model = judge(suspect, samples);
  if (!model) return false;
  add_exposed(suspect, *model, seen);
  suspect.film.reset();
  seen.suspects.push_back(std::move(suspect));
  return true;
}

// Of the planting with this index: on from the usual one to both sides as long as blocks become
// better, if they are ordered; else all.
void SuspectSearch::try_numbers(const Suspect& usual, size_t index, int64_t samples,
                                Seen& seen) const {
  const FaultDescription& row = description(usual.plantings[index].fault);
  if (row.numbers.size() < 2 || row.fault == Fault::exposure) return;
  const auto blocks_with = [&](double number) {
    Suspect other = usual;
    other.plantings[index].number = number;
    if (!look(std::move(other), samples, seen)) return std::numeric_limits<double>::infinity();
    return seen.suspects.back().blocks;
  };
  const double at_usual = seen.suspects.back().blocks;
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

// The same with another exposure, if that is better by far for blocks.
void SuspectSearch::add_exposed(const Suspect& suspect, const Picture& model, Seen& seen) const {
  auto exposed = both(suspect, {{{Fault::exposure}}});
  if (!exposed || exposed->plantings.back().fault != Fault::exposure) return;
  const auto factor = score_.best_factor(model);
  exposed->plantings.back().number = factor.value;
  exposed->blocks = factor.squares + score_.penalty_of(*exposed);
  exposed->pixels = std::numeric_limits<double>::infinity();  // not known yet
  ++seen.tried;
  if (exposed->blocks < suspect.blocks) {
    exposed->film.reset();
    seen.suspects.push_back(*exposed);
  }
}

// By blocks and by pixels, so many of each, with few numbers of the same faults, and of what is out
// at most one. What adds to another one has to be better by far.
std::vector<Suspect> SuspectSearch::best(std::vector<Suspect> suspects, size_t count) const {
  std::vector<Suspect> those;
  for (const int side : {block_side, 1}) {
    const auto by = side == 1 ? &Suspect::pixels : &Suspect::blocks;
    const auto error = side == 1 ? &Suspect::pixels_error : &Suspect::blocks_error;
    std::ranges::sort(suspects, {}, by);
    size_t taken = 0;
    for (const Suspect& suspect : suspects) {
      const bool is_out = suspect.*by - clearly * suspect.*error >
                          suspects.front().*by + clearly * score_.deviation(side);
      if (taken == count || (taken > 1 && is_out)) break;
      const auto is_like = [&](const Suspect& other) { return have_same_faults(suspect, other); };
      const auto is_known = [&](const Suspect& other) {
        return name_of(suspect) == name_of(other);
      };
      const auto suffices = [&](const Suspect& other) {
        return adds_to(suspect, other) && other.*by - clearly * other.*error < suspect.*by;
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

void SuspectSearch::rank(std::vector<Suspect>& suspects) const {
  const auto by = score_.what_counts();
  const auto error = by == &Suspect::pixels ? &Suspect::pixels_error : &Suspect::blocks_error;
  refute_what_is_worse(suspects, by, error);
  std::ranges::stable_sort(
      suspects, {}, [by](const Suspect& s) { return std::pair(s.agreement.is_refuted, s.*by); });
  std::vector<Suspect> those;
  for (const Suspect& suspect : suspects) {
    const auto suffices = [&](const Suspect& other) {
      return !other.agreement.is_refuted && adds_to(suspect, other) &&
             other.*by - clearly * other.*error < suspect.*by;
    };
    const auto is_like = [&](const Suspect& better) { return have_same_faults(suspect, better); };
    if (std::ranges::none_of(suspects, suffices) && std::ranges::none_of(those, is_like)) {
      those.push_back(suspect);
    }
  }
  suspects = std::move(those);
}

// Finds the number of each continuous fault between those that were tried.
void SuspectSearch::fit_numbers(Suspect& suspect, int64_t samples) {
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
      return suspect.*score_.what_counts();
    };
    constexpr int bits = 10;
    std::uintmax_t steps = 12;
    const double before = left(std::log(start));
    const auto found = boost::math::tools::brent_find_minima(
        left, std::log(numbers[size_t(at) - 1]), std::log(numbers[size_t(at) + 1]), bits, steps);
    // What was tried is as a rule what was meant, and then no search comes nearer.
    suspect.plantings[i].number = found.second < before ? std::exp(found.first) : start;
  }
}

std::vector<Suspect> SuspectSearch::pairs_with(Suspect first) const {
  for (Planting& p : first.plantings) {  // whose numbers stay
    if (const auto& numbers = description(p.fault).numbers; !numbers.empty()) {
      p.number = p.number.value_or(numbers.front());
    }
  }
  std::vector<Suspect> pairs;
  for (const Suspect& second : all_suspects(pictures_.scene())) {
    const auto pair = both(first, second);
    if (pair && std::ranges::count(idle_, second.plantings[0].fault) == 0) pairs.push_back(*pair);
  }
  return pairs;
}

void SuspectSearch::agree(Suspect& suspect, double part) const {
  const Picture model = model_of(suspect, *suspect.film);
  const int most = std::min(test_.image.width, test_.image.height) / 4 / block_side * block_side;
  const int side = std::min(side_without_shared_noise(suspect), std::max(block_side, most));
  const bool shares_noise = side > 1 && shared_noise(test_, model).typical > much_shared_noise;
  const auto by_squares = [&](int cell) {
    const double chance = part * false_alarm / static_cast<double>(std::max<size_t>(tried_, 1));
    return agreement(test_, model, regions_, chance, by_neighbours_, cell);
  };
  suspect.agreement = by_squares(shares_noise ? side : 1);
  if (shares_noise && side > block_side) {
    // Narrow squares err alike, which margins of regions don't know; wide ones hold what errs
    // alike, which their own margins don't know, and none fits into a small region.
    const Agreement narrow = by_squares(block_side);
    suspect.agreement.is_refuted = suspect.agreement.is_refuted && narrow.is_refuted;
    suspect.agreement.within = std::max(suspect.agreement.within, narrow.within);
  }
}

double SuspectSearch::towards(const Suspect& suspect) const {
  return repeats_noise(suspect) ? 0.0 : score_.towards(healthy_, model_of(suspect, *suspect.film));
}

void SuspectSearch::examine(Suspect& suspect, int64_t samples) {
  pictures_.prepare({suspect}, samples);
  judge(suspect, samples);
  agree(suspect);
}

}  // namespace plumb::cli
