// SPDX-License-Identifier: Apache-2.0

#include "radiosity/radiosity.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

#include "radiosity/elements.h"
#include "radiosity/pixels.h"
#include "radiosity/solution.h"

namespace plumb::radiosity {
namespace {

constexpr int most_levels = 12;

class Artist {
 public:
  Artist(const Scene& scene, const Settings& settings, const Work& work)
      : faces_(scene, settings.most_bytes, work),
        camera_(scene.camera),
        settings_(settings),
        most_bytes_(settings.most_bytes - faces_.bytes()),
        work_(work),
        pixels_(faces_, scene.camera),
        eyes_(faces_) {}

  Picture draw(int level) {
    Picture picture;
    picture.level = level;
    std::unique_ptr<Solution> solution;
    if (settings_.bounces.last >= 2) {
      if (!elements_) elements_.emplace(faces_, most_bytes_ / sizeof(Element));
      const Resolution resolution = Resolution::level(level);
      solution = std::make_unique<Solution>(
          *elements_, resolution, settings_.bounces, settings_.origin, std::move(coarser_),
          most_bytes_ - elements_->size() * sizeof(Element), work_);
      picture.elements = elements_->leaves();
      picture.links = solution->links();
    }
    const auto width = static_cast<size_t>(camera_.width);
    const size_t count = width * static_cast<size_t>(camera_.height);
    picture.rgb.resize(count * 3);
    work_.for_each("pixels", count, [&](size_t i) {
      const Rgb sum = pixel(int(i % width), int(i / width), level, solution.get());
      for (int c = 0; c < 3; ++c) picture.rgb[i * 3 + size_t(c)] = float(std::max(0.0, sum[c]));
    });
    if (solution) elements_->refine(solution->unevenness(), Resolution::level(level).unevenness);
    coarser_ = std::move(solution);
    return picture;
  }

 private:
  Rgb pixel(int x, int y, int level, const Solution* solution) {
    const BounceRange& bounces = settings_.bounces;
    const LightOrigin* origin = settings_.origin;
    Eye& eye = eyes_.local();
    Rgb sum(0.0);
    for (const Fragment& fragment : pixels_.fragments(x, y)) {
      const Face& face = faces_[fragment.face];
      if (bounces.contains(0) && (origin == nullptr || origin->counts_emission(face.shape)))
        sum += face.radiance * pixels_.share(fragment);
      if (!face.reflects()) continue;
      Rgb arriving(0.0);
      if (bounces.contains(1)) {
        const Quadrature fine{.spread = 0.1 * std::pow(0.5, level), .depth = level + 1};
        arriving +=
            pixels_.integrate(fragment, fine, eye, [&](Eye& at) { return at.direct(origin); });
      }
      if (solution != nullptr) {
        std::optional<Quadrature> fine;
        if (!pixels_.is_smooth(fragment)) fine = {.spread = 0.1, .depth = 2};
        arriving +=
            pixels_.integrate(fragment, fine, eye, [&](Eye& at) { return solution->gather(at); });
      }
      sum += face.reflectance * arriving;
    }
    return sum;
  }

  Faces faces_;
  const Camera& camera_;
  const Settings& settings_;
  size_t most_bytes_;  // for elements and links
  const Work& work_;
  Pixels pixels_;
  std::optional<Elements> elements_;
  std::unique_ptr<Solution> coarser_;
  tbb::enumerable_thread_specific<Eye> eyes_;
};

bool is_done(const Picture& picture, const Settings& settings) {
  return settings.error > 0.0 ? picture.error <= settings.error : picture.level >= settings.level;
}

}  // namespace

void estimate_error(Picture& fine, const Picture& coarse, const Camera& camera) {
  constexpr int side = 8;
  const int across = (camera.width + side - 1) / side, down = (camera.height + side - 1) / side;
  std::vector<double> mean(size_t(across * down * 3)), difference(mean.size());
  std::array<double, 3> whole{}, whole_difference{};
  double squares = 0.0;
  for (size_t i = 0; i < fine.rgb.size(); ++i) {
    const double value = fine.rgb[i], off = value - double{coarse.rgb[i]};
    const auto pixel = static_cast<int>(i / 3);
    const int x = pixel % camera.width / side, y = pixel / camera.width / side;
    const size_t block = size_t(y * across + x) * 3 + i % 3;
    mean[block] += value;
    difference[block] += off;
    whole[i % 3] += value;
    whole_difference[i % 3] += off;
    squares += off * off / (value * value + 0.01);
  }
  const auto count = static_cast<double>(fine.rgb.size());
  fine.error = std::sqrt(squares / count);
  fine.image_floor = fine.block_floor = 0.0;
  const double sum = whole[0] + whole[1] + whole[2];
  if (sum == 0.0) return;
  for (size_t c = 0; c < 3; ++c) {
    const double judged = std::max(whole[c], 0.1 * sum / 3.0);
    fine.image_floor = std::max(fine.image_floor, std::abs(whole_difference[c]) / judged);
  }
  const double least = 0.1 * sum / count * side * side;
  for (size_t i = 0; i < mean.size(); ++i) {
    fine.block_floor =
        std::max(fine.block_floor, std::abs(difference[i]) / std::max(mean[i], least));
  }
}

Picture draw(const Scene& scene, const Settings& settings, const Work& work) {
  Picture best;
  try {
    Artist artist(scene, settings, work);
    for (int level = 0; level <= most_levels && !is_done(best, settings); ++level) {
      Picture next = artist.draw(level);
      if (best.level >= 0) estimate_error(next, best, scene.camera);
      best = std::move(next);
    }
  } catch (const Stopped&) {
    best.why_ended = "interrupted";
  } catch (const std::length_error& error) {
    if (best.level < 0) throw std::runtime_error(error.what());
    best.why_ended = error.what();
  }
  return best;
}

}  // namespace plumb::radiosity
