// SPDX-License-Identifier: Apache-2.0

// A scene laid out for the tracer: flat records of float or double that every lane tests in turn.
//
// The scene is moved so that the middle of its bounding box is the origin and scaled so that the
// box's half diagonal is 1, in double precision. Rounding is then the same for a scene that is a
// thousand times as large or that lies far from the origin. Radiance does not change with scale.
//
// Rounding can't open the joint between two surfaces: flat ones are grown at their edges by a bound
// on the error of a hit point, so that no ray gets through between them, and hit points are drawn
// towards the middle of their surface by four times as much, so that none lies beyond a joint. A
// path never hits the flat surface on which it starts, nor another one in the same plane, because
// these are not tested.
//
// Ids of surfaces are whole numbers stored as T: lanes hold nothing else.
#pragma once

#include <vector>

#include "scene/scene.h"

namespace plumb {

template <typename T>
struct PackedVec3 {
  T x, y, z;
};

// The signed distance of a point p from a plane is dot(normal, p) + offset.
template <typename T>
struct Plane {
  PackedVec3<T> normal;
  T offset;
  T id = -2;  // of the first surface that lies in it, whichever side it faces
};

// A point of the plane is inside where its signed distances from both slabs are from -1 to 1.
template <typename T>
struct PackedParallelogram {
  Plane<T> plane;
  Plane<T> slabs[2];
  T id;
};

// A point of the plane is inside where its signed distance from no edge is positive. A triangle
// repeats its last edge.
template <typename T>
struct PackedPolygon {
  Plane<T> plane;
  Plane<T> edges[4];
  T id;
};

template <typename T>
struct PackedSphere {
  PackedVec3<T> center;
  T radius;
  T id;
};

// A closed convex mesh: the points whose signed distance from none of its faces is positive.
template <typename T>
struct PackedSolid {
  struct Face {
    Plane<T> plane;
    T id;
  };
  std::vector<Face> faces;
};

// The faces of large meshes below a binary tree of boxes: those of a leaf stand one after the
// other.
template <typename T>
struct PackedTree {
  struct Node {
    PackedVec3<T> low, high;  // contain the faces, grown by the rounding error
    int first;  // of a leaf: its first face; else the second child, the first one follows the node
    int count;  // of a leaf's faces; else 0
    int axis;   // along which the children are split: the first one lies lower
  };
  static constexpr int max_levels = 64;

  std::vector<Node> nodes;
  std::vector<PackedPolygon<T>> faces;
};

template <typename T>
struct PackedShapes {
  std::vector<PackedParallelogram<T>> parallelograms;
  std::vector<PackedPolygon<T>> polygons;
  std::vector<PackedSolid<T>> solids;
  std::vector<PackedSphere<T>> spheres;
  PackedTree<T> tree;
};

// A mirror: a flat face, or a sphere seen from outside.
template <typename T>
struct PackedMirror {
  bool is_sphere;
  bool two_sided;
  PackedPolygon<T> face;
  PackedSphere<T> sphere;
  PackedVec3<T> reflectance, eta, k;

  T id() const { return is_sphere ? sphere.id : face.id; }
  T plane() const { return is_sphere ? sphere.id : face.plane.id; }
};

// The samplers' numbers from 0 to 1 are multiples of this.
template <typename T>
constexpr T unit_interval_step = sizeof(T) == sizeof(float) ? T{0x1p-24f} : T{0x1p-31f};

// What emits light: an emitter, as others call it. A rectangle has unit vectors x, y along its
// sides from the corner `origin`; a triangle has the corners origin, origin + x, origin + y; a
// sphere has its centre there; a point is there, and its `radiance` is its intensity. The sky has
// the id of rays that meet nothing.
template <typename T>
struct PackedLamp {
  enum class Kind { rectangle, triangle, sphere, point, sky };
  Kind kind;
  T id;
  T plane;  // Plane::id; of a sphere its own id
  PackedVec3<T> radiance;
  PackedVec3<T> middle;
  T squared_reach;  // of its farthest point from there
  T strength;  // radiance, in that of the brightest lamp, times the area that is seen from afar
  PackedVec3<T> origin;
  PackedVec3<T> x;
  PackedVec3<T> y;
  PackedVec3<T> normal;
  T x_length;
  T y_length;
  T area;
  T radius;
  std::vector<PackedMirror<T>> mirrors;  // by way of which it is sampled, too
};

// What shading needs, one array per value, looked up by surface id. `point` is the middle of a flat
// surface or the centre of a sphere. A hit point goes to point + scale * v, where v leads from
// `point` to the hit point along a flat surface, or is the unit vector towards it from a centre:
// scale is just below 1, or the radius.
template <typename T>
struct SurfaceTable {
  enum Column {  // three values each: normal to k
    normal = 0,
    point = 3,
    reflectance = 6,
    transmittance = 9,
    eta = 12,
    k = 15,
    scale = 18,
    plane,  // Plane::id; of a sphere its own id
    sphere,
    mirror,
    alpha,  // of a rough metal, else 0
    ior,    // of a dielectric, else 0
    two_sided
  };
  static constexpr int columns = 25;

  int count = 0;   // of surfaces
  int stride = 0;  // a multiple of 64 above that
  std::vector<T> values;

  const T* column(int c) const { return values.data() + size_t(c) * size_t(stride); }
  T* column(int c) { return values.data() + size_t(c) * size_t(stride); }
};

// Where in a pixel's filter a number from 0 to 1 lies, along x or y: `offsets` from the pixel's
// middle, in pixels, that have even shares of the filter's weight between them.
template <typename T>
struct PackedFilter {
  std::vector<T> offsets;       // none: the pixel's own square
  bool crosses_border = false;  // or it is cut at the picture's border, as Mitsuba does by default

  // The share of the weight below an offset.
  T share_below(T offset) const;
};

template <typename T>
struct PackedCamera {
  PackedVec3<T> origin;
  PackedVec3<T> corner;   // direction through the image's top left corner
  PackedVec3<T> x_pixel;  // step to the next pixel to the right
  PackedVec3<T> y_pixel;  // step to the next pixel below
  PackedFilter<T> filter;
  int width;
  int height;
  std::vector<Plane<T>> backs{};  // behind which it is, and through which it looks
};

template <typename T>
struct PackedScene {
  PackedCamera<T> camera;
  PackedShapes<T> shapes;
  // The shapes that can stand between two points on surfaces: all but those flat ones that have
  // the whole scene on one side. They are all where there is a sky, or lamps that are points.
  PackedShapes<T> occluders;
  std::vector<PackedLamp<T>> lamps;
  SurfaceTable<T> surfaces;
  bool has_mirrors = false;
  bool has_all_materials = false;  // others than diffuse ones and perfect mirrors
  bool has_sky = false;
  bool has_mirrored_lamps = false;
  bool has_two_sided = false;
  bool has_coplanar = false;

  explicit PackedScene(const Scene& scene);
};

// How far PackedScene<float> grows flat surfaces, in the scene's own units.
double float_growth(const Scene& scene);

extern template struct PackedScene<float>;
extern template struct PackedScene<double>;

}  // namespace plumb
