// SPDX-License-Identifier: Apache-2.0

// The mesh of classical radiosity: patches, on each of which radiance is one number.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "radiosity/elements.h"
#include "radiosity/faces.h"

namespace plumb::radiosity::teaching {

// The patch that a ray meets first; none beyond the scene, or if it is the black back of a surface.
struct Hit {
  size_t patch;
  Vec3 point;
};

// All faces, cut into halves until none is larger than wanted. Faces that don't reflect are there,
// too: what they absorb belongs to the balance of energy.
class Patches {
 public:
  // Circles around patches are no larger than `radius`. Without `is_cut`, patches go on below what
  // stands on them. Throws std::runtime_error for more than `most` patches, whose matrix would be
  // too large.
  Patches(const Faces& faces, double radius, bool is_cut, size_t most);

  // With the largest radius that gives at least so many.
  static Patches of_about(const Faces& faces, size_t count, bool is_cut, size_t most);

  const Faces& faces() const { return faces_; }
  const std::vector<Element>& list() const { return list_; }
  const Element& operator[](size_t i) const { return list_[i]; }
  size_t size() const { return list_.size(); }
  std::vector<double> areas() const;

  std::optional<Hit> trace(const Vec3& origin, const Vec3& direction) const;

  // Shared by the patches of a face that have a corner there.
  size_t vertex(size_t patch, size_t corner) const { return vertices_[patch][corner]; }
  // Of the patches around each vertex, by area.
  std::vector<Rgb> mean_at_vertices(const std::vector<Rgb>& values) const;
  // What each corner's value counts at a point of a patch, where values change linearly along the
  // edges: mean value coordinates (Floater, "Mean value coordinates", CAGD 2003).
  std::array<double, 4> weights(size_t i, const Vec3& at) const;
  // Whether an edge of the patch has another one's corner between its ends: a T-vertex.
  std::vector<bool> has_t_vertex() const;

 private:
  struct Node {
    Element element;
    size_t child = 0;  // the first of two; 0: none
    size_t patch = 0;
  };

  void split(size_t node, double radius, size_t most);
  void find_vertices();
  size_t patch_at(size_t face, const Vec3& point) const;

  const Faces& faces_;
  std::vector<Node> nodes_;
  std::vector<std::vector<size_t>> roots_;  // of each face
  std::vector<Element> list_;
  std::vector<std::array<size_t, 4>> vertices_;
  std::vector<Vec3> vertex_points_;
  std::vector<size_t> vertex_faces_;
};

}  // namespace plumb::radiosity::teaching
