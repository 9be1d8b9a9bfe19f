// SPDX-License-Identifier: Apache-2.0

// The scene model: what a picture is of, in the scene file's own units and in double precision.
//
// Coordinates are right-handed. Colours are linear RGB with Rec. 709 primaries. Radiance has no
// unit beyond that: a scene is consistent in itself.
#pragma once

#include <Imath/ImathBox.h>
#include <Imath/ImathVec.h>

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <variant>
#include <vector>

namespace plumb {

using Vec3 = Imath::V3d;
using Rgb = Imath::V3d;

// A planar convex polygon of three or four corners, counter-clockwise seen from the side that the
// normal points to.
struct Polygon {
  std::vector<Vec3> corners;

  // Unit length, from Newell's sum over the edges.
  Vec3 normal() const;

  // Both within a tolerance of `rounding` times its size.
  bool is_parallelogram() const;
  bool is_rectangle() const;

  // What coordinates in double lose a million sizes away from the origin; far below float's.
  static constexpr double rounding = 1e-9;
};

// The part of a convex polygon where dot(normal, p) > offset: corners in the same order, perhaps
// none.
std::vector<Vec3> part_beyond(const std::vector<Vec3>& corners, const Vec3& normal, double offset);

struct Sphere {
  Vec3 center;
  double radius;
};

using Mesh = std::vector<Polygon>;

// The smallest box around it.
Imath::Box3d bounds(const Mesh& mesh);

// How a surface scatters light:
//
//   diffuse     Lambertian, f = reflectance / pi
//   conductor   a metal: a mirror that shows `reflectance` times what Fresnel's equations give for
//               the complex refractive index eta + i k, in that of the air around it; without an
//               index a perfect mirror. Or, with a roughness `alpha`, tiny ones whose normals have
//               the GGX distribution, shadowed by Smith's formula, for each direction by itself; of
//               light reflected among them nothing is seen
//   dielectric  glass: the smooth border of what has the refractive index `ior`, behind the normal,
//               in that of what is before it. Fresnel's equations say how much is reflected; that
//               is multiplied by `reflectance`, and the rest, which goes through, by
//               `transmittance`. The radiance of what goes through is that of the other side times
//               the square of the ratio of the indices.
//
// A surface that is not two-sided is black on its back. A dielectric is two-sided.
struct Bsdf {
  enum class Kind { diffuse, conductor, dielectric };
  Kind kind = Kind::diffuse;
  Rgb reflectance{0.5};
  bool two_sided = false;
  Rgb eta{0.0}, k{0.0};  // both zero: without an index
  double alpha = 0.0;    // of a conductor; 0: smooth
  double ior = 1.0;
  Rgb transmittance{1.0};

  bool is_metal() const { return eta != Rgb(0.0) || k != Rgb(0.0); }
  bool is_mirror() const { return kind == Kind::conductor && alpha == 0.0; }
  bool is_specular() const { return is_mirror() || kind == Kind::dielectric; }
};

struct Shape {
  std::string id;  // of a file that gives none: "#3", its place among the shapes, from 0
  std::variant<Mesh, Sphere> geometry;
  Bsdf bsdf;
  Rgb radiance{0.0};  // emitted on the side of the normal; zero: no lamp

  bool is_lamp() const { return radiance != Rgb(0.0); }
  Imath::Box3d bounds() const;
};

// A lamp without size, which no picture shows and no path meets by chance. It sends `intensity`,
// radiance times area, to every side. What mirrors and glass make of its light can't be found.
struct PointLamp {
  Vec3 position;
  Rgb intensity;
};

constexpr int largest_image_side = 8192;

// How much light at a distance from a pixel's middle counts, along x and along y: `box` is the
// pixel's own square, `tent` falls linearly to 0 at `size` pixels, `gaussian` has the standard
// deviation `size` and ends after four of them, minus its value at that distance (as Mitsuba's do),
// `blackman_harris` is their window of four terms, which ends at `size` (as Cycles' does).
struct Filter {
  enum class Kind { box, tent, gaussian, blackman_harris };
  Kind kind = Kind::box;
  double size = 0.5;
  bool crosses_border = false;  // what lies beside the picture counts for its outermost pixels

  double radius() const { return kind == Kind::gaussian ? 4.0 * size : size; }

  // At a distance within the radius, along one of the axes; up to a constant factor.
  double weight(double distance) const;
};

// A pinhole. Pixel (x, y) covers the square from (x, y) to (x + 1, y + 1); y points down.
struct Camera {
  enum class FovAxis { x, y, diagonal, smaller, larger };
  static constexpr const char* fov_axis_names[] = {"x", "y", "diagonal", "smaller", "larger"};

  Vec3 origin{0.0};
  Vec3 forward{0.0, 0.0, 1.0};  // unit, orthogonal to the other two
  Vec3 right{-1.0, 0.0, 0.0};
  Vec3 up{0.0, 1.0, 0.0};
  double fov_degrees = 0.0;
  FovAxis fov_axis = FovAxis::x;
  int width = 0;
  int height = 0;
  Filter filter;
  // From outside of a room, looks into it through the walls that turn their backs to the camera:
  // one-sided ones that have the scene, but for a fiftieth of its size, before them.
  bool sees_through_backs = false;

  // Half the width of the image plane at distance 1 along `forward`, and half its height.
  double half_width() const;
  double half_height() const { return half_width() * height / width; }

  // Towards the point of the picture that is x pixels from its left and y from its upper border;
  // not of unit length.
  Vec3 direction(double x, double y) const;
};

// Numbers of bounces first <= b <= last that reach the picture: 0 is emission seen directly, 1 is
// direct light.
struct BounceRange {
  int first = 0;
  int last = std::numeric_limits<int>::max();

  bool contains(int bounces) const { return bounces >= first && bounces <= last; }
  bool is_everything() const { return first == 0 && last == BounceRange{}.last; }
};

// What a scene file asks of its renders.
struct RenderRequest {
  BounceRange bounces;
  int64_t samples_per_pixel = 0;  // 0: nothing
};

struct Scene {
  std::string name;  // the file's name without folder and extension, or its folder's for scene.xml
  std::string hash;  // SHA-1 of the scene file's bytes and of those of the files it names
  Camera camera;
  std::vector<Shape> shapes;
  std::vector<PointLamp> points;
  Rgb sky{0.0};  // the radiance that arrives, from all around, from where there are no shapes
  RenderRequest request;
  std::vector<std::string> notes;  // what of the file was taken how, a line each

  bool has_sky() const { return sky != Rgb(0.0); }
  bool has_lamps() const;  // of any kind, the sky among them

  // Of the shapes: the box around them, empty if there are none, and half its diagonal, or 1 if
  // that is nothing.
  Imath::Box3d bounds() const;
  double radius() const;

  // The sum of the three channels of the brightest lamp's radiance; of a lamp without size, of its
  // intensity over the square of the radius.
  double brightness() const;
};

}  // namespace plumb
