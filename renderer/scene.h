// The scene model: what a picture is of, in the scene file's own units and in double precision.
//
// Coordinates are right-handed. Colours are linear RGB with Rec. 709 primaries. Radiance has no
// unit beyond that: a scene is consistent in itself.
#pragma once

#include <Imath/ImathVec.h>

#include <array>
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

  // Both up to `rounding` of its size.
  bool is_parallelogram() const;
  bool is_rectangle() const;

  // What coordinates in double lose a million sizes away from the origin; far below float's.
  static constexpr double rounding = 1e-9;
};

struct Sphere {
  Vec3 center;
  double radius;
};

using Mesh = std::vector<Polygon>;

// How a surface scatters light. `diffuse` is Lambertian, f = reflectance / pi; `conductor` is a
// perfect mirror. A surface that is not two-sided is black on its back.
struct Bsdf {
  enum class Kind { diffuse, conductor };
  Kind kind = Kind::diffuse;
  Rgb reflectance{0.5};
  bool two_sided = false;
};

struct Shape {
  std::string id;
  std::variant<Mesh, Sphere> geometry;
  Bsdf bsdf;
  Rgb radiance{0.0};  // emitted on the side of the normal; zero: no lamp

  bool is_lamp() const { return radiance != Rgb(0.0); }
};

constexpr int largest_image_side = 8192;

// A pinhole. Pixel (x, y) covers the square from (x, y) to (x + 1, y + 1); y points down.
struct Camera {
  enum class FovAxis { x, y, diagonal, smaller, larger };

  Vec3 origin{0.0};
  Vec3 forward{0.0, 0.0, 1.0};  // unit, orthogonal to the other two
  Vec3 right{-1.0, 0.0, 0.0};
  Vec3 up{0.0, 1.0, 0.0};
  double fov_degrees = 0.0;
  FovAxis fov_axis = FovAxis::x;
  int width = 0;
  int height = 0;

  // Half the width of the image plane at distance 1 along `forward`.
  double half_width() const;
};

struct Scene {
  std::string name;  // the file's name without folder and extension, or its folder's for scene.xml
  std::string hash;  // SHA-1 of the scene file's bytes and of those of the files it names
  Camera camera;
  std::vector<Shape> shapes;
};

}  // namespace plumb
