// SPDX-License-Identifier: Apache-2.0

// Faces cut into elements on which radiance is linear, and these joined into clusters, on which it
// is taken as linear, too: a binary tree for each face.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "radiosity/eye.h"
#include "radiosity/faces.h"

namespace plumb::radiosity {

// A function over an element: its value at the centre, and by how much it rises along the face's u
// and v over one radius.
template <typename T>
using Linear = std::array<T, 3>;
const Linear<Rgb> dark{Rgb(0.0), Rgb(0.0), Rgb(0.0)};

// Its value where its parts are these; or, of weights, what arrives.
inline Rgb value(const Linear<Rgb>& function, const Vec3& parts) {
  return function[0] * parts.x + function[1] * parts.y + function[2] * parts.z;
}

// Row i: what the parts of one linear function add to part i of another one.
struct Matrix {
  std::array<Vec3, 3> rows{Vec3(0.0), Vec3(0.0), Vec3(0.0)};

  void add_to(Linear<Rgb>& sum, const Linear<Rgb>& factor) const;
};

struct Element {
  static constexpr int most_points = 4;

  size_t face;
  int size;  // corners: a triangle or a quadrilateral
  std::array<Vec3, 4> corners;
  Vec3 center;
  double whole = 0.0;     // its area
  double radius;          // of the circle around the centre that holds it
  double nearness = 0.0;  // Faces::nearness()
  double detail = 0.0;    // Faces::detail() at its centre
  int child = -1;         // the first of two, which are neighbours; -1: none

  // Gauss points, exact for what two linear functions make; the area of each; and what its value
  // adds to the linear function that fits the values best.
  int points = 0;
  std::array<Vec3, most_points> point;
  std::array<double, most_points> area;
  std::array<Vec3, most_points> fit;
  Matrix to_parent, from_parent;  // functions that fit best; what the parent's is here

  Element(const Faces& faces, size_t on, std::span<const Vec3> outline);

  bool has_children() const { return child >= 0; }
  std::span<const Vec3> outline() const { return {corners.data(), size_t(size)}; }
  Frame frame(const Face& of) const { return {center, of.u, of.v, radius}; }
  // The parts of a linear function at a point: 1, x, y.
  Vec3 parts(const Face& of, const Vec3& at) const;
  // Cut across the longer sides, and joined to this element as their parent.
  std::array<Element, 2> halves(const Faces& faces) const;
};

// Triangles and quadrilaterals that make up a face; if `is_cut`, along all that stands on it, so
// that none goes on below that.
std::vector<Element> parts_of(const Faces& faces, size_t face, bool is_cut);

// Parents come before their children.
class Elements {
 public:
  // Coarse ones, finer near edges and contacts. They and their clusters never become more than
  // `most`: instead std::length_error is thrown.
  Elements(const Faces& faces, size_t most);

  // Halves those for which this number is larger than allowed, and their halves, of which it is
  // taken to fall as their radii and nearness do; to an eighth of their radius at most. The more
  // uneven half is halved in any case, so that two levels always differ in their elements.
  void refine(std::vector<double> unevenness, double allowed);

  const Faces& faces() const { return faces_; }
  const std::vector<Element>& list() const { return list_; }
  const Element& operator[](size_t i) const { return list_[i]; }
  size_t size() const { return list_.size(); }
  size_t leaves() const { return (list_.size() + roots_) / 2; }
  // Those that have no parent, the parts of faces that reflect: first to last - 1.
  size_t roots() const { return roots_; }

  // From the leaves to their ancestors, or the other way round: what ancestors have is added.
  void pull(std::vector<Linear<Rgb>>& functions) const;
  void push(std::vector<Linear<Rgb>>& functions) const;

 private:
  void add(Element element);
  void split(size_t i);

  const Faces& faces_;
  std::vector<Element> list_;
  size_t roots_ = 0, most_;
};

}  // namespace plumb::radiosity
