// SPDX-License-Identifier: Apache-2.0

// A scene of matte polygons for who computes their exchange of light: faces, and what may stand
// between two of them.
#pragma once

#include <Imath/ImathPlane.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "radiosity/convex.h"
#include "radiosity/work.h"
#include "scene/scene.h"

namespace plumb::radiosity {

// That a scene has anything but matte polygons; says what.
class Refusal : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

// Where a flat thing lies, for who stands before a plane.
enum class Place { before, across, inside, behind };

// One side of a polygon, with the corners counter-clockwise as seen from there.
struct Face {
  Polygon outline;
  Vec3 normal;    // towards that side
  double offset;  // its plane is where dot(normal, p) is this
  Vec3 u, v;      // unit vectors along the plane
  size_t shape, polygon;
  Rgb reflectance, radiance;

  // Whether it ever sends light that it was sent.
  bool reflects() const { return reflectance != Rgb(0.0); }
  bool is_lamp() const { return radiance != Rgb(0.0); }
};

// What one face sees of another one.
struct View {
  bool is_any = false;         // they face each other
  bool is_cut = false;         // by the plane of the one that looks
  std::vector<int> obstacles;  // polygons that may stand between, which no other test has ruled out
};

// Polygons of one shape that bound a convex solid, their fronts outwards; or all of it but what
// lies in one plane, such as the bottom of a box that stands. From where none of that plane's
// outside is seen, whatever hides behind a polygon that turns its back hides behind one that
// doesn't, too.
struct Solid {
  std::vector<size_t> polygons;
  std::optional<Imath::Plane3d> open;  // its normal points outwards
};

// The faces of a scene. Polygons have two faces, or one whose back is black; both sides of each
// stand in the way. In each plane the first of those with the same side up lies on top.
class Faces {
 public:
  // Throws std::invalid_argument, which lists what radiosity can't do, with its names: shapes that
  // are no matte polygons, a sky, point lamps, other filters than `box`; std::length_error if what
  // each pair of faces has between it would need more than `most_bytes`; and Stopped (work.h).
  explicit Faces(const Scene& scene, size_t most_bytes = std::numeric_limits<size_t>::max(),
                 const Work& work = {[](const std::string&) {}, nullptr});

  size_t bytes() const { return bytes_; }  // that the pairs need

  const std::vector<Face>& list() const { return faces_; }
  const Face& operator[](size_t i) const { return faces_[i]; }
  const std::vector<size_t>& lamps() const { return lamps_; }
  size_t polygon_count() const { return fronts_.size(); }
  // The front of each polygon, which is the obstacle.
  const Face& front(size_t polygon) const { return faces_[fronts_[polygon]]; }
  const std::vector<Solid>& solids() const { return solids_; }
  double size() const { return size_; }    // the diagonal of what holds the scene and its camera
  double slack() const { return slack_; }  // closer things touch

  const View& view(size_t from, size_t to) const { return views_[from * faces_.size() + to]; }
  // Where a polygon lies as seen from before the plane of a face.
  Place place(size_t face, size_t polygon) const {
    return places_[face * fronts_.size() + polygon];
  }
  // False if nothing of the polygon is between two flat things: both are on one side of its plane,
  // or it is outside of the box that holds both. True may be wrong.
  bool may_block(size_t polygon, std::span<const Vec3> a, std::span<const Vec3> b) const;
  // From the edges of a polygon.
  double distance(const Vec3& point, size_t polygon) const;
  // Of a circle on a face: its radius over the distance of its centre from the nearest edge before
  // the face, but at most 1. Where it is large, light changes within the circle.
  double nearness(size_t face, const Vec3& center, double radius) const;
  // How fine the light on a face may be around a point: in parts of this as it is elsewhere in
  // parts of the scene's size. A shape that is seen from there casts shadows and light of its own
  // size, or of its distance if that is more. What is a twelfth of the scene, or larger, changes
  // nothing.
  double detail(size_t face, const Vec3& point) const;
  // Of one shape.
  double detail_of(size_t shape) const { return std::min(size_, largest_detail * extents_[shape]); }
  // Whether, in the same plane, the polygon lies on top of the face.
  bool is_on_top(size_t polygon, size_t face) const;

 private:
  void add(const Shape& shape, size_t index);
  void find_extents(size_t shapes);
  void find_places(const Work& work);
  void find_solid(size_t first_polygon);
  void find_views(size_t most_bytes, const Work& work);
  View find_view(size_t from, size_t to) const;

  static constexpr double largest_detail = 12.0;  // in parts of a shape

  std::vector<Face> faces_;
  std::vector<double> extents_;  // of shapes: the diagonals of their boxes
  std::vector<size_t> fronts_, lamps_;
  std::vector<bool> has_back_;
  std::vector<Solid> solids_;
  std::vector<Place> places_;
  std::vector<View> views_;
  size_t bytes_ = 0;
  double size_ = 0.0, slack_ = 0.0;
};

}  // namespace plumb::radiosity
