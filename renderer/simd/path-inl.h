// The path tracer: one path per lane, and a new path in the lane as soon as one ends.
#include "renderer/simd/intersect-inl.h"
#include "renderer/simd/sampler-inl.h"
#include "renderer/simd/warp-inl.h"
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
  explicit LaneSamples(const TraceJob<T>& job) : job_(job) {
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
    LaneBits stored = 0;
    hn::StoreMaskBits(d, finished.m, reinterpret_cast<uint8_t*>(&stored));
    for (uint32_t left = stored; left != 0; left &= left - 1) {
      const auto lane = static_cast<size_t>(std::countr_zero(left));
      const auto bit = static_cast<LaneBits>(1u << lane);
      if ((busy_ & bit) != 0) {
        job_.film.add(pixel_[lane], replicate_[lane], values + lane, lanes);
      }
      busy_ = static_cast<LaneBits>(take_next(lane) ? busy_ | bit : busy_ & ~bit);
    }
    return {hn::LoadMaskBits(d, reinterpret_cast<const uint8_t*>(&busy_))};
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
  static constexpr int64_t pixels_at_once = 64;
  // As wide as the mask is when it is stored: the processor waits where a load is wider than the
  // store before it.
  using LaneBits = std::conditional_t<lanes <= 8, uint8_t, uint16_t>;
  static_assert(lanes <= 16);

  bool take_next(size_t lane) {
    if (++sample_[lane] >= job_.samples.last) {
      if (next_pixel_ == end_pixel_) {
        next_pixel_ = std::min(job_.next_pixel.fetch_add(pixels_at_once), job_.film.pixel_count());
        end_pixel_ = std::min(next_pixel_ + pixels_at_once, job_.film.pixel_count());
        if (next_pixel_ == end_pixel_) return false;
      }
      pixel_[lane] = static_cast<uint32_t>(next_pixel_);
      const int64_t row = next_pixel_ / job_.film.width();
      x_[lane] = static_cast<T>(next_pixel_ - row * job_.film.width());
      y_[lane] = static_cast<T>(row);
      sample_[lane] = job_.samples.first;
      job_.film.open(pixel_[lane]);
      if (!filter_.offsets.empty()) fit_filter(lane);
      ++next_pixel_;
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
    cut(x_[lane], job_.film.width(), left_[lane], width_[lane]);
    cut(y_[lane], job_.film.height(), top_[lane], height_[lane]);
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

  const TraceJob<T>& job_;
  const PackedFilter<T>& filter_ = job_.scene.camera.filter;
  LaneBits busy_ = 0;  // a bit for each lane that has a sample
  int64_t next_pixel_ = 0;
  int64_t end_pixel_ = 0;
  int64_t sample_[lanes];
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

// Where paths have arrived: a point, the normal on the side that they came from, and the surface.
template <class D>
struct Vertex {
  V3<D> point, normal, reflectance;
  Real<D> id, plane;
  Bool<D> scatters;  // neither in the void nor on a black back
  Bool<D> front;
  Bool<D> mirror;
};

// Light on its way from a lamp to the vertices, shadows not yet looked at.
template <class D>
struct DirectLight {
  Ray<D> ray;
  Real<D> distance, lamp;  // of the lamp's point, the lamp's id
  V3<D> radiance;
  Bool<D> any;
};

// The chances that a path takes, and the weights that make up for them.
template <class Lanes>
struct Estimator {
  using D = Lanes;
  using T = hn::TFromD<D>;
  using R = Real<D>;
  using Lamp = PackedLamp<T>;

  explicit Estimator(const TraceJob<T>&) {}

  HWY_INLINE Sample<D> draw(Sampler sampler, const SampleIndex<D>& index, Bits<D> pair) const {
    return plumb::HWY_NAMESPACE::draw(sampler, index, pair);
  }
  HWY_INLINE V3<D> sample_direction(V3<D> normal, R u, R v) const {
    return sample_cosine_hemisphere(frame_around(normal), u, v);
  }
  HWY_INLINE LampSample<D> sample_lamp(const Lamp& lamp, V3<D> p, R u, R v) const {
    return plumb::HWY_NAMESPACE::sample_lamp(lamp, p, u, v);
  }
  HWY_INLINE R inverse_lamp_pdf(const Lamp& lamp, V3<D> p, R distance) const {
    return plumb::HWY_NAMESPACE::inverse_lamp_pdf(lamp, p, distance);
  }

  // The balance heuristic for a sampled lamp: both densities, in units of the lamp's.
  HWY_INLINE R sum_of_pdfs(R lamp, R direction) const { return lamp + direction; }

  // What light adds to the picture after so many bounces: all of it.
  HWY_INLINE V3<D> contribution(V3<D> light, R) const { return light; }

  // Russian roulette. Paths dimmer than a third die in part; a third gave the least variance x time
  // on the Cornell box, of 1, 1/1.5, 1/2, 1/2.5, 1/3, 1/4, 1/5 and 1/10.
  HWY_INLINE R survival(V3<D> throughput) const {
    return min(R(1), R(3) * max(throughput.x, max(throughput.y, throughput.z)));
  }
  HWY_INLINE R survivor_weight(R survival) const { return R(1) / survival; }
};

// A vector of paths, one per lane. The renderer is the measurement equation, vertex by vertex:
//
//   radiance = sum over vertices of throughput * (emission met by chance + light of a sampled lamp)
//   throughput = product over vertices of bsdf * cosine / pdf / survival
template <class Estimator>
class Packet {
  using D = typename Estimator::D;
  using T = hn::TFromD<D>;
  using R = Real<D>;
  using Table = SurfaceTable<T>;

 public:
  explicit Packet(const TraceJob<T>& job)
      : scene_(job.scene),
        settings_(job.settings),
        gathers_(job.scene.surfaces.count > 128),
        estimator_(job),
        samples_(job) {
    radiance_ = throughput_ = V3<D>(R(0));
    ray_ = {V3<D>(R(0)), V3<D>(R(0)), R(0)};
    pdf_ = depth_ = R(0);
    alive_ = busy_ = Bool<D>::none();
    light_ = {ray_, R(0), R(0), radiance_, alive_};
    vertex_ = arrive({R(0), R(0)});
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
    const Sample<D> sample = estimator_.draw(settings_.sampler, index_, pair(1));
    scatter(sample);
    ray_.origin = select(alive_, vertex_.point, V3<D>(scene_.camera.origin));
    ray_.backward = select(alive_, ray_.backward, backward_from_camera(sample));
    ray_.leaves = select(alive_, vertex_.plane, R(-1));
    throughput_ = select(alive_, throughput_, V3<D>(R(1)));
    radiance_ = select(alive_, radiance_, V3<D>(R(0)));
    pdf_ = select(alive_, pdf_, R(certain));
    rays_ += busy_.count();
    return true;
  }

  // Follows the rays to the next vertices and adds the radiance of lamps that they meet.
  void follow() {
    const Hit<D> hit = find_nearest(scene_.shapes, ray_);
    vertex_ = arrive(hit);
    add_emission(hit);
    alive_ = busy_ & vertex_.scatters;
    if (!settings_.bounces.is_everything()) {
      alive_ = alive_ & (depth_ < R(static_cast<T>(settings_.bounces.last)));
    }
    throughput_ = throughput_ * vertex_.reflectance;
  }

  // Samples the lamps, and plays Russian roulette.
  void sample_lamps() {
    const Sample<D> sample = estimator_.draw(settings_.sampler, index_, pair(0));
    light_.any = Bool<D>::none();
    if (settings_.method != Method::bsdf) choose_lamps(sample);
    survive(sample.w);
    depth_ = depth_ + R(1);
  }

  // Adds the light of the sampled lamps where nothing is in the way.
  void add_direct_light() {
    if (!light_.any.any()) return;
    rays_ += light_.any.count();
    const Bool<D> occluded =
        is_occluded(scene_.occluders, light_.ray, light_.distance, light_.lamp);
    radiance_ = radiance_ + select(light_.any & !occluded, light_.radiance, V3<D>(R(0)));
  }

 private:
  V3<D> backward_from_camera(const Sample<D>& sample) const {
    const auto& camera = scene_.camera;
    const V3<D> row = fma(V3<D>(camera.y_pixel), samples_.y(sample.v), V3<D>(camera.corner));
    return -normalize(fma(V3<D>(camera.x_pixel), samples_.x(sample.u), row));
  }

  void scatter(const Sample<D>& sample) {
    const V3<D> normal = vertex_.normal;
    const V3<D> direction = estimator_.sample_direction(normal, sample.u, sample.v);
    pdf_ = dot(normal, direction) * R::inverse_pi();
    const V3<D> arrived = ray_.backward;
    ray_.backward = -direction;
    if (!scene_.has_mirrors) return;
    const V3<D> reflected = normalize(fma(normal, R(-2) * dot(normal, arrived), arrived));
    ray_.backward = select(vertex_.mirror, reflected, ray_.backward);
    pdf_ = select(vertex_.mirror, R(certain), pdf_);
  }

  // A table of a few dozen surfaces is looked up a vector of rows at a time, which is faster than a
  // gather.
  R lookup(int column, R id) const {
    const D d;
    const hn::RebindToSigned<D> di;
    constexpr int lanes = hn::MaxLanes(d);
    const auto row = hn::ConvertTo(di, max(id, R(0)).v);
    if (gathers_) {
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
  HWY_INLINE Vertex<D> arrive(const Hit<D>& hit) const {
    Vertex<D> vertex;
    vertex.id = hit.id;
    vertex.plane = scene_.has_coplanar ? lookup(Table::plane, hit.id) : hit.id;
    vertex.normal = lookup_vector(Table::normal, hit.id);
    vertex.reflectance = lookup_vector(Table::reflectance, hit.id);
    const V3<D> middle = lookup_vector(Table::point, hit.id);
    const V3<D> from_middle = ray_.at(hit.distance) - middle;
    V3<D> along = fma(vertex.normal, -dot(vertex.normal, from_middle), from_middle);
    if (!scene_.shapes.spheres.empty()) {
      const Bool<D> sphere = lookup_flag(true, Table::sphere, hit.id);
      const V3<D> outward = normalize(from_middle);
      along = select(sphere, outward, along);
      vertex.normal = select(sphere, outward, vertex.normal);
    }
    vertex.point = fma(along, lookup(Table::scale, hit.id), middle);
    vertex.front = dot(vertex.normal, ray_.backward) > R(0);
    const Bool<D> two_sided = lookup_flag(scene_.has_two_sided, Table::two_sided, hit.id);
    vertex.scatters = (hit.id >= R(0)) & (vertex.front | two_sided);
    vertex.mirror = lookup_flag(scene_.has_mirrors, Table::mirror, hit.id);
    vertex.normal = select(vertex.front, vertex.normal, -vertex.normal);
    return vertex;
  }

  // The lanes for which light after so many bounces belongs to the picture.
  Bool<D> counts(R bounces) const {
    return (bounces >= R(static_cast<T>(settings_.bounces.first))) &
           (bounces <= R(static_cast<T>(settings_.bounces.last)));
  }

  // Radiance of a lamp that the path has met, weighted by the chance that sampling the lamp would
  // have found it instead.
  void add_emission(const Hit<D>& hit) {
    for (const auto& lamp : scene_.lamps) {
      Bool<D> lit = (hit.id == R(lamp.id)) & vertex_.front;
      if (!settings_.bounces.is_everything()) lit = lit & counts(depth_);
      if (!lit.any()) continue;
      V3<D> light = throughput_ * V3<D>(lamp.radiance);
      if (settings_.method == Method::mis) {
        // The balance heuristic: pdf / (pdf + probability / inverse).
        const R inverse = estimator_.inverse_lamp_pdf(lamp, ray_.origin, hit.distance);
        const R weight = R(1) / (R(1) + R(lamp.probability) / (pdf_ * inverse));
        light = light * weight;
        lit = lit & (weight > R(0));  // not where lamp and vertex touch and nothing is defined
      } else if (settings_.method == Method::nee) {
        lit = lit & (pdf_ == R(certain));
      }
      radiance_ = select(lit, radiance_ + estimator_.contribution(light, depth_), radiance_);
    }
  }

  // A lamp for each path, chosen by its power, and a point on it.
  void choose_lamps(const Sample<D>& sample) {
    Bool<D> left = alive_ & !vertex_.mirror;
    if (!settings_.bounces.is_everything()) left = left & counts(depth_ + R(1));
    for (const auto& lamp : scene_.lamps) {
      const bool is_last = &lamp == &scene_.lamps.back();
      const Bool<D> chosen = is_last ? left : left & (sample.u < R(lamp.choice_end));
      left = left & !chosen;
      if (!chosen.any()) continue;
      // Rounding may make it a little more than 1, which does the maps no harm.
      const R u = (sample.u - R(lamp.choice_begin)) / R(lamp.probability);
      send_light(lamp, chosen, estimator_.sample_lamp(lamp, vertex_.point, u, sample.v));
    }
  }

  void send_light(const PackedLamp<T>& lamp, Bool<D> chosen, const LampSample<D>& to_lamp) {
    const R cosine = dot(vertex_.normal, to_lamp.direction);
    // Rounding can put a point of the lamp itself, or of another surface in its plane, before it.
    const Bool<D> apart = vertex_.plane != R(lamp.plane);
    chosen = chosen & to_lamp.visible & (cosine > R(0)) & apart;
    // cosine / pi / pdf, where the balance heuristic adds the pdf of scattering there, cosine / pi.
    const R share = cosine * R::inverse_pi() * to_lamp.inverse_pdf;
    R probability(lamp.probability);
    if (settings_.method == Method::mis) probability = estimator_.sum_of_pdfs(probability, share);
    const V3<D> radiance = throughput_ * V3<D>(lamp.radiance) * (share / probability);
    light_.ray.origin = vertex_.point;
    light_.ray.leaves = vertex_.plane;
    light_.ray.backward = select(chosen, -to_lamp.direction, light_.ray.backward);
    light_.distance = select(chosen, to_lamp.distance, light_.distance);
    light_.lamp = select(chosen, R(lamp.id), light_.lamp);
    const V3<D> counted = estimator_.contribution(radiance, depth_ + R(1));
    light_.radiance = select(chosen, counted, light_.radiance);
    light_.any = light_.any | chosen;
  }

  // Russian roulette.
  void survive(R w) {
    const R survival = estimator_.survival(throughput_);
    throughput_ = throughput_ * estimator_.survivor_weight(survival);
    alive_ = alive_ & (w < survival);
  }

  // The sampler's pairs: two for each bounce, the ray's direction and the lamp.
  Bits<D> pair(uint32_t which) const {
    const Bits<D> depth = to_bits(depth_);
    return depth + depth + Bits<D>(which);
  }

  // The density of a direction that could not have been another: the camera's or a mirror's.
  static constexpr T certain = std::numeric_limits<T>::infinity();

  const PackedScene<T>& scene_;
  const Settings& settings_;
  const bool gathers_;  // what a table of many surfaces holds
  Estimator estimator_;
  LaneSamples<D> samples_;
  SampleIndex<D> index_;
  Bool<D> busy_;   // lanes with a sample
  Bool<D> alive_;  // lanes whose path goes on
  Ray<D> ray_;
  R pdf_;    // of the ray's direction
  R depth_;  // bounces so far
  V3<D> throughput_, radiance_;
  Vertex<D> vertex_;
  DirectLight<D> light_;
  int64_t rays_ = 0;
};

// Two packets take turns at each stage: the processor has work from one while the other waits for
// divisions and square roots.
template <class Estimator>
int64_t trace_paths(const TraceJob<typename Estimator::T>& job) {
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
    for (auto& packet : packets) packet.sample_lamps();
    for (auto& packet : packets) packet.add_direct_light();
  }
}

}  // namespace plumb::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
