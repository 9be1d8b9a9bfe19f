// SPDX-License-Identifier: Apache-2.0

// The estimator with one of the faults of faults.h, chosen at run time.
#include "faults/clamp.h"
#include "faults/faults.h"
#include "renderer/simd/path-inl.h"

#if defined(PLUMB_FAULTY_ESTIMATOR_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PLUMB_FAULTY_ESTIMATOR_INL_H
#undef PLUMB_FAULTY_ESTIMATOR_INL_H
#else
#define PLUMB_FAULTY_ESTIMATOR_INL_H
#endif

HWY_BEFORE_NAMESPACE();
namespace plumb::HWY_NAMESPACE {

template <class D>
HWY_INLINE V3<D> cross(V3<D> a, V3<D> b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// The helper of the WebGL demos crosses the normal with a fixed axis: its tangents are as short as
// the sine of the angle between the two.
template <class D>
HWY_INLINE Frame<D> short_frame_around(V3<D> n) {
  using R = Real<D>;
  const V3<D> x_axis(R(1), R(0), R(0)), y_axis(R(0), R(1), R(0));
  const V3<D> tangent = cross(n, select(abs(n.x) < R(0.5f), x_axis, y_axis));
  return {tangent, cross(n, tangent), n};
}

// The cosine of the angle at a lamp's point that is so far from p.
template <class D>
HWY_INLINE Real<D> emitter_cosine(const PackedLamp<hn::TFromD<D>>& lamp, V3<D> p,
                                  Real<D> distance) {
  using R = Real<D>;
  const V3<D> from_lamp = p - V3<D>(lamp.origin);
  if (lamp.kind == PackedLamp<hn::TFromD<D>>::Kind::rectangle) {
    return dot(from_lamp, V3<D>(lamp.normal)) / distance;
  }
  const R radius(lamp.radius);
  const R squares = dot(from_lamp, from_lamp) - radius * radius - distance * distance;
  return squares / (R(2) * radius * distance);
}

// The random number of the WebGL demos, from 0 to 1.
template <class D>
HWY_INLINE Real<D> webgl_random(Real<D> x, Real<D> y, Real<D> seed) {
  using R = Real<D>;
  const R product = sin(x * R(12.9898f) + y * R(78.233f) + seed) * R(43758.5453f);
  return product - hn::Floor(product.v);
}

// Their seed of a frame: the part of the second that a clock of milliseconds shows. A display shows
// 2997 frames in 50 seconds; by then the clock has shown all there is.
HWY_INLINE float webgl_seed(uint32_t frame) {
  constexpr uint64_t seconds = 50, frames = 2997, milliseconds = 1000;
  const uint64_t time = frame * seconds * milliseconds / frames;
  return static_cast<float>(time % milliseconds) / static_cast<float>(milliseconds);
}

template <class Lanes>
struct FaultyEstimator : Estimator<Lanes, true> {
  using Base = Estimator<Lanes, true>;
  using typename Base::Bsdf;
  using typename Base::D;
  using typename Base::Lamp;
  using typename Base::R;
  using typename Base::T;

  explicit FaultyEstimator(const TraceJob<PackedScene<T>>& job)
      : Base(job),
        fault(job.settings.fault),
        is_webgl(fault == Fault::webgl_random || fault == Fault::webgl_demo),
        start(job.settings.seed),
        width(static_cast<uint32_t>(job.scene.camera.width)) {}

  bool looks_into_mirrors() const { return !is_webgl; }

  // A frame is a sample of each pixel. The seeds of what it draws differ by whole seconds.
  Sample<D> draw(Sampler sampler, const SampleIndex<D>& index, Bits<D> pair) {
    if (!is_webgl) return Base::draw(sampler, index, pair);
    const D d;
    const typename Bits<D>::DU du;
    constexpr size_t lanes = hn::MaxLanes(D());
    alignas(64) uint32_t pixel[lanes], frame[lanes];
    alignas(64) T x[lanes], y[lanes], seed[lanes];
    hn::Store(index.pixel.v, du, pixel);
    hn::Store((index.index * uint32_t{Film::replicates} + index.replicate).v, du, frame);
    for (size_t lane = 0; lane < lanes; ++lane) {
      const uint32_t row = pixel[lane] / width;
      x[lane] = static_cast<T>(pixel[lane] % width);
      y[lane] = static_cast<T>(row);
      seed[lane] = webgl_seed(start + frame[lane]);
    }
    const hn::RebindToSigned<D> di;
    R dimension = hn::ConvertTo(d, hn::BitCast(di, (pair * 3u).v));
    const auto next = [&] {
      const R number =
          webgl_random<D>(hn::Load(d, x), hn::Load(d, y), hn::Load(d, seed) + dimension);
      dimension = dimension + R(1);
      return number;
    };
    const R u = next(), v = next();
    third = next();
    return {u, v, third};
  }

  BsdfSample<D> sample_bsdf(const Bsdf& bsdf, V3<D> incident, R u, R v) const {
    if (fault == Fault::uniform_directions) {
      const R sine = sqrt(R(1) - u * u);
      return bsdf.other_or(incident, u, v,
                           spherical_direction(frame_around(bsdf.normal), u, sine, v));
    }
    if (fault == Fault::tangent_frame) {
      const Frame<D> frame = short_frame_around(bsdf.normal);
      return bsdf.other_or(incident, u, v, normalize(sample_cosine_hemisphere(frame, u, v)));
    }
    return bsdf.more.is_glass.any() ? sample_glass(bsdf, incident, u, v)
                                    : Base::sample_bsdf(bsdf, incident, u, v);
  }

  LampSample<D> sample_lamp(const Lamp& lamp, V3<D> p, R u, R v) const {
    if (fault == Fault::webgl_demo) return sample_ball(lamp, p, u, v);
    LampSample<D> sample = Base::sample_lamp(lamp, p, u, v);
    sample.inverse_pdf = spoil(sample.inverse_pdf, lamp, p, sample.distance);
    if (fault == Fault::inverse_pi) sample.inverse_pdf = sample.inverse_pdf * R::pi();
    return sample;
  }

  R inverse_lamp_pdf(const Lamp& lamp, V3<D> p, R distance) const {
    return spoil(Base::inverse_lamp_pdf(lamp, p, distance), lamp, p, distance);
  }

  R sum_of_pdfs(R lamp, R bsdf) const {
    if (fault == Fault::one_sided_mis) return lamp;
    return lamp + (fault == Fault::inverse_pi ? bsdf * R::inverse_pi() : bsdf);
  }

  V3<D> contribution(V3<D> light, R bounces, R, R) const {
    if (fault != Fault::clamp_indirect) return light;
    const R most = select(bounces > R(1), R(T{clamped_at}), R(std::numeric_limits<T>::infinity()));
    return {min(light.x, most), min(light.y, most), min(light.z, most)};
  }

  R survival_probability(V3<D> throughput) const {
    return fault == Fault::webgl_demo ? R(1) : Base::survival_probability(throughput);
  }

  R survivor_weight(R probability) const {
    return fault == Fault::roulette_weight ? R(1) : Base::survivor_weight(probability);
  }

 private:
  BsdfSample<D> sample_glass(const Bsdf& bsdf, V3<D> incident, R u, R v) const {
    const auto& glass = bsdf.more;
    const R cosine = -dot(bsdf.normal, incident);
    // A number that lets light through unless it is reflected totally.
    const R through(T{1} - std::numeric_limits<T>::epsilon() / 2);
    if (fault == Fault::fresnel_ignored) u = select(glass.is_glass, through, u);
    if (fault == Fault::schlick) {
      const R straight = (glass.n - R(1)) / (glass.n + R(1)), dim = R(1) - cosine;
      const R f = straight * straight, fifth = dim * dim * dim * dim * dim;
      const R reflects = fma(R(1) - f, fifth, f);
      u = select(glass.is_glass, select(u >= reflects, through, R(0)), u);
    }
    BsdfSample<D> sample = Base::sample_bsdf(bsdf, incident, u, v);
    if (fault == Fault::n_squared) {
      const Bool<D> is_through = glass.is_glass & (dot(bsdf.normal, sample.direction) < R(0));
      sample.factor = select(is_through, glass.transmittance, sample.factor);
    }
    if (fault == Fault::total_reflection_black) {
      R beyond;
      const Bool<D> is_total = glass.is_glass & (fresnel_of_glass(cosine, glass.n, beyond) == R(1));
      sample.factor = select(is_total, V3<D>(R(0)), sample.factor);
    }
    return sample;
  }

  R spoil(R inverse_pdf, const Lamp& lamp, V3<D> p, R distance) const {
    if (fault == Fault::half_lamp_area) return inverse_pdf * R(0.5f);
    if (fault == Fault::inverse_square || fault == Fault::even_lamp)
      inverse_pdf = inverse_pdf * (distance * distance);
    if (fault == Fault::emitter_cosine || fault == Fault::even_lamp)
      inverse_pdf = inverse_pdf / max(emitter_cosine(lamp, p, distance), R(1e-4f));
    return inverse_pdf;
  }

  // A point in a ball as large as the lamp, as bright from everywhere as the lamp from straight
  // below at distance 1, half the scene's size.
  LampSample<D> sample_ball(const Lamp& lamp, V3<D> p, R u, R v) const {
    const R z = R(1) - (u + u);
    const V3<D> aside = V3<D>(lamp.x) * (lamp.x_length / 2) + V3<D>(lamp.y) * (lamp.y_length / 2);
    const Frame<D> axes{{R(1), R(0), R(0)}, {R(0), R(1), R(0)}, {R(0), R(0), R(1)}};
    const R radius = sqrt(third * R(lamp.area / (4 * std::numbers::pi_v<T>)));
    const V3<D> jitter = spherical_direction(axes, z, sqrt(max(R(1) - z * z, R(0))), v) * radius;
    const V3<D> to_point = V3<D>(lamp.origin) + aside + jitter - p;
    const R distance = sqrt(dot(to_point, to_point));
    return {to_point * (R(1) / distance), distance, R(lamp.area), !Bool<D>::none()};
  }

  Fault fault;
  bool is_webgl;
  uint32_t start;  // the clock's first frame
  uint32_t width;
  R third = R(0);  // the last number drawn
};

}  // namespace plumb::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
