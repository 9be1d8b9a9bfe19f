// SPDX-License-Identifier: Apache-2.0

#include "radiosity/teaching/film.h"

#include <algorithm>

namespace plumb::radiosity::teaching {

Film::Film(const Patches& patches, const Camera& camera, const Work& work)
    : patches_(patches),
      width_(size_t(camera.width) * points),
      height_(size_t(camera.height) * points),
      samples_(width_ * height_) {
  const auto at = [](size_t sample) { return (double(sample) + 0.5) / points; };
  work.for_each("view", samples_.size(), [&](size_t i) {
    const auto hit = patches.trace(camera.origin, camera.direction(at(i % width_), at(i / width_)));
    if (hit) samples_[i] = {hit->patch, patches.weights(hit->patch, hit->point)};
  });
}

template <typename Value>
std::vector<float> Film::picture(Value value) const {
  const size_t width = width_ / points;
  std::vector<Rgb> sums(samples_.size() / (points * points), Rgb(0.0));
  for (size_t i = 0; i < samples_.size(); ++i) {
    const size_t x = i % width_, y = i / width_;
    if (samples_[i].patch != nothing) sums[y / points * width + x / points] += value(i);
  }
  std::vector<float> rgb;
  for (const Rgb& sum : sums) {
    for (int c = 0; c < 3; ++c) rgb.push_back(float(sum[c] / (points * points)));
  }
  return rgb;
}

std::vector<float> Film::flat(const Light& light) const {
  return picture([&](size_t i) { return light[samples_[i].patch]; });
}

std::vector<float> Film::smooth(const Light& light) const {
  const Light corners = patches_.mean_at_vertices(light);
  return picture([&](size_t i) {
    const size_t patch = samples_[i].patch;
    Rgb sum(0.0);
    for (size_t k = 0; k < 4; ++k)
      sum += corners[patches_.vertex(patch, k)] * samples_[i].weights[k];
    return sum;
  });
}

std::vector<float> Film::wire(const Light& light) const {
  constexpr size_t thick = 2;
  return picture([&](size_t i) {
    const size_t x = i % width_, y = i / width_, patch = samples_[i].patch;
    bool is_edge = false;
    for (size_t k = 1; k <= thick; ++k) {
      const size_t right = y * width_ + std::min(x + k, width_ - 1);
      const size_t below = std::min(y + k, height_ - 1) * width_ + x;
      is_edge = is_edge || samples_[right].patch != patch || samples_[below].patch != patch;
    }
    return is_edge ? Rgb(0.0) : light[patch];
  });
}

}  // namespace plumb::radiosity::teaching
