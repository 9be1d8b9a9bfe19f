// SPDX-License-Identifier: Apache-2.0

// What a point of a face sees, in closed form: no sampling, and obstacles cut out exactly.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "radiosity/convex.h"
#include "radiosity/faces.h"
#include "scene/light_origin.h"

namespace plumb::radiosity {

// The form factor from the origin, on a plane with that unit normal, to a polygon that is nowhere
// below that plane, its corners counter-clockwise from the origin: the integral of cosine / pi over
// the directions in which it is seen. By Lambert's formula (Photometria, 1760; Baum, Rushmeier and
// Winget, "Improving radiosity solutions through the use of analytically determined form-factors",
// SIGGRAPH 1989).
double form_factor(const Vec3& normal, const Convex& polygon);

// Where radiance is c0 + c1 x + c2 y, x and y being the distances from `center` along u and v in
// units of `unit`, weights w for these say how much arrives: the irradiance is pi (w, c).
struct Frame {
  Vec3 center, u, v;
  double unit;
};

// At one point at a time; for one thread.
class Eye {
 public:
  explicit Eye(const Faces& faces);

  // To a point of a face, from which it looks to that face's side.
  void move_to(size_t face, const Vec3& point);

  size_t face() const { return face_; }
  const Vec3& point() const { return point_; }

  // Whether it is before the plane of a face, perhaps with something between.
  bool sees_front(size_t face) const;

  // The cones of what stands before some part of a face. They hold until the eye moves.
  void find_cones(size_t face, std::vector<const Cone*>& cones);

  Convex relative(std::span<const Vec3> corners) const;

  // Of a part of a face, relative to the point, with those cones before it. Exact for constant
  // radiance; the linear part is taken at the middle of what is seen, by quadrature.
  Vec3 weights(size_t face, const Convex& part, std::span<const Cone* const> cones,
               const Frame& frame);

  // To what is seen of a face.
  double form_factor_of(size_t face);

  // Irradiance / pi that comes straight from all lamps, or from those that an origin counts.
  Rgb direct(const LightOrigin* origin = nullptr);

 private:
  void find_redundant();
  double see(size_t face, const Convex& part, std::span<const Cone* const> cones);

  const Faces& faces_;
  size_t face_ = 0;
  Vec3 point_;
  std::vector<uint8_t> is_redundant_;  // of polygons: hides nothing that no other one hides
  std::vector<Cone> cones_;            // of whole polygons
  std::vector<uint8_t> known_;         // which of them are known
  std::vector<Cone> cut_;              // of the parts before some face
  std::vector<Convex> pieces_;
};

}  // namespace plumb::radiosity
