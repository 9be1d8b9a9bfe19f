// SPDX-License-Identifier: Apache-2.0

#include "compare/shared_samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

namespace plumb {
namespace {

// Numbers first <= n < last.
struct Range {
  double first = 0, last = 0;
  bool overlaps(const Range& other) const {
    return std::max(first, other.first) < std::min(last, other.last);
  }
};

Range samples_of(const Provenance& made) {
  const double first = std::strtod(made.samples.value_or("").c_str(), nullptr);
  return {first, first + made.samples_per_pixel()};
}

// The sampler is known of our pictures alone, whose replicates have one seed together.
Range seeds_of(const Provenance& made) {
  if (!made.seed) return {};
  const double seed = *made.seed;
  return {seed, seed + (made.sampler ? 1 : made.replicates.value_or(1))};
}

std::string scene_of(const Picture& picture) {
  const Provenance& made = picture.image.provenance;
  return fmt::format("the {} is of {} ({:.8})", picture.side, made.scene.value_or("a scene"),
                     *made.scene_hash);
}

}  // namespace

bool are_paired(const Picture& a, const Picture& b) {
  const Provenance& x = a.image.provenance;
  const Provenance& y = b.image.provenance;
  return x.sampler && x.seed && x.samples && x.renderer == y.renderer && x.method == y.method &&
         x.sampler == y.sampler && x.bounces == y.bounces && x.seed == y.seed &&
         x.samples == y.samples && a.image.width == b.image.width &&
         a.image.height == b.image.height && a.file_variances.empty() && b.file_variances.empty();
}

bool share_samples(const Picture& a, const Picture& b) {
  const Provenance& x = a.image.provenance;
  const Provenance& y = b.image.provenance;
  return x.renderer == y.renderer && x.scene_hash == y.scene_hash && x.sampler == y.sampler &&
         seeds_of(x).overlaps(seeds_of(y)) && samples_of(x).overlaps(samples_of(y));
}

void refuse_other_scenes(const Picture& a, const Picture& b) {
  const auto& x = a.image.provenance.scene_hash;
  const auto& y = b.image.provenance.scene_hash;
  if (!x || !y || x == y) return;
  throw ImageError(fmt::format("{}, {}: --other-scene allows it", scene_of(a), scene_of(b)));
}

}  // namespace plumb
