// SPDX-License-Identifier: Apache-2.0

#include "renderer/render.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <functional>
#include <limits>
#include <optional>
#include <stdexcept>

#include "renderer/plain_path_tracer.h"
#include "renderer/trace.h"

namespace plumb {
namespace {

// Long enough to keep all threads busy, short enough that an interrupt is felt at once.
constexpr double seconds_per_pass = 0.25;

double wall_now() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double>(now).count();
}

double cpu_now() { return static_cast<double>(std::clock()) / static_cast<double>(CLOCKS_PER_SEC); }

// How many seconds until the first limit, at the pace so far.
double seconds_left(const Limits& limits, const Progress& progress) {
  const double seconds = progress.cost.wall_seconds;
  const auto done = static_cast<double>(progress.samples_per_pixel);
  const auto wanted = static_cast<double>(limits.samples.count());
  const double left = std::min(limits.seconds - seconds, seconds * (wanted - done) / done);
  return std::max(left, 0.0);
}

bool is_done(const Limits& limits, const Progress& progress) {
  return progress.samples_per_pixel >= limits.samples.count() ||
         progress.cost.wall_seconds >= limits.seconds;
}

// Tells how many samples per pixel the wanted error takes, by samples that the picture doesn't get.
// If the picture's own samples told, the render would end when they happen to claim little noise:
// neither picture nor claim would be unbiased (Kirk and Arvo, "Unbiased sampling techniques for
// image synthesis", SIGGRAPH 1991).
class Pilot {
 public:
  Pilot(const Film& picture, const Settings& settings, double relative_error)
      : film_(picture.window()), settings_(settings), goal_(relative_error) {
    settings_.seed ^= 0x80000000U;  // no caller's
  }

  Film& film() { return film_; }
  const Settings& settings() const { return settings_; }

  // The samples that it needs when the picture has so many.
  SampleRange next(int64_t samples_of_picture) const {
    const int64_t own = film_.samples_per_pixel();
    if (own < fewest_samples) return {own, std::min(samples_of_picture, fewest_samples)};
    return {own, own < samples_of_picture / 16 ? 2 * own : own};
  }

  // By error that falls with the square root of the samples, or faster.
  int64_t wanted_samples() const {
    const auto own = static_cast<double>(film_.samples_per_pixel());
    if (own < double{fewest_samples}) return largest_sample;
    const double ratio = film_.relative_error() / goal_;
    const double wanted = std::ceil(own * ratio * ratio / Film::replicates) * Film::replicates;
    return static_cast<int64_t>(std::clamp(wanted, double{fewest_samples}, double{largest_sample}));
  }

 private:
  // Of fewer all may have missed the lamp.
  static constexpr int64_t fewest_samples = 64;

  Film film_;
  Settings settings_;
  double goal_;
};

// Samples per pixel for the next pass: one for a first look, then what fits into a pass and the
// time left, growing slowly because a first look may deceive.
int64_t pass_size(const Limits& limits, const Progress& progress) {
  if (progress.samples_per_pixel == 0) return 1;
  const double pace = static_cast<double>(progress.samples_per_pixel) / progress.cost.wall_seconds;
  const double time_left = limits.seconds - progress.cost.wall_seconds;
  const double size = pace * std::min(seconds_per_pass, time_left);
  return std::clamp<int64_t>(static_cast<int64_t>(size), 1, 4 * progress.samples_per_pixel);
}

int64_t trace_job(const TraceJob<PackedScene<float>>& job) {
  return job.settings.tracer != nullptr ? job.settings.tracer->in_float(job) : trace(job);
}

int64_t trace_job(const TraceJob<PackedScene<double>>& job) {
  return job.settings.tracer != nullptr ? job.settings.tracer->in_double(job) : trace(job);
}

int64_t trace_job(const TraceJob<PlainScene>& job) {
  int64_t rays = 0;
  for (int64_t pixel; (pixel = job.next_pixel++) < job.film.pixel_count();) {
    job.film.open_pixel(size_t(pixel));
    const int64_t seen = job.film.window().number_in_picture(pixel, job.scene.model.camera.width);
    for (int64_t sample = job.samples.first; sample < job.samples.last; ++sample) {
      const Vec3 radiance =
          trace_path(job.scene, job.settings, seen, sample, job.is_abandoned, rays);
      if (job.is_abandoned(0)) return rays;
      job.film.add(size_t(pixel), size_t(sample % Film::replicates), &radiance.x, 1);
    }
  }
  return rays;
}

// Says when a pass is not worth waiting for.
class Impatience {
 public:
  Impatience(double end, const std::atomic<bool>* stop) : end_(end), stop_(stop) {}

  bool is_abandoned(int64_t longest_path) {
    if (path_ > 0) return true;
    constexpr double patience = 0.5;  // seconds
    const double now = wall_now();
    double never = std::numeric_limits<double>::infinity();
    if (stop_ != nullptr && *stop_) told_.compare_exchange_strong(never, now);
    const bool is_endless = longest_path > endless_path && now > std::min(end_, told_.load());
    if (is_endless || now > told_ + patience) path_ = std::max<int64_t>(longest_path, 1);
    return path_ > 0;
  }

  // Of the abandoned pass, its longest path; 0: none was.
  int64_t path() const { return path_; }

 private:
  double end_;
  const std::atomic<bool>* stop_;
  std::atomic<double> told_ = std::numeric_limits<double>::infinity();  // to stop
  std::atomic<int64_t> path_ = 0;
};

template <class TracedScene>
Cost render_as(const Scene& scene, const Settings& settings, Limits limits, Film& film,
               const ProgressCallback& callback, const std::atomic<bool>* stop) {
  const TracedScene prepared(scene);
  const int threads = settings.threads > 0 ? settings.threads : tbb::info::default_concurrency();
  const tbb::global_control workers(tbb::global_control::max_allowed_parallelism, size_t(threads));
  tbb::task_arena arena(threads);
  const double wall_start = wall_now();
  const double cpu_start = cpu_now();
  Impatience impatience(wall_start + limits.seconds, stop);
  const std::function<bool(int64_t)> is_abandoned = [&](int64_t longest_path) {
    return impatience.is_abandoned(longest_path);
  };
  std::atomic<int64_t> rays{0};
  // Adds a pass, unless it is abandoned.
  const auto add = [&](Film& to, const Settings& how, const SampleRange& samples) {
    std::atomic<int64_t> next_pixel{0};
    const TraceJob<TracedScene> job{prepared, how, samples, to, next_pixel, is_abandoned};
    to.begin_pass();
    arena.execute([&] { tbb::parallel_for(0, threads, [&](int) { rays += trace_job(job); }); });
    if (impatience.path() == 0) to.end_pass(samples);
  };
  std::optional<Pilot> pilot;
  if (limits.relative_error > 0.0) pilot.emplace(film, settings, limits.relative_error);
  const int64_t most = limits.samples.count();
  Progress progress;
  do {
    const int64_t first = limits.samples.first + progress.samples_per_pixel;
    const int64_t last = std::min(first + pass_size(limits, progress), limits.samples.last);
    const SampleRange samples{first, last};
    add(film, settings, samples);
    if (impatience.path() > 0) {
      progress.cost.wall_seconds = wall_now() - wall_start;
      progress.cost.unfinished_path = impatience.path();
      break;
    }
    progress.samples_per_pixel += samples.count();
    int64_t traced = samples.count();
    if (pilot) {
      const SampleRange own = pilot->next(progress.samples_per_pixel);
      if (own.count() > 0) add(pilot->film(), pilot->settings(), own);
      traced += own.count();
      limits.samples.last = limits.samples.first + std::min(most, pilot->wanted_samples());
    }
    progress.cost = {.wall_seconds = wall_now() - wall_start,
                     .cpu_seconds = cpu_now() - cpu_start,
                     .samples = progress.cost.samples + traced * film.pixel_count(),
                     .rays = rays,
                     .unfinished_path = 0};
    progress.relative_error = film.relative_error();
    progress.seconds_left = seconds_left(limits, progress);
    if (callback) callback(progress);
  } while (!is_done(limits, progress) && (stop == nullptr || !*stop));
  return progress.cost;
}

}  // namespace

std::string why_unfinished(const Cost& cost) {
  if (cost.unfinished_path == 0) return "";
  if (cost.unfinished_path <= endless_path) return "the pass under way was too long to wait for";
  return fmt::format(
      "a path has not ended after {} bounces: every surface that it meets reflects everything "
      "(--bounces 0:N ends paths)",
      cost.unfinished_path);
}

Cost render(const Scene& scene, const Settings& settings, const Limits& limits, Film& film,
            const ProgressCallback& progress, const std::atomic<bool>* stop) {
  if (limits.samples.count() <= 0) throw std::invalid_argument("no samples to render");
  const bool is_plain = settings.method == Method::plain;
  const bool is_double = settings.precision == Precision::float64;
  if (settings.tracer != nullptr &&
      (is_plain || (is_double && settings.tracer->in_double == nullptr))) {
    throw std::invalid_argument(
        "a fault of the tracer: float only; method plain has no faults and no origins of light");
  }
  if (is_plain && (!is_double || settings.sampler != Sampler::independent)) {
    throw std::invalid_argument("the plain path tracer draws independent numbers and is in double");
  }
  if (settings.method == Method::bsdf && !scene.points.empty()) {
    throw std::invalid_argument("method bsdf: chance never meets lamps that are points");
  }
  film.set_brightness(scene.brightness());
  if (is_plain) return render_as<PlainScene>(scene, settings, limits, film, progress, stop);
  if (is_double) {
    return render_as<PackedScene<double>>(scene, settings, limits, film, progress, stop);
  }
  return render_as<PackedScene<float>>(scene, settings, limits, film, progress, stop);
}

}  // namespace plumb
