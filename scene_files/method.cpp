// SPDX-License-Identifier: Apache-2.0

#include "scene_files/method.h"

#include <algorithm>

#include "renderer/render.h"
#include "scene/surfaces.h"

namespace plumb {
namespace {

struct Trial {
  double variance = 0.0;  // of a sample, over the squared mean: the average over pixels, channels
  double pooled = 0.0;    // the same of sums over these, in which rare bright samples show
  double rays = 0.0;
};

Trial try_out(const Scene& scene, Method method) {
  constexpr int64_t samples = 4;
  Film film(scene.camera.width, scene.camera.height);
  // Where everything reflects everything, paths never end by themselves.
  const Settings settings{
      .method = method, .sampler = Sampler::independent, .bounces = {.first = 0, .last = 2000}};
  Trial trial;
  trial.rays = static_cast<double>(render(scene, settings, {.samples = {0, samples}}, film).rays);
  const std::vector<float> mean = film.mean(), variance = film.variance();
  double sum_of_variances = 0.0, sum_of_squares = 0.0;
  for (size_t i = 0; i < mean.size(); ++i) {
    const double value{mean[i]};  // 0: infinite variance, or none that is known
    trial.variance += samples * double{variance[i]} / (value * value);
    sum_of_variances += samples * double{variance[i]};
    sum_of_squares += value * value;
  }
  trial.variance /= static_cast<double>(mean.size());
  trial.pooled = sum_of_variances / sum_of_squares;
  return trial;
}

}  // namespace

bool chance_suffices(const Scene& scene) {
  if (list_surfaces(scene).size() > 300 || !scene.points.empty()) return false;
  Scene small = scene;
  small.camera.width = small.camera.height = 16;
  const Trial chance = try_out(small, Method::bsdf);
  if (!(std::max(chance.variance, chance.pooled) <= 0.25)) return false;
  const Trial sampled = try_out(small, Method::mis);
  return chance.variance * chance.rays < sampled.variance * sampled.rays / 2.0;
}

}  // namespace plumb
