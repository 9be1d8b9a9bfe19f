// SPDX-License-Identifier: Apache-2.0

// The path tracer: one path per lane, and a new path in the lane as soon as one ends.
#include "renderer/simd/bsdf-inl.h"
#include "renderer/simd/intersect-inl.h"
#include "renderer/simd/lamps-inl.h"
#include "renderer/simd/mirrors-inl.h"
#include "renderer/simd/sampler-inl.h"
#include "renderer/trace.h"

#if defined(PLUMB_SIMD_PATH_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PLUMB_SIMD_PATH_INL_H
#undef PLUMB_SIMD_PATH_INL_H
#else
#define PLUMB_SIMD_PATH_INL_H
#endif

HWY_BEFORE_NAMESPACE();
namespace plumb::HWY_NAMESPACE {

// Which sample of which pixel each lane is at. A lane keeps its pixel and takes the pixel's samples
// in order, so a pixel's sum does not depend on what the other lanes do.
template <class D>
class LaneSamples {
  using T = hn::TFromD<D>;

 public:
  explicit LaneSamples(const TraceJob<PackedScene<T>>& job) : job_(job) {
    std::fill_n(sample_, lanes, job.samples.last);
  }

  // Hands in the radiance of the finished lanes' samples and gives these lanes their next. Returns
  // the lanes that have a sample.
  Bool<D> advance(Bool<D> finished, const V3<D>& radiance) {
    const D d;
    alignas(64) T values[3 * lanes];
    hn::Store(radiance.x.v, d, values);
    hn::Store(radiance.y.v, d, values + lanes);
    hn::Store(radiance.z.v, d, values + 2 * lanes);
    LaneBits stored{};
    hn::StoreMaskBits(d, finished.m, stored.bytes);
    for (uint32_t left = stored.get(); left != 0; left &= left - 1) {
      const auto lane = static_cast<size_t>(std::countr_zero(left));
      const uint32_t bit = 1u << lane;
      const uint32_t busy = busy_.get();
      if ((busy & bit) != 0) {
        job_.film.add(on_film_[lane], replicate_[lane], values + lane, lanes);
      }
      busy_.set(take_next(lane) ? busy | bit : busy & ~bit);
    }
    return {hn::LoadMaskBits(d, busy_.bytes)};
  }

  SampleIndex<D> index() const {
    const typename Bits<D>::DU du;
    return {hn::Load(du, pixel_), hn::Load(du, replicate_), hn::Load(du, index_),
            mix(Bits<D>(job_.settings.seed))};
  }

  // Where in the picture, in pixels, u and v lie within the pixels' filters.
  Real<D> x(Real<D> u) const { return place(x_, u, left_, width_); }
  Real<D> y(Real<D> v) const { return place(y_, v, top_, height_); }

 private:
  static constexpr size_t lanes = hn::MaxLanes(D());
  static_assert(lanes <= 16);

  // A bit for each lane. Highway may read and write eight bytes. What is used of them is read and
  // written as wide as the mask is stored: the processor waits where a load is wider than the store
  // before it.
  struct LaneBits {
    using Word = std::conditional_t<lanes <= 8, uint8_t, uint16_t>;
    alignas(8) uint8_t bytes[8];

    uint32_t get() const {
      Word word;
      std::memcpy(&word, bytes, sizeof word);
      return word;
    }
    void set(uint32_t bits) {
      const auto word = static_cast<Word>(bits);
      std::memcpy(bytes, &word, sizeof word);
    }
  };

  bool take_next(size_t lane) {
    if (++sample_[lane] >= job_.samples.last) {
      if (next_pixel_ == end_pixel_) {
        next_pixel_ = std::min(job_.next_pixel.fetch_add(pixels_at_once * job_.shares),
                               job_.film.pixel_count());
        end_pixel_ = std::min(next_pixel_ + pixels_at_once, job_.film.pixel_count());
        if (next_pixel_ == end_pixel_) return false;
      }
      const int64_t width = job_.scene.camera.width;
      const int64_t pixel = job_.film.window().number_in_picture(next_pixel_, width),
                    row = pixel / width;
      pixel_[lane] = static_cast<uint32_t>(pixel);
      x_[lane] = static_cast<T>(pixel % width);
      y_[lane] = static_cast<T>(row);
      on_film_[lane] = size_t(next_pixel_++);
      sample_[lane] = job_.samples.first;
      job_.film.open_pixel(on_film_[lane]);
      if (!filter_.offsets.empty()) fit_filter(lane);
    }
    const auto sample = static_cast<uint64_t>(sample_[lane]);
    replicate_[lane] = static_cast<uint32_t>(sample % Film::replicates);
    index_[lane] = static_cast<uint32_t>(sample / Film::replicates);
    return true;
  }

  // How much of the filter is left where the picture ends.
  void fit_filter(size_t lane) {
    const auto cut = [&](T position, int size, T& first, T& share) {
      const T middle = position + T{0.5};
      first = filter_.crosses_border ? T{0} : filter_.share_below(-middle);
      const T last = filter_.share_below(static_cast<T>(size) - middle);
      share = (filter_.crosses_border ? T{1} : last) - first;
    };
    cut(x_[lane], job_.scene.camera.width, left_[lane], width_[lane]);
    cut(y_[lane], job_.scene.camera.height, top_[lane], height_[lane]);
  }

  Real<D> place(const T* pixel, Real<D> u, const T* first, const T* share) const {
    using R = Real<D>;
    const D d;
    const R corner = hn::Load(d, pixel);
    if (filter_.offsets.empty()) return corner + u;
    const auto last = static_cast<T>(filter_.offsets.size() - 1);
    const R at = fma(u, R(hn::Load(d, share)), R(hn::Load(d, first))) * R(last);
    const R below = min(R(hn::Floor(at.v)), R(last - 1));
    const auto index = hn::ConvertTo(hn::RebindToSigned<D>(), below.v);
    const R a = hn::GatherIndex(d, filter_.offsets.data(), index);
    const R b = hn::GatherIndex(d, filter_.offsets.data() + 1, index);
    return corner + R(T{0.5}) + fma(b - a, at - below, a);
  }

  const TraceJob<PackedScene<T>>& job_;
  const PackedFilter<T>& filter_ = job_.scene.camera.filter;
  LaneBits busy_{};  // the lanes that have a sample
  int64_t next_pixel_ = 0;
  int64_t end_pixel_ = 0;
  int64_t sample_[lanes];
  size_t on_film_[lanes] = {};
  alignas(64) uint32_t pixel_[lanes] = {};
  alignas(64) uint32_t replicate_[lanes] = {};
  alignas(64) uint32_t index_[lanes] = {};
  alignas(64) T x_[lanes] = {};
  alignas(64) T y_[lanes] = {};
  // Of the filter's weight, along x and y: what is left out before, and how much is left.
  alignas(64) T left_[lanes] = {};
  alignas(64) T width_[lanes] = {};
  alignas(64) T top_[lanes] = {};
  alignas(64) T height_[lanes] = {};
};

// Where paths meet surfaces.
template <class D, class Bsdf>
struct SurfaceInteraction {
  V3<D> point;
  Bsdf bsdf;
  Real<D> id, plane;
  Real<D> distance;  // that the path came
  Bool<D> scatters;  // neither in the void nor on a black back
  Bool<D> front;     // the path came from the side that the surface's own normal points to
};

// What sampled lamps add to the picture, if nothing is in the way.
template <class D>
struct DirectLight {
  RayLanes<D> ray;           // from the surface to the lamp's point, or to a mirror's
  Real<D> distance, target;  // of that point, and the lamp's id, or the mirror's
  V3<D> radiance;
  Bool<D> any;  // the lanes that have such light

  Bool<D> by_mirror;      // the lanes in which the ray leads to a mirror
  RayLanes<D> onward;     // from there to the lamp's point
  Real<D> to_lamp, lamp;  // the distance of that point, and the lamp's id
};

// How a path came to the lamp that it has met, if by way of one mirror from a surface that could
// have sampled the lamp in that mirror.
template <class D>
struct ByMirror {
  Real<D> mirror;  // its id, else -1
  Real<D> pdf;     // of the direction to the mirror
  Beam<D> beam;
};

// Multiple importance sampling (MIS): the weight p / (p + q) of a sample with the density p that
// could have been taken with the density q in another way (Veach 1997, section 9.2.2), here from
// q / p.
template <class D>
HWY_INLINE Real<D> balance_heuristic_of_ratio(Real<D> q_over_p) {
  return Real<D>(1) / (Real<D>(1) + q_over_p);
}

// The chances that a path takes, and the weights that make up for them. Without all materials there
// are matte surfaces and perfect mirrors alone, and no time is lost on others.
template <class Lanes, bool AllMaterials>
struct Estimator {
  using D = Lanes;
  using Bsdf = BsdfLanes<D, AllMaterials>;
  static constexpr bool all_materials = AllMaterials;
  using T = hn::TFromD<D>;
  using R = Real<D>;
  using Lamp = PackedLamp<T>;

  // Whether lamps are also sampled by way of a mirror.
  bool looks_into_mirrors() const { return true; }

  explicit Estimator(const TraceJob<PackedScene<T>>&) {}

  HWY_INLINE Sample<D> draw(Sampler sampler, const SampleIndex<D>& index, Bits<D> pair) const {
    return plumb::HWY_NAMESPACE::draw(sampler, index, pair);
  }
  HWY_INLINE BsdfSample<D> sample_bsdf(const Bsdf& bsdf, V3<D> incident, R u, R v) const {
    return bsdf.sample(incident, u, v);
  }
  HWY_INLINE LampSample<D> sample_lamp(const Lamp& lamp, V3<D> p, R u, R v) const {
    return plumb::HWY_NAMESPACE::sample_lamp(lamp, p, u, v);
  }
  HWY_INLINE R inverse_lamp_pdf(const Lamp& lamp, V3<D> p, R distance) const {
    return plumb::HWY_NAMESPACE::inverse_lamp_pdf(lamp, p, distance);
  }

  // Of the two ways to find a lamp's point: by sampling the lamp, and by sampling the BSDF.
  HWY_INLINE R sum_of_pdfs(R lamp, R bsdf) const { return lamp + bsdf; }

  // Is told of the surfaces that paths meet, after so many bounces.
  HWY_INLINE void meet(R, R) {}

  // What light adds to the picture after so many bounces, if it comes from the surface `from` to
  // the vertex that the path had met after `met`: all of it.
  HWY_INLINE V3<D> contribution(V3<D> light, R, R /*met*/, R /*from*/) const { return light; }

  // Russian roulette. Paths dimmer than a third die in part; a third gave the least variance x time
  // on the Cornell box, of 1, 1/1.5, 1/2, 1/2.5, 1/3, 1/4, 1/5 and 1/10.
  HWY_INLINE R survival_probability(V3<D> throughput) const {
    return min(R(1), R(3) * max(throughput.x, max(throughput.y, throughput.z)));
  }
  HWY_INLINE R survivor_weight(R probability) const { return R(1) / probability; }
};

// A vector of paths, one per lane. It estimates the measurement equation (Veach 1997, section 8.1),
// vertex by vertex:
//
//   radiance = sum over vertices of throughput * (weight * emission that the path meets
//                                                 + weight * f * cosine / pdf * a sampled lamp's)
//   throughput = product over vertices of f * cosine / pdf / probability of survival
//
// plain_path_tracer.cpp is the same for one path at a time.
template <class Estimator>
class Packet {
  using D = typename Estimator::D;
  using T = hn::TFromD<D>;
  using R = Real<D>;
  using Table = SurfaceTable<T>;
  using Bsdf = typename Estimator::Bsdf;
  using Interaction = SurfaceInteraction<D, Bsdf>;

 public:
  explicit Packet(const TraceJob<PackedScene<T>>& job)
      : scene_(job.scene),
        settings_(job.settings),
        gathers_(job.scene.surfaces.count > 128),
        estimator_(job),
        looks_into_mirrors_(job.scene.has_mirrored_lamps && job.settings.method != Method::bsdf &&
                            estimator_.looks_into_mirrors()),
        samples_(job) {
    radiance_ = throughput_ = V3<D>(R(0));
    ray_ = {radiance_, radiance_, R(0)};
    pdf_ = depth_ = choice_weights_ = choice_ = R(0);
    alive_ = busy_ = Bool<D>::none();
    light_ = {ray_, R(0), R(0), radiance_, alive_, alive_, ray_, R(0), R(0)};
    surface_ = surface_interaction({R(0), R(0)});
  }

  int64_t rays() const { return rays_; }

  // The bounces so far of the longest path under way.
  T longest_path() const {
    const D d;
    return hn::GetLane(hn::MaxOfLanes(d, select(busy_ & alive_, depth_, R(0)).v));
  }

  // Gives each ended path's lane a new path and each path its next ray: scattered where the path is
  // alive, else from the camera. Returns false once there is nothing left to do.
  bool next_ray() {
    busy_ = samples_.advance(!alive_, radiance_);
    if (!busy_.any()) return false;
    index_ = samples_.index();
    depth_ = select(alive_, depth_, R(0));
    const Sample<D> sample = estimator_.draw(settings_.sampler, index_, pair(direction_pair));
    if (looks_into_mirrors_) remember_mirror();
    choice_ = sample.w;
    scatter(sample);
    const V3<D> from_camera = camera_direction(sample);
    ray_.origin = select(alive_, surface_.point, camera_origin(from_camera));
    ray_.direction = select(alive_, ray_.direction, from_camera);
    ray_.start = select(alive_, surface_.plane, R(-1));
    throughput_ = select(alive_, throughput_, V3<D>(R(1)));
    radiance_ = select(alive_, radiance_, V3<D>(R(0)));
    pdf_ = select(alive_, pdf_, R(delta<T>));
    rays_ += busy_.count();
    return true;
  }

  // Follows the rays to the next vertices and adds the radiance of lamps that they meet.
  void follow() {
    const Hit<D> hit = find_nearest(scene_.shapes, ray_);
    surface_ = surface_interaction(hit);
    estimator_.meet(hit.id, depth_);
    add_emission(hit);
    alive_ = busy_ & surface_.scatters;
    if (!settings_.bounces.is_everything()) {
      alive_ = alive_ & (depth_ < R(static_cast<T>(settings_.bounces.last)));
    }
  }

  // Samples the lamps and plays Russian roulette. The throughput already gets the weight of the
  // scattered direction, which scatter() draws next: it is the same for every direction.
  void shade() {
    const Sample<D> sample = estimator_.draw(settings_.sampler, index_, pair(lamp_pair));
    light_.any = Bool<D>::none();
    if (settings_.method != Method::bsdf) sample_lamps(sample);
    if (looks_into_mirrors_) sample_mirrored_lamps(sample);
    throughput_ = throughput_ * surface_.bsdf.weight();
    russian_roulette(sample.w);
    depth_ = depth_ + R(1);
  }

  // Adds the light of the sampled lamps where nothing is in the way.
  void trace_shadow_rays() {
    if (!light_.any.any()) return;
    rays_ += light_.any.count();
    Bool<D> occluded = is_occluded(scene_.occluders, light_.ray, light_.distance, light_.target);
    if (looks_into_mirrors_ && light_.by_mirror.any()) {
      rays_ += light_.by_mirror.count();
      occluded = occluded | (light_.by_mirror & is_occluded(scene_.occluders, light_.onward,
                                                            light_.to_lamp, light_.lamp));
    }
    const R bounces = depth_ + select(light_.by_mirror, R(1), R(0));
    const V3<D> light =
        estimator_.contribution(light_.radiance, bounces, depth_ - R(1), light_.target);
    radiance_ = radiance_ + select(light_.any & !occluded, light, V3<D>(R(0)));
  }

 private:
  V3<D> camera_direction(const Sample<D>& sample) const {
    const auto& camera = scene_.camera;
    const V3<D> row = fma(V3<D>(camera.y_pixel), samples_.y(sample.v), V3<D>(camera.corner));
    return normalize(fma(V3<D>(camera.x_pixel), samples_.x(sample.u), row));
  }

  // Where a ray has passed all backs through which the camera looks.
  V3<D> camera_origin(V3<D> direction) const {
    const V3<D> origin(scene_.camera.origin);
    if (scene_.camera.backs.empty()) return origin;
    R distance(0);
    for (const Plane<T>& back : scene_.camera.backs) {
      const V3<D> normal(back.normal);
      const R to_plane = -(dot(normal, origin) + R(back.offset)) / dot(normal, direction);
      distance = max(distance, select(to_plane > R(0), to_plane, R(0)));
    }
    return fma(direction, distance * R(T{1.00001f}), origin);
  }

  void scatter(const Sample<D>& sample) {
    const BsdfSample<D> scattered =
        estimator_.sample_bsdf(surface_.bsdf, ray_.direction, sample.u, sample.v);
    ray_.direction = scattered.direction;
    pdf_ = scattered.pdf;
    if (Estimator::all_materials) throughput_ = throughput_ * scattered.factor;
    if (scene_.has_sky) inverse_sky_pdf_ = R::pi() / dot(surface_.bsdf.normal, ray_.direction);
  }

  // Of paths that stand on a mirror, before they leave it.
  void remember_mirror() {
    const Bool<D> sphere = lookup_flag(!scene_.shapes.spheres.empty(), Table::sphere, surface_.id);
    const R curvature = select(sphere, R(1) / lookup(Table::scale, surface_.id), R(0));
    const Bool<D> is_first = alive_ & surface_.bsdf.is_mirror & (pdf_ < R(delta<T>));
    const Bool<D> samples = is_first & (surface_.front | !sphere);
    by_mirror_.mirror = select(samples, surface_.id, R(-1));
    by_mirror_.pdf = pdf_;
    const R cosine = -dot(surface_.bsdf.normal, ray_.direction);
    by_mirror_.beam = Beam<D>(surface_.distance, cosine, curvature);
  }

  // A table of a few dozen surfaces is looked up a vector of rows at a time, which is faster than a
  // gather, but where vectors are short.
  R lookup(int column, R id) const {
    const D d;
    const hn::RebindToSigned<D> di;
    constexpr int lanes = hn::MaxLanes(d);
    const auto row = hn::ConvertTo(di, max(id, R(0)).v);
    if (lanes * sizeof(T) <= 16 || gathers_) {
      return hn::GatherIndex(d, scene_.surfaces.column(column), row);
    }
    const auto index = hn::IndicesFromVec(d, hn::And(row, hn::Set(di, lanes - 1)));
    const T* values = scene_.surfaces.column(column);
    R result = hn::TableLookupLanes(hn::LoadU(d, values), index);
    for (int first = lanes; first < scene_.surfaces.count; first += lanes) {
      const R here = hn::TableLookupLanes(hn::LoadU(d, values + first), index);
      result = select(id >= R(static_cast<T>(first)), here, result);
    }
    return result;
  }

  V3<D> lookup_vector(int column, R id) const {
    return {lookup(column, id), lookup(column + 1, id), lookup(column + 2, id)};
  }

  // Spares the lookup if the scene has no such surface.
  Bool<D> lookup_flag(bool is_used, int column, R id) const {
    return is_used ? lookup(column, id) > R(0) : Bool<D>::none();
  }

  // Puts the point onto its surface, where rounding along the ray has left it beside, and off the
  // surface's edges (see packed_scene.h).
  HWY_INLINE Interaction surface_interaction(const Hit<D>& hit) const {
    V3<D> normal = lookup_vector(Table::normal, hit.id);
    const V3<D> middle = lookup_vector(Table::point, hit.id);
    const V3<D> from_middle = ray_.at(hit.distance) - middle;
    V3<D> along = fma(normal, -dot(normal, from_middle), from_middle);
    if (!scene_.shapes.spheres.empty()) {
      const Bool<D> sphere = lookup_flag(true, Table::sphere, hit.id);
      const V3<D> outward = normalize(from_middle);
      along = select(sphere, outward, along);
      normal = select(sphere, outward, normal);
    }
    const Bool<D> front = dot(normal, ray_.direction) < R(0);
    const Bool<D> two_sided = lookup_flag(scene_.has_two_sided, Table::two_sided, hit.id);
    return {.point = fma(along, lookup(Table::scale, hit.id), middle),
            .bsdf = bsdf(hit.id, select(front, normal, -normal), front),
            .id = hit.id,
            .plane = scene_.has_coplanar ? lookup(Table::plane, hit.id) : hit.id,
            .distance = hit.distance,
            .scatters = (hit.id >= R(0)) & (front | two_sided),
            .front = front};
  }

  HWY_INLINE Bsdf bsdf(R id, V3<D> normal, Bool<D> front) const {
    Bsdf bsdf;
    bsdf.normal = normal;
    bsdf.reflectance = lookup_vector(Table::reflectance, id);
    bsdf.is_mirror = bsdf.is_specular = lookup_flag(scene_.has_mirrors, Table::mirror, id);
    if constexpr (Estimator::all_materials) {
      auto& more = bsdf.more;
      more.incident = ray_.direction;
      more.eta = lookup_vector(Table::eta, id);
      more.k = lookup_vector(Table::k, id);
      more.facets.alpha = lookup(Table::alpha, id);
      more.is_rough = more.facets.alpha > R(0);
      const R cosine = max(-dot(normal, ray_.direction), R(0));
      const V3<D> smooth = bsdf.reflectance * fresnel_of_metal(cosine, more.eta, more.k);
      const R ior = lookup(Table::ior, id);
      more.is_glass = ior > R(0);
      bsdf.is_specular = bsdf.is_mirror | more.is_glass;
      more.n = select(front, ior, R(1) / ior);
      more.gloss = bsdf.reflectance;
      bsdf.reflectance =
          select(more.is_glass, V3<D>(R(1)), select(more.is_rough, more.gloss, smooth));
      more.transmittance = lookup_vector(Table::transmittance, id);
    }
    return bsdf;
  }

  // The lanes for which light after so many bounces belongs to the picture.
  Bool<D> counts(R bounces) const {
    return (bounces >= R(static_cast<T>(settings_.bounces.first))) &
           (bounces <= R(static_cast<T>(settings_.bounces.last)));
  }

  // Adds the emission of lamps that paths have met.
  void add_emission(const Hit<D>& hit) {
    for (const auto& lamp : scene_.lamps) {
      const bool is_sky = lamp.kind == PackedLamp<T>::Kind::sky;
      Bool<D> lit = hit.id == R(lamp.id);
      if (!is_sky) lit = lit & surface_.front;
      if (!settings_.bounces.is_everything()) lit = lit & counts(depth_);
      if (!lit.any()) continue;
      V3<D> light = throughput_ * V3<D>(lamp.radiance);
      const Bool<D> is_delta = pdf_ == R(delta<T>);
      if (looks_into_mirrors_) light = light * weight_by_mirror(lamp, hit.distance);
      if (settings_.method == Method::mis) {
        // MIS: sampling the lamp finds this point with the density choice / inverse; not along
        // a delta's direction, where infinity times 0 would be undefined.
        const R inverse = is_sky ? inverse_sky_pdf_
                                 : estimator_.inverse_lamp_pdf(lamp, ray_.origin, hit.distance);
        const R lamp_over_bsdf = choice_of(lamp) / (pdf_ * inverse);
        const R weight = balance_heuristic_of_ratio(select(is_delta, R(0), lamp_over_bsdf));
        light = light * weight;
        lit = lit & (weight > R(0));  // not where lamp and origin touch and nothing is defined
      } else if (settings_.method == Method::nee) {
        lit = lit & is_delta;
      }
      light = estimator_.contribution(light, depth_, depth_ - R(1), hit.id);
      radiance_ = select(lit, radiance_ + light, radiance_);
    }
  }

  // MIS: the mirror's sampling finds a lamp's point with the density squared distance / (area *
  // cosine). Other paths have the weight 1.
  R weight_by_mirror(const PackedLamp<T>& lamp, R distance) const {
    Bool<D> sampled = Bool<D>::none();
    for (const auto& mirror : lamp.mirrors) {
      sampled = sampled | (by_mirror_.mirror == R(mirror.id()));
    }
    const R cosine = -dot(surface_.bsdf.normal, ray_.direction);
    const R mirror_over_bsdf =
        by_mirror_.beam.squared_distance(distance) / (R(lamp.area) * cosine * by_mirror_.pdf);
    return balance_heuristic_of_ratio(select(sampled, mirror_over_bsdf, R(0)));
  }

  // The chance that a lamp is chosen at the point where the ray begins.
  R choice_of(const PackedLamp<T>& lamp) const {
    if (scene_.lamps.size() == 1) return R(1);
    const R weight = choice_weight<D>(lamp, ray_.origin);
    return select(weight > R(0), weight / choice_weights_, R(0));
  }

  // Next event estimation: a lamp for each path, chosen by what it may send to the point, and a
  // point on it.
  void sample_lamps(const Sample<D>& sample) {
    Bool<D> left = alive_ & !surface_.bsdf.is_specular;
    if (!settings_.bounces.is_everything()) left = left & counts(depth_ + R(1));
    if (scene_.lamps.size() == 1) {
      const auto& lamp = scene_.lamps.front();
      return set_direct_light(lamp, left, R(1), sample_lamp(lamp, sample.u, sample.v));
    }
    choice_weights_ = R(0);
    for (const auto& lamp : scene_.lamps) {
      choice_weights_ = choice_weights_ + choice_weight<D>(lamp, surface_.point);
    }
    const R target = sample.u * choice_weights_;
    R begin(0);
    for (const auto& lamp : scene_.lamps) {
      const R weight = choice_weight<D>(lamp, surface_.point);
      const R end = begin + weight;
      const Bool<D> chosen = left & (target < end);
      left = left & !chosen;
      if (chosen.any()) {
        // Below the last bit of `u`, `w` says where in a rare lamp's share it lies. Rounding may
        // make it a little more than 1, which does the maps no harm.
        const R step = choice_weights_ / weight * R(unit_interval_step<T>);
        const R rare = select(weight < choice_weights_ * R(T{1} / 256), step, R(0));
        const R u = fma(sample.w, rare, (target - begin) / weight);
        set_direct_light(lamp, chosen, weight / choice_weights_, sample_lamp(lamp, u, sample.v));
      }
      begin = end;
    }
  }

  LampSample<D> sample_lamp(const PackedLamp<T>& lamp, R u, R v) const {
    const bool is_sky = lamp.kind == PackedLamp<T>::Kind::sky;
    return is_sky ? sample_sky(surface_.bsdf.normal, u, v)
                  : estimator_.sample_lamp(lamp, surface_.point, u, v);
  }

  // Keeps throughput * f * cosine / p * radiance of the sampled point for the shadow ray. The
  // density p is that of the lamp's choice, `choice`, times that of the direction to the point,
  // 1 / inverse_pdf. With MIS, the balance heuristic's weight is folded in:
  //
  //   f / p * p / (p + q) = f / (p + q)
  void set_direct_light(const PackedLamp<T>& lamp, Bool<D> chosen, R choice,
                        const LampSample<D>& to_lamp) {
    const Bsdf& bsdf = surface_.bsdf;
    const R f_cosine = bsdf.eval(to_lamp.direction);  // over the colour
    R pdf = choice;  // p, then p + q: here and below times inverse_pdf
    if (settings_.method == Method::mis && lamp.kind != PackedLamp<T>::Kind::point) {
      pdf = estimator_.sum_of_pdfs(pdf, bsdf.pdf(to_lamp.direction) * to_lamp.inverse_pdf);
    }
    const V3<D> radiance = throughput_ * bsdf.colour(to_lamp.direction) * V3<D>(lamp.radiance) *
                           (f_cosine * to_lamp.inverse_pdf / pdf);
    // Rounding can put a point of the lamp itself, or of another surface in its plane, before it.
    const Bool<D> apart = surface_.plane != R(lamp.plane);
    chosen = chosen & to_lamp.visible & (f_cosine > R(0)) & apart;
    light_.ray.origin = surface_.point;
    light_.ray.start = surface_.plane;
    light_.ray.direction = select(chosen, to_lamp.direction, light_.ray.direction);
    light_.distance = select(chosen, to_lamp.distance, light_.distance);
    light_.target = select(chosen, R(lamp.id), light_.target);
    light_.radiance = select(chosen, radiance, light_.radiance);
    light_.any = light_.any | chosen;
  }

  // The lamps by way of each mirror: the points that `sample` leads to. Of all that light, and of
  // what sample_lamps() has found, a part is kept in proportion to it, before anything is in the
  // way, and makes up for the rest (a weighted reservoir; Chao, "A general purpose unequal
  // probability sampling plan", Biometrika 69(3), 1982).
  void sample_mirrored_lamps(const Sample<D>& sample) {
    const auto brightness = [](V3<D> light) { return light.x + light.y + light.z; };
    Bool<D> receives = alive_ & !surface_.bsdf.is_specular;
    if (!settings_.bounces.is_everything()) receives = receives & counts(depth_ + R(2));
    light_.by_mirror = Bool<D>::none();
    R sum = select(light_.any, brightness(light_.radiance), R(0));
    R kept = sum;
    for (const auto& lamp : scene_.lamps) {
      if (lamp.mirrors.empty()) continue;
      const LampPoint<D> on_lamp = sample_area<D>(lamp, sample.u, sample.v);
      for (const auto& mirror : lamp.mirrors) {
        const Bool<D> apart = receives & (surface_.plane != R(mirror.plane()));
        const Reflection<D> way = reflect(mirror, apart, surface_.point, on_lamp.point);
        if (!way.exists.any()) continue;
        const V3<D> radiance = mirrored_light(lamp, mirror, way, on_lamp.normal);
        const R more = brightness(radiance);
        const Bool<D> found =
            receives & way.exists & (more > R(0)) & (surface_.plane != R(mirror.plane()));
        if (!found.any()) continue;
        const R target = choice_ * (sum + more);
        const Bool<D> taken = found & (target < more);
        choice_ = select(found, select(taken, target / more, (target - more) / sum), choice_);
        sum = sum + select(found, more, R(0));
        kept = select(taken, more, kept);
        keep_mirrored_lamp(taken, lamp, mirror, way, radiance);
      }
    }
    light_.radiance = light_.radiance * select(kept > R(0), sum / kept, R(0));
  }

  // throughput * f * cosine / (p + q) * radiance, as set_direct_light(); both densities here times
  // inverse_pdf, too.
  V3<D> mirrored_light(const PackedLamp<T>& lamp, const PackedMirror<T>& mirror,
                       const Reflection<D>& way, V3<D> lamp_normal) const {
    const Bsdf& bsdf = surface_.bsdf;
    const R emitter_cosine = max(-dot(lamp_normal, way.onward), R(0));
    const R inverse_pdf = R(lamp.area) * emitter_cosine / way.beam.squared_distance(way.to_lamp);
    V3<D> reflectance(mirror.reflectance);
    if (Estimator::all_materials) {
      const V3<D> between = way.onward - way.direction;  // along the mirror's normal
      const R cosine = R(0.5f) * sqrt(dot(between, between));
      reflectance = reflectance * fresnel_of_metal(cosine, V3<D>(mirror.eta), V3<D>(mirror.k));
    }
    const R pdf = estimator_.sum_of_pdfs(R(1), bsdf.pdf(way.direction) * inverse_pdf);
    return throughput_ * bsdf.colour(way.direction) * reflectance * V3<D>(lamp.radiance) *
           (max(bsdf.eval(way.direction), R(0)) * inverse_pdf / pdf);
  }

  void keep_mirrored_lamp(Bool<D> taken, const PackedLamp<T>& lamp, const PackedMirror<T>& mirror,
                          const Reflection<D>& way, V3<D> radiance) {
    light_.any = light_.any | taken;
    light_.by_mirror = light_.by_mirror | taken;
    light_.radiance = select(taken, radiance, light_.radiance);
    light_.ray.origin = surface_.point;
    light_.ray.start = surface_.plane;
    light_.ray.direction = select(taken, way.direction, light_.ray.direction);
    light_.distance = select(taken, way.beam.to_mirror, light_.distance);
    light_.target = select(taken, R(mirror.id()), light_.target);
    light_.onward.origin = select(taken, way.point, light_.onward.origin);
    light_.onward.direction = select(taken, way.onward, light_.onward.direction);
    light_.onward.start = select(taken, R(mirror.plane()), light_.onward.start);
    light_.to_lamp = select(taken, way.to_lamp, light_.to_lamp);
    light_.lamp = select(taken, R(lamp.id), light_.lamp);
  }

  void russian_roulette(R w) {
    const R probability = estimator_.survival_probability(throughput_);
    throughput_ = throughput_ * estimator_.survivor_weight(probability);
    alive_ = alive_ & (w < probability);
  }

  // The sampler's pairs, two at each depth:
  //
  //   lamp_pair       u the lamp, then, within its share, with v its point; w roulette, rare lamps
  //   direction_pair  u and v the ray's direction: at depth 0 the camera's, else the BSDF's; w the
  //                   lamp itself or one of its mirrors, where the ray leads
  enum Pair : uint32_t { lamp_pair, direction_pair };
  Bits<D> pair(Pair which) const {
    const Bits<D> depth = to_bits(depth_);
    return depth + depth + Bits<D>(which);
  }

  const PackedScene<T>& scene_;
  const Settings& settings_;
  const bool gathers_;  // what a table of many surfaces holds
  Estimator estimator_;
  const bool looks_into_mirrors_;
  LaneSamples<D> samples_;
  SampleIndex<D> index_;
  Bool<D> busy_;   // lanes with a sample
  Bool<D> alive_;  // lanes whose path goes on
  RayLanes<D> ray_;
  R pdf_;                     // of the ray's direction
  R inverse_sky_pdf_ = R(0);  // the same, had the sky been sampled
  R depth_;                   // bounces so far
  V3<D> throughput_, radiance_;
  R choice_weights_;  // of all lamps where the ray begins
  R choice_;          // from 0 to 1: the lamp itself or one of its mirrors
  ByMirror<D> by_mirror_;
  Interaction surface_;
  DirectLight<D> light_;
  int64_t rays_ = 0;
};

// Two packets take turns at each stage: the processor has work from one while the other waits for
// divisions and square roots.
template <class Estimator>
int64_t trace_paths(const TraceJob<PackedScene<typename Estimator::T>>& job) {
  Packet<Estimator> packets[2] = {Packet<Estimator>(job), Packet<Estimator>(job)};
  constexpr int steps_between_questions = 256;  // some milliseconds
  for (int step = 1;; ++step) {
    if (step % steps_between_questions == 0) {
      const auto longest = std::max(packets[0].longest_path(), packets[1].longest_path());
      if (job.is_abandoned(static_cast<int64_t>(longest))) {
        return packets[0].rays() + packets[1].rays();
      }
    }
    bool busy = false;
    for (auto& packet : packets) busy |= packet.next_ray();
    if (!busy) return packets[0].rays() + packets[1].rays();
    for (auto& packet : packets) packet.follow();
    for (auto& packet : packets) packet.shade();
    for (auto& packet : packets) packet.trace_shadow_rays();
  }
}

}  // namespace plumb::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
