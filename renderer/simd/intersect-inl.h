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

// A ray and the id of the plane or sphere that it leaves, -1 for none. `backward` is the opposite
// of its direction, of unit length: a point at a distance is origin - distance * backward.
template <class D>
struct Ray {
  V3<D> origin, backward;
  Real<D> leaves;

  HWY_INLINE V3<D> at(Real<D> distance) const { return fma(backward, -distance, origin); }
};

// Where a ray meets a shape: the distance, whether it does at all, and the surface's id.
template <class D>
struct Crossing {
  Real<D> distance;
  Bool<D> hit;
  Real<D> id;
};

template <class D, typename T>
HWY_INLINE Real<D> height(const Plane<T>& plane, V3<D> p) {
  using R = Real<D>;
  return fma(R(plane.normal.x), p.x,
             fma(R(plane.normal.y), p.y, fma(R(plane.normal.z), p.z, R(plane.offset))));
}

template <class D, typename T>
HWY_INLINE Crossing<D> cross_plane(const Plane<T>& plane, T id, const Ray<D>& ray) {
  const Real<D> distance = height(plane, ray.origin) / dot(V3<D>(plane.normal), ray.backward);
  return {distance, (distance > Real<D>(0)) & (ray.leaves != Real<D>(plane.id)), Real<D>(id)};
}

template <class D, typename T>
HWY_INLINE Crossing<D> cross(const PackedParallelogram<T>& shape, const Ray<D>& ray) {
  Crossing<D> crossing = cross_plane(shape.plane, shape.id, ray);
  const V3<D> point = ray.at(crossing.distance);
  const Real<D> outside =
      max(abs(height(shape.slabs[0], point)), abs(height(shape.slabs[1], point)));
  crossing.hit = crossing.hit & (outside <= Real<D>(1));
  return crossing;
}

template <class D, typename T>
HWY_INLINE Crossing<D> cross(const PackedPolygon<T>& shape, const Ray<D>& ray) {
  Crossing<D> crossing = cross_plane(shape.plane, shape.id, ray);
  const V3<D> point = ray.at(crossing.distance);
  Real<D> outside = height(shape.edges[0], point);
  for (int i = 1; i < 4; ++i) outside = max(outside, height(shape.edges[i], point));
  crossing.hit = crossing.hit & (outside <= Real<D>(0));
  return crossing;
}

// A ray that leaves the sphere itself starts at one of the two crossings: the other one remains.
template <class D, typename T>
HWY_INLINE Crossing<D> cross(const PackedSphere<T>& shape, const Ray<D>& ray) {
  using R = Real<D>;
  const V3<D> from_center = ray.origin - V3<D>(shape.center);
  const R middle = dot(from_center, ray.backward);
  const V3<D> aside = fma(ray.backward, -middle, from_center);
  const R squared = R(shape.radius * shape.radius) - dot(aside, aside);
  const R half_chord = sqrt(max(squared, R(0)));
  const Bool<D> leaves = ray.leaves == R(shape.id);
  const R near = middle - half_chord;
  const R far = middle + select(leaves, middle, half_chord);
  const R distance = select(leaves | (near <= R(0)), far, near);
  return {distance, (squared >= R(0)) & (distance > R(0)), R(shape.id)};
}

// The part of a ray's line that lies in a solid, and the faces at its two ends. A face that the ray
// leaves counts as crossed long ago, so that a ray that leaves for the outside finds nothing and
// one that leaves for the inside finds the other faces.
template <class D>
struct Passage {
  Real<D> enter, exit, enter_id, exit_id;
};

template <class D, typename T>
HWY_INLINE Passage<D> pass(const PackedSolid<T>& solid, const Ray<D>& ray) {
  using R = Real<D>;
  const R highest(hwy::HighestValue<T>());
  Passage<D> passage{-highest, highest, R(-1), R(-1)};
  for (const auto& face : solid.faces) {
    const R id(face.id);
    const R approach = dot(V3<D>(face.plane.normal), ray.backward);
    const R crossed = height(face.plane, ray.origin) / approach;
    const R distance = select(ray.leaves == R(face.plane.id), -highest, crossed);
    // By the sign bit: a ray along the face is sorted right by its division by either zero.
    const Bool<D> exits = sign_bit(approach);
    const Bool<D> later = (distance > passage.enter) & !exits;
    const Bool<D> sooner = exits & (distance < passage.exit);
    passage.enter = select(later, distance, passage.enter);
    passage.enter_id = select(later, id, passage.enter_id);
    passage.exit = select(sooner, distance, passage.exit);
    passage.exit_id = select(sooner, id, passage.exit_id);
  }
  return passage;
}

template <class D, typename T>
HWY_INLINE Crossing<D> cross(const PackedSolid<T>& solid, const Ray<D>& ray) {
  const Passage<D> passage = pass(solid, ray);
  const Bool<D> outside = passage.enter > Real<D>(0);
  const Real<D> distance = select(outside, passage.enter, passage.exit);
  return {distance, (passage.enter < passage.exit) & (distance > Real<D>(0)),
          select(outside, passage.enter_id, passage.exit_id)};
}

template <class D>
struct Hit {
  Real<D> distance;
  Real<D> id;  // -1: the ray meets nothing
};

template <class D, class List>
HWY_INLINE void keep_nearest(const List& shapes, const Ray<D>& ray, Hit<D>& hit) {
  for (const auto& shape : shapes) {
    const Crossing<D> crossing = cross(shape, ray);
    const Bool<D> nearer = crossing.hit & (crossing.distance < hit.distance);
    hit.distance = select(nearer, crossing.distance, hit.distance);
    hit.id = select(nearer, crossing.id, hit.id);
  }
}

// Calls `visit` with each face of each leaf that a lane's ray enters before its `limit()`, and with
// these lanes. The boxes are so large that a limit never hides a nearer face: whatever the order,
// and whatever other lanes do, a lane finds the same.
template <class D, typename T, class Limit, class Visit>
HWY_INLINE void walk(const PackedTree<T>& tree, const Ray<D>& ray, Limit limit, Visit visit) {
  using R = Real<D>;
  if (tree.nodes.empty()) return;
  const V3<D> inverse(R(1) / ray.backward.x, R(1) / ray.backward.y, R(1) / ray.backward.z);
  const Real<D> coordinates[] = {ray.backward.x, ray.backward.y, ray.backward.z};
  int stack[PackedTree<T>::most_levels];
  int levels = 0;
  stack[levels++] = 0;
  while (levels > 0) {
    const int index = stack[--levels];
    const auto& node = tree.nodes[static_cast<size_t>(index)];
    const V3<D> a = (ray.origin - V3<D>(node.low)) * inverse;
    const V3<D> b = (ray.origin - V3<D>(node.high)) * inverse;
    const R enter = max(max(min(a.x, b.x), min(a.y, b.y)), min(a.z, b.z));
    const R exit = min(min(max(a.x, b.x), max(a.y, b.y)), max(a.z, b.z));
    const Bool<D> enters = (enter <= exit) & (exit > R(0)) & (enter <= limit());
    if (!enters.any()) continue;
    for (int i = 0; i < node.count; ++i) {
      visit(tree.faces[static_cast<size_t>(node.first + i)], enters);
    }
    if (node.count > 0) continue;
    // First where most of the rays come from.
    const Bool<D> upwards = enters & (coordinates[node.axis] < R(0));
    const bool lower_first = 2 * upwards.count() >= enters.count();
    stack[levels++] = lower_first ? node.first : index + 1;
    stack[levels++] = lower_first ? index + 1 : node.first;
  }
}

template <class D, typename T>
HWY_INLINE Hit<D> find_nearest(const PackedShapes<T>& shapes, const Ray<D>& ray) {
  Hit<D> hit{Real<D>(hwy::HighestValue<T>()), Real<D>(-1)};
  keep_nearest(shapes.parallelograms, ray, hit);
  keep_nearest(shapes.polygons, ray, hit);
  keep_nearest(shapes.spheres, ray, hit);
  keep_nearest(shapes.solids, ray, hit);
  const auto limit = [&hit] { return hit.distance; };
  walk(shapes.tree, ray, limit, [&](const PackedPolygon<T>& face, Bool<D> enters) {
    const Crossing<D> crossing = cross(face, ray);
    const Bool<D> first = (crossing.distance == hit.distance) & (crossing.id < hit.id);
    const Bool<D> nearer = crossing.hit & enters & ((crossing.distance < hit.distance) | first);
    hit.distance = select(nearer, crossing.distance, hit.distance);
    hit.id = select(nearer, crossing.id, hit.id);
  });
  return hit;
}

// Adds the lanes in which one of the shapes, other than the lamp, is nearer than the distance.
template <class D, class List>
HWY_INLINE void add_shadows(const List& shapes, const Ray<D>& ray, Real<D> distance, Real<D> lamp,
                            Bool<D>& shadow) {
  for (const auto& shape : shapes) {
    const Crossing<D> crossing = cross(shape, ray);
    shadow = shadow | (crossing.hit & (crossing.distance < distance) & (crossing.id != lamp));
  }
}

// Whether anything lies between the ray's start and the lamp's point at that distance.
template <class D, typename T>
HWY_INLINE Bool<D> is_occluded(const PackedShapes<T>& occluders, const Ray<D>& ray,
                               Real<D> distance, Real<D> lamp) {
  Bool<D> shadow = Bool<D>::none();
  add_shadows(occluders.parallelograms, ray, distance, lamp, shadow);
  add_shadows(occluders.polygons, ray, distance, lamp, shadow);
  add_shadows(occluders.spheres, ray, distance, lamp, shadow);
  for (const auto& solid : occluders.solids) {  // never a lamp: the faces' ids don't matter
    const Crossing<D> crossing = cross(solid, ray);
    shadow = shadow | (crossing.hit & (crossing.distance < distance));
  }
  const auto limit = [&] { return select(shadow, Real<D>(-hwy::HighestValue<T>()), distance); };
  walk(occluders.tree, ray, limit, [&](const PackedPolygon<T>& face, Bool<D> enters) {
    const Crossing<D> crossing = cross(face, ray);
    shadow =
        shadow | (crossing.hit & enters & (crossing.distance < distance) & (crossing.id != lamp));
  });
  return shadow;
}

}  // namespace plumb::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
