// SPDX-License-Identifier: Apache-2.0

// Rays against shapes: every lane's ray is tested against every shape.
#include "renderer/simd/real-inl.h"

#if defined(PLUMB_SIMD_INTERSECT_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PLUMB_SIMD_INTERSECT_INL_H
#undef PLUMB_SIMD_INTERSECT_INL_H
#else
#define PLUMB_SIMD_INTERSECT_INL_H
#endif

HWY_BEFORE_NAMESPACE();
namespace plumb::HWY_NAMESPACE {

// A ray. `direction` is of unit length. `start` is the id of the sphere, or of the plane (see
// Plane::id), on which the origin lies; -1: it lies on none.
template <class D>
struct RayLanes {
  V3<D> origin, direction;
  Real<D> start;

  HWY_INLINE V3<D> at(Real<D> distance) const { return fma(direction, distance, origin); }
};

// Where a ray meets a shape: the distance, whether it does at all, and the surface's id.
template <class D>
struct Intersection {
  Real<D> distance;
  Bool<D> hit;
  Real<D> id;
};

template <class D, typename T>
HWY_INLINE Real<D> signed_distance(const Plane<T>& plane, V3<D> p) {
  using R = Real<D>;
  return fma(R(plane.normal.x), p.x,
             fma(R(plane.normal.y), p.y, fma(R(plane.normal.z), p.z, R(plane.offset))));
}

// Minus signed_distance(), as fast and with the same rounding.
template <class D, typename T>
HWY_INLINE Real<D> distance_below(const Plane<T>& plane, V3<D> p) {
  using R = Real<D>;
  return fnma(R(plane.normal.x), p.x,
              fnma(R(plane.normal.y), p.y, fnms(R(plane.normal.z), p.z, R(plane.offset))));
}

template <class D, typename T>
HWY_INLINE Intersection<D> intersect_plane(const Plane<T>& plane, T id, const RayLanes<D>& ray) {
  const Real<D> cosine = dot(V3<D>(plane.normal), ray.direction);
  const Real<D> distance = distance_below(plane, ray.origin) / cosine;
  return {distance, (distance > Real<D>(0)) & (ray.start != Real<D>(plane.id)), Real<D>(id)};
}

template <class D, typename T>
HWY_INLINE Intersection<D> intersect(const PackedParallelogram<T>& shape, const RayLanes<D>& ray) {
  Intersection<D> found = intersect_plane(shape.plane, shape.id, ray);
  const V3<D> point = ray.at(found.distance);
  const Real<D> outside =
      max(abs(signed_distance(shape.slabs[0], point)), abs(signed_distance(shape.slabs[1], point)));
  found.hit = found.hit & (outside <= Real<D>(1));
  return found;
}

// A triangle or a convex quad, by its edges.
template <class D, typename T>
HWY_INLINE Intersection<D> intersect(const PackedPolygon<T>& shape, const RayLanes<D>& ray) {
  Intersection<D> found = intersect_plane(shape.plane, shape.id, ray);
  const V3<D> point = ray.at(found.distance);
  Real<D> outside = signed_distance(shape.edges[0], point);
  for (int i = 1; i < 4; ++i) outside = max(outside, signed_distance(shape.edges[i], point));
  found.hit = found.hit & (outside <= Real<D>(0));
  return found;
}

// A ray that starts on the sphere itself starts at one of the line's two points on it: the other
// one remains.
template <class D, typename T>
HWY_INLINE Intersection<D> intersect(const PackedSphere<T>& shape, const RayLanes<D>& ray) {
  using R = Real<D>;
  const V3<D> to_center = V3<D>(shape.center) - ray.origin;
  const R middle = dot(to_center, ray.direction);
  const V3<D> aside = fma(ray.direction, -middle, to_center);
  const R squared = R(shape.radius * shape.radius) - dot(aside, aside);
  const R half_chord = sqrt(max(squared, R(0)));
  const Bool<D> starts = ray.start == R(shape.id);
  const R near = middle - half_chord;
  const R far = middle + select(starts, middle, half_chord);
  const R distance = select(starts | (near <= R(0)), far, near);
  return {distance, (squared >= R(0)) & (distance > R(0)), R(shape.id)};
}

// The part of a ray's line that lies in a solid, and the faces at its two ends. A face on which the
// ray starts counts as met long ago, so that a ray that starts towards the outside finds nothing
// and one that starts towards the inside finds the other faces.
template <class D>
struct Chord {
  Real<D> enter, exit, enter_id, exit_id;
};

template <class D, typename T>
HWY_INLINE Chord<D> chord_in(const PackedSolid<T>& solid, const RayLanes<D>& ray) {
  using R = Real<D>;
  const R highest(hwy::HighestValue<T>());
  Chord<D> chord{-highest, highest, R(-1), R(-1)};
  for (const auto& face : solid.faces) {
    const R id(face.id);
    const R cosine = dot(V3<D>(face.plane.normal), ray.direction);
    const R met = distance_below(face.plane, ray.origin) / cosine;
    const R distance = select(ray.start == R(face.plane.id), -highest, met);
    // By the sign bit: a ray along the face is sorted right by its division by either zero.
    const Bool<D> enters = sign_bit(cosine);
    const Bool<D> later = (distance > chord.enter) & enters;
    const Bool<D> sooner = (distance < chord.exit) & !enters;
    chord.enter = select(later, distance, chord.enter);
    chord.enter_id = select(later, id, chord.enter_id);
    chord.exit = select(sooner, distance, chord.exit);
    chord.exit_id = select(sooner, id, chord.exit_id);
  }
  return chord;
}

template <class D, typename T>
HWY_INLINE Intersection<D> intersect(const PackedSolid<T>& solid, const RayLanes<D>& ray) {
  const Chord<D> chord = chord_in(solid, ray);
  const Bool<D> outside = chord.enter > Real<D>(0);
  const Real<D> distance = select(outside, chord.enter, chord.exit);
  return {distance, (chord.enter < chord.exit) & (distance > Real<D>(0)),
          select(outside, chord.enter_id, chord.exit_id)};
}

template <class D>
struct Hit {
  Real<D> distance;
  Real<D> id;  // -1: the ray meets nothing
};

template <class D, class List>
HWY_INLINE void keep_nearest(const List& shapes, const RayLanes<D>& ray, Hit<D>& hit) {
  for (const auto& shape : shapes) {
    const Intersection<D> found = intersect(shape, ray);
    const Bool<D> nearer = found.hit & (found.distance < hit.distance);
    hit.distance = select(nearer, found.distance, hit.distance);
    hit.id = select(nearer, found.id, hit.id);
  }
}

// Calls `visit` with each face of each leaf that a lane's ray enters before its `limit()`, and with
// these lanes. The boxes are so large that a limit never hides a nearer face: whatever the order,
// and whatever other lanes do, a lane finds the same.
template <class D, typename T, class Limit, class Visit>
HWY_INLINE void walk(const PackedTree<T>& tree, const RayLanes<D>& ray, Limit limit, Visit visit) {
  using R = Real<D>;
  if (tree.nodes.empty()) return;
  const V3<D> d = ray.direction;
  const V3<D> inverse(R(1) / d.x, R(1) / d.y, R(1) / d.z);
  const R coordinates[] = {d.x, d.y, d.z};
  int stack[PackedTree<T>::max_levels];
  int levels = 0;
  stack[levels++] = 0;
  while (levels > 0) {
    const int index = stack[--levels];
    const auto& node = tree.nodes[static_cast<size_t>(index)];
    const V3<D> a = (V3<D>(node.low) - ray.origin) * inverse;
    const V3<D> b = (V3<D>(node.high) - ray.origin) * inverse;
    const R enter = max(max(min(a.x, b.x), min(a.y, b.y)), min(a.z, b.z));
    const R exit = min(min(max(a.x, b.x), max(a.y, b.y)), max(a.z, b.z));
    const Bool<D> enters = (enter <= exit) & (exit > R(0)) & (enter <= limit());
    if (!enters.any()) continue;
    for (int i = 0; i < node.count; ++i) {
      visit(tree.faces[static_cast<size_t>(node.first + i)], enters);
    }
    if (node.count > 0) continue;
    // First where most of the rays come from.
    const Bool<D> upwards = enters & (coordinates[node.axis] > R(0));
    const bool lower_first = 2 * upwards.count() >= enters.count();
    stack[levels++] = lower_first ? node.first : index + 1;
    stack[levels++] = lower_first ? index + 1 : node.first;
  }
}

template <class D, typename T>
HWY_INLINE Hit<D> find_nearest(const PackedShapes<T>& shapes, const RayLanes<D>& ray) {
  Hit<D> hit{Real<D>(hwy::HighestValue<T>()), Real<D>(-1)};
  keep_nearest(shapes.parallelograms, ray, hit);
  keep_nearest(shapes.polygons, ray, hit);
  keep_nearest(shapes.spheres, ray, hit);
  keep_nearest(shapes.solids, ray, hit);
  const auto limit = [&hit] { return hit.distance; };
  walk(shapes.tree, ray, limit, [&](const PackedPolygon<T>& face, Bool<D> enters) {
    const Intersection<D> found = intersect(face, ray);
    const Bool<D> first = (found.distance == hit.distance) & (found.id < hit.id);
    const Bool<D> nearer = found.hit & enters & ((found.distance < hit.distance) | first);
    hit.distance = select(nearer, found.distance, hit.distance);
    hit.id = select(nearer, found.id, hit.id);
  });
  return hit;
}

// Adds the lanes in which one of the shapes, other than the target, is nearer than the distance.
template <class D, class List>
HWY_INLINE void add_shadows(const List& shapes, const RayLanes<D>& ray, Real<D> distance,
                            Real<D> target, Bool<D>& shadow) {
  for (const auto& shape : shapes) {
    const Intersection<D> found = intersect(shape, ray);
    shadow = shadow | (found.hit & (found.distance < distance) & (found.id != target));
  }
}

// Whether anything lies between the ray's start and the target's point at that distance: a lamp's,
// or a mirror's.
template <class D, typename T>
HWY_INLINE Bool<D> is_occluded(const PackedShapes<T>& occluders, const RayLanes<D>& ray,
                               Real<D> distance, Real<D> target) {
  Bool<D> shadow = Bool<D>::none();
  add_shadows(occluders.parallelograms, ray, distance, target, shadow);
  add_shadows(occluders.polygons, ray, distance, target, shadow);
  add_shadows(occluders.spheres, ray, distance, target, shadow);
  add_shadows(occluders.solids, ray, distance, target, shadow);
  const auto limit = [&] { return select(shadow, Real<D>(-hwy::HighestValue<T>()), distance); };
  walk(occluders.tree, ray, limit, [&](const PackedPolygon<T>& face, Bool<D> enters) {
    const Intersection<D> found = intersect(face, ray);
    shadow = shadow | (found.hit & enters & (found.distance < distance) & (found.id != target));
  });
  return shadow;
}

}  // namespace plumb::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
