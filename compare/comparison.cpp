// SPDX-License-Identifier: Apache-2.0

#include "compare/comparison.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "compare/shared_samples.h"

namespace plumb {
namespace {

constexpr size_t findings_kept = 10;
constexpr int neighbourhood = 4;  // pixels to each side whose noise a pixel may share

// Below this part of the typical value relative amounts are as at it: the relative errors of 8-bit
// sRGB codes grow without bound from there on.
constexpr double dark = 0.1;
constexpr int64_t pixels_for_median = 1 << 16;  // are enough

// The test's variance over the reference's in the typical block, for one channel.
double noise_ratio(const Sums& sums, size_t channel) {
  std::vector<double> ratios;
  for (const Pool& block : sums.blocks_of(channel)) {
    if (block.test_variance > 0.0 && block.reference_variance > 0.0) {
      ratios.push_back(block.test_variance / block.reference_variance);
    }
  }
  if (!ratios.empty()) return median(ratios);
  return sums.image[channel].test_variance > 0.0 ? 1e12 : 1e-12;  // one is exact
}

Errors errors_of(const Pool& pool) {
  const double n = pool.pixels;
  Errors errors{pool.absolute / n, pool.squares / n, pool.relative / n, pool.symmetric / n};
  errors.bias_squared = std::pow((pool.test - pool.reference) / n, 2.0);
  errors.test_noise = pool.test_variance / n;
  errors.reference_noise = pool.reference_variance / n;
  return errors;
}

void find_extremes(const Picture& test, const Picture& reference, const Window& w, size_t channel,
                   Errors& errors) {
  for_each_pixel(w, [&](int x, int y) {
    const PixelPair pair = pixel_pair(test, reference, test.image.pixel(x, y), channel);
    errors.peak = std::max(errors.peak, pair.reference);
    if (std::abs(pair.difference()) <= errors.max) return;
    errors.max = std::abs(pair.difference());
    errors.x = x;
    errors.y = y;
    errors.max_test = pair.test;
    errors.max_reference = pair.reference;
  });
}

// Of several channels.
Errors mean(std::vector<Errors> channels, size_t averaged) {
  channels.resize(averaged);
  Errors result = *std::ranges::max_element(channels, {}, &Errors::max);
  result.peak = std::ranges::max(channels, {}, &Errors::peak).peak;
  for (const auto member : {&Errors::mae, &Errors::mse, &Errors::rel_mse, &Errors::smape,
                            &Errors::bias_squared, &Errors::test_noise, &Errors::reference_noise}) {
    result.*member = 0.0;
    for (const Errors& e : channels) {
      result.*member += e.*member / static_cast<double>(channels.size());
    }
  }
  return result;
}

bool is_among_clearest(const Finding& finding, const std::vector<Finding>& worst) {
  return worst.size() < findings_kept || finding.estimate.excess > worst.back().estimate.excess;
}

// Clearest first, and in reading order where that is equal.
void keep(Finding finding, std::vector<Finding>& worst) {
  const auto rank = [](const Finding& f) {
    return std::tuple(-f.estimate.excess, f.window.y, f.window.x);
  };
  worst.insert(std::ranges::upper_bound(worst, rank(finding), {}, rank), std::move(finding));
  if (worst.size() > findings_kept) worst.pop_back();
}

// The median over pixels of the mean of the channels' absolute values, without zeros if it would
// be 0.
double typical_value(const Picture& picture, const Window& w, const Regions& regions,
                     const std::vector<size_t>& channels) {
  const int64_t pixels = int64_t{w.width} * w.height;
  std::vector<double> values;
  for (int64_t i = 0; i < pixels; i += (pixels / pixels_for_median) | 1) {
    const size_t pixel = picture.image.pixel(w.x + int(i % w.width), w.y + int(i / w.width));
    if (!regions.hold(pixel)) continue;
    double sum = 0.0;
    for (const size_t c : channels) sum += std::abs(picture.value(pixel, c));
    values.push_back(sum / static_cast<double>(channels.size()));
  }
  if (const double typical = median(values); typical > 0.0) return typical;
  std::erase(values, 0.0);
  return median(values);
}

// The channels whose values are of one size: the averaged ones, or all of the same kind in a layer.
std::vector<size_t> companions(const std::vector<std::string>& channels, size_t averaged,
                               size_t channel) {
  std::vector<size_t> result;
  const std::string layer = layer_of(channels[channel]);
  for (size_t c = 0; c < channels.size() - 1; ++c) {
    const bool is_alike =
        channel < averaged || channel == channels.size() - 1
            ? c < averaged
            : c == channel ||
                  (c >= averaged && !layer.empty() && layer_of(channels[c]) == layer &&
                   kind_of(channels[c], channels) == kind_of(channels[channel], channels));
    if (is_alike) result.push_back(c);
  }
  return result;
}

class Judge {
 public:
  Judge(const Picture& test, const Picture& reference, const Regions& regions,
        const Judgement& judgement, const Sums& sums, Comparison& result)
      : test_(test),
        reference_(reference),
        regions_(regions),
        judgement_(judgement),
        pixels_(static_cast<int64_t>(sums.image.front().pixels)),
        result_(result) {
    for (size_t c = 0; c < sums.image.size(); ++c) {
      const bool is_all = c == test.channel_count();
      const int known =
          int{test.knows_noise(is_all ? 0 : c)} + int{reference.knows_noise(is_all ? 0 : c)};
      knows_noise_.push_back(result.is_paired || known == 2 || (known == 1 && judgement.floor));
      noise_ratios_.push_back(noise_ratio(sums, c));
      has_unit_scale_.push_back(kind_of(result.channels[c], result.channels) == ChannelKind::alpha);
      least_scales_.push_back(dark * typical_value(reference, result.window, regions,
                                                   companions(result.channels, test.averaged, c)));
      const Criterion image = criterion(c, sums.image[c].mean_reference(), Unit::image);
      result.floors.push_back(image.floor);
      result.tolerances.push_back(image.tolerance);
    }
    result.knows_noise = knows_noise_.back();
  }

  bool knows_any_noise() const { return std::ranges::count(knows_noise_, true) > 0; }

  // Judges averages; `locate` says where a unit is. Either gives all findings, or just notes what
  // differs.
  template <typename Locate>
  void judge_pools(Unit unit, const std::vector<Pool>& pools, Locate locate,
                   std::vector<Finding>* all) {
    if (pools.empty()) return;
    const size_t channels = noise_ratios_.size();
    Level level{.unit = unit};
    const double critical = critical_for(pools.size());
    std::vector<double> visible;
    size_t last = pools.size();  // unit that differs
    for (size_t i = 0; i < pools.size(); ++i) {
      const size_t c = i % channels;
      level.units += c == 0 && pools[i].pixels > 0.0;
      if (pools[i].pixels == 0.0 || (unit == Unit::block && !knows_noise_[c])) continue;
      const double own = pools[i].mean_reference();
      const Criterion judge = criterion(c, own, unit);
      Finding finding{"", {}, result_.channels[c], judge.estimate(pools[i], critical)};
      finding.scale = scale(c, own);
      locate(static_cast<int>(i / channels), finding);
      if (is_of_picture(c) && scale(c, own) > 0.0) {
        visible.push_back(finding.estimate.visible / scale(c, own));
      }
      if (all != nullptr) {
        result_.samples_factor =
            std::max(result_.samples_factor, judge.samples_factor(finding.estimate));
        finding.estimate.confidence = known_confidence(c, pools[i]);
        all->push_back(finding);
      }
      if (finding.estimate.verdict != Verdict::different) continue;
      if (all == nullptr && is_among_clearest(finding, level.worst)) {
        finding.estimate.confidence = known_confidence(c, pools[i]);
      }
      level.different += std::exchange(last, i / channels) != i / channels;
      keep(finding, level.worst);
    }
    level.visible = median(visible);
    result_.levels.push_back(level);
  }

  // Judges each pixel.
  void judge_pixels(const Window& w) {
    Level level{.unit = Unit::pixel, .units = pixels_};
    const double critical = critical_for(static_cast<size_t>(pixels_) * test_.channel_count());
    std::vector<double> visible;
    std::mutex mutex;
    const auto judge_row = [&](int y) {
      std::vector<Finding> worst;
      int64_t different = 0, beyond_limit = 0;
      for (int x = w.x; x < w.x + w.width; ++x) {
        const auto finding = judge_pixel(x, y, critical);
        different += finding.has_value();
        beyond_limit += finding && finding->is_beyond_limit;
        if (finding && is_among_clearest(*finding, worst)) keep(*finding, worst);
      }
      const std::lock_guard lock(mutex);
      level.different += different;
      level.beyond_limit += beyond_limit;
      for (const Finding& finding : worst) keep(finding, level.worst);
      for (size_t c = 0; c < test_.averaged; ++c) {
        const int x = w.x + w.width / 2;
        if (!regions_.hold(test_.image.pixel(x, y))) break;
        const double own = pair_at(x, y, c).reference;
        const Criterion judge = criterion(c, own, Unit::pixel);
        const double noise = margin(x, y, c, critical);
        if (scale(c, own) > 0.0) {
          visible.push_back((judge.tolerance + judge.floor + noise) / scale(c, own));
        }
      }
    };
    tbb::parallel_for(w.y, w.y + w.height, judge_row);
    level.visible = median(visible);
    result_.levels.push_back(level);
  }

  void find_fireflies(const Sums& sums, const Window& window) {
    const size_t all = noise_ratios_.size() - 1;
    const std::vector<Pool> blocks = sums.blocks_of(all);
    std::vector<double> typical;
    for (const Pool& block : blocks) {
      if (block.pixels > 0.0) typical.push_back(block.squares / block.pixels);
    }
    const double least = 64.0 * median(typical);
    Pool rest = sums.image[all];
    for (size_t i = 0; i < blocks.size(); ++i) {
      if (blocks[i].squares <= least) continue;
      for_each_pixel(block_window(window, static_cast<int>(i)), [&](int x, int y) {
        if (!regions_.hold(test_.image.pixel(x, y))) return;
        const PixelPair pair = pair_at(x, y, all);
        const double square = pair.difference() * pair.difference();
        if (square <= std::max(least, blocks[i].squares / 2.0)) return;
        const Criterion judge = criterion(all, pair.reference, Unit::pixel);
        if (std::abs(pair.difference()) <= judge.tolerance + judge.floor) return;
        ++result_.fireflies;
        rest.add(pair, test_, reference_, -1.0);
      });
    }
    if (rest.pixels == 0.0) return;
    result_.without_fireflies =
        criterion(all, rest.mean_reference(), Unit::image).estimate(rest, critical_for(1));
    result_.without_fireflies.confidence = known_confidence(all, rest);
  }

  // The verdict, and what would decide it.
  void conclude() {
    bool is_different = false;
    bool has_outliers = false;
    for (Level& level : result_.levels) {
      const Amount& most = judgement_.max_outliers;
      const double pixels = most.value * (most.is_relative ? double(level.units) : 1.0);
      const double allowed = level.unit == Unit::pixel ? pixels : 0.0;
      level.differs = double(level.different) > allowed || level.beyond_limit > 0;
      (level.unit == Unit::pixel ? has_outliers : is_different) |= level.differs;
    }
    bool is_same = true;
    for (const auto* findings : {&result_.image, &result_.regions}) {
      for (const Finding& f : *findings) is_same &= f.estimate.verdict == Verdict::same;
    }
    if (is_same) result_.verdict = Verdict::same;
    if (!is_different && !has_outliers) return;
    result_.is_doubtful =
        !result_.is_paired && (test_.has_few_samples() || reference_.has_few_samples());
    result_.verdict = result_.is_doubtful ? Verdict::inconclusive : Verdict::different;
    result_.is_same_but_for_pixels = is_same && !is_different && !result_.is_doubtful;
  }

 private:
  // Rather than of another layer, whose noise may not be known.
  bool is_of_picture(size_t c) const { return c < test_.averaged || c == test_.channel_count(); }

  // What a relative amount is a part of, for a unit whose reference has this average.
  double scale(size_t c, double own) const {
    return has_unit_scale_[c] ? 1.0 : std::max(std::abs(own), least_scales_[c]);
  }

  double radiance(const Amount& amount, size_t c, double own) const {
    return amount.value * (amount.is_relative ? scale(c, own) : 1.0);
  }

  Criterion criterion(size_t c, double own, Unit unit) const {
    const bool has_own_floor = unit == Unit::image && judgement_.image_floor;
    const auto& floor = has_own_floor ? judgement_.image_floor : judgement_.floor;
    return {radiance(judgement_.tolerance, c, own), floor ? radiance(*floor, c, own) : 0.0,
            bool{knows_noise_[c]}, noise_ratios_[c], result_.is_paired};
  }

  double known_confidence(size_t c, const Pool& pool) const {
    if (!knows_noise_[c]) return 0.0;
    return result_.is_paired ? paired_confidence(pool) : confidence(pool);
  }

  // For each level's share of the false alarms.
  double critical_for(size_t tests) const {
    constexpr double levels = 4.0;
    return critical_value(judgement_.false_alarm / levels, static_cast<double>(tests));
  }

  PixelPair pair_at(int x, int y, size_t c) const {
    return pixel_pair(test_, reference_, test_.image.pixel(x, y), c);
  }

  double claimed_variance(const PixelPair& pair, size_t c) const {
    return cautious_variance(pair.test_variance, pair.reference_variance, noise_ratios_[c]);
  }

  // By the largest noise that is claimed within some pixels from here.
  double margin(int x, int y, size_t c, double critical) const {
    if (!knows_noise_[c]) return 0.0;
    const int left = std::max(x - neighbourhood, 0), top = std::max(y - neighbourhood, 0);
    const int width = std::min(x + neighbourhood + 1, test_.image.width) - left;
    const int height = std::min(y + neighbourhood + 1, test_.image.height) - top;
    PixelPair noisiest = pair_at(x, y, c);
    for_each_pixel({left, top, width, height}, [&](int u, int v) {
      const size_t pixel = test_.image.pixel(u, v);
      noisiest.test_variance = std::max(noisiest.test_variance, test_.variance(pixel, c));
      noisiest.reference_variance =
          std::max(noisiest.reference_variance, reference_.variance(pixel, c));
    });
    return critical * std::sqrt(claimed_variance(noisiest, c));
  }

  // The channel that differs most clearly, if one differs. A pixel's variance comes from few
  // replicates. All may have missed or met the same edge, or have met one rare caustic each, and so
  // claim no noise. So a pixel is taken to be as noisy as the noisiest one around it; its own noise
  // tells quickly that most don't differ.
  std::optional<Finding> judge_pixel(int x, int y, double critical) const {
    std::optional<Finding> finding;
    for (size_t c = 0; c < test_.channel_count(); ++c) {
      const PixelPair pair = pair_at(x, y, c);
      Estimate estimate{pair.test, pair.reference, pair.difference()};
      const Criterion judge = criterion(c, pair.reference, Unit::pixel);
      if (knows_noise_[c]) {
        const double own = critical * std::sqrt(claimed_variance(pair, c));
        if (std::abs(estimate.difference) - judge.floor - own <= judge.tolerance) continue;
      }
      estimate.margin = margin(x, y, c, critical);
      judge.judge(estimate);
      if (estimate.verdict != Verdict::different) continue;
      const bool is_beyond_limit =
          judgement_.hard_limit && std::abs(estimate.difference) - estimate.margin - judge.floor >
                                       radiance(*judgement_.hard_limit, c, pair.reference);
      if (!finding || finding->estimate.excess < estimate.excess) {
        const bool was_beyond_limit = finding && finding->is_beyond_limit;
        finding = Finding{"", {x, y, 1, 1}, result_.channels[c], estimate, was_beyond_limit};
      }
      finding->is_beyond_limit |= is_beyond_limit;
    }
    return finding;
  }

  const Picture& test_;
  const Picture& reference_;
  const Regions& regions_;
  const Judgement& judgement_;
  int64_t pixels_;  // that are compared
  Comparison& result_;
  // For each channel.
  std::vector<bool> knows_noise_, has_unit_scale_;
  std::vector<double> noise_ratios_, least_scales_;
};

}  // namespace

const char* to_string(Unit unit) {
  constexpr const char* words[] = {"image", "region", "block", "pixel"};
  return words[static_cast<size_t>(unit)];
}

double Errors::psnr() const {
  if (mse == 0.0) return std::numeric_limits<double>::infinity();
  return 10.0 * std::log10(peak * peak / mse);
}

Comparison compare(const Picture& test, const Picture& reference,
                   const std::vector<std::string>& channels, const Window& window,
                   const Regions& regions, const Judgement& judgement) {
  const Sums sums = add_up(test, reference, window, regions);
  if (sums.image.front().pixels == 0.0) {
    throw std::invalid_argument("no pixel to compare is in a region");
  }
  Comparison result;
  result.channels = channels;
  result.channels.emplace_back("all");
  result.window = window;
  for (size_t c = 0; c < channels.size(); ++c) result.errors.push_back(errors_of(sums.image[c]));
  tbb::parallel_for(size_t{0}, channels.size(),
                    [&](size_t c) { find_extremes(test, reference, window, c, result.errors[c]); });
  result.is_paired = are_paired(test, reference);
  Judge judge(test, reference, regions, judgement, sums, result);
  const auto name_region = [&](int i, Finding& f) {
    f.name = regions.names[static_cast<size_t>(i)];
  };
  const auto locate_block = [&](int i, Finding& f) { f.window = block_window(window, i); };
  judge.judge_pools(
      Unit::image, sums.image, [&](int, Finding& f) { f.window = window; }, &result.image);
  judge.judge_pools(Unit::region, sums.regions, name_region, &result.regions);
  if (judge.knows_any_noise()) judge.judge_pools(Unit::block, sums.blocks, locate_block, nullptr);
  const bool both_know = test.knows_noise() && reference.knows_noise();
  if (both_know || !result.is_paired) judge.judge_pixels(window);
  judge.find_fireflies(sums, window);
  result.errors.push_back(mean(result.errors, test.averaged));
  judge.conclude();
  return result;
}

void add_flip(Comparison& comparison, const Flip& flip, const Judgement& judgement) {
  comparison.flip = flip;
  constexpr double any = std::numeric_limits<double>::infinity();
  const bool is_beyond =
      flip.mean > judgement.flip_mean.value_or(any) || flip.p95 > judgement.flip_p95.value_or(any);
  comparison.looks_different = is_beyond && comparison.verdict != Verdict::different;
  if (comparison.looks_different) comparison.verdict = Verdict::different;
}

}  // namespace plumb
