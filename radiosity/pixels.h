// SPDX-License-Identifier: Apache-2.0

// Pixels cut into what they see, and light integrated over that.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "radiosity/convex.h"
#include "radiosity/eye.h"
#include "radiosity/faces.h"

namespace plumb::radiosity {

// The part of a pixel in which a face is seen; corners are directions from the camera whose
// component forwards is 1.
struct Fragment {
  size_t face;
  Convex part;
};

// How finely light is integrated over a triangle: by three Gauss points, or those of its quarters
// where their values differ by more than `spread` of the largest.
struct Quadrature {
  double spread;
  int depth;
};

class Pixels {
 public:
  Pixels(const Faces& faces, const Camera& camera);

  // What is seen in a pixel, in no particular order.
  std::vector<Fragment> fragments(int x, int y) const;

  // Whether it is the whole pixel, far from edges near which light changes within a pixel.
  bool is_smooth(const Fragment& fragment) const;

  // Of the pixel's area.
  double share(const Fragment& fragment) const;

  // The mean over the pixel of what `light` says of the eye, which looks from points of the face;
  // nothing beside the fragment. At a smooth pixel's middle alone, unless `quadrature` is given.
  using Light = std::function<Rgb(Eye&)>;
  Rgb integrate(const Fragment& fragment, const std::optional<Quadrature>& quadrature, Eye& eye,
                const Light& light) const;

 private:
  struct Sight {
    size_t face;
    Cone cone;
    std::vector<Cone> obstacles;
  };

  std::optional<Cone> cone_before(size_t polygon, size_t face) const;
  double area(const Vec3& a, const Vec3& b, const Vec3& c) const;
  Vec3 meet(const Vec3& direction, size_t face) const;
  Rgb at(const Vec3& direction, size_t face, Eye& eye, const Light& light) const;
  Rgb over_triangle(const std::array<Vec3, 3>& corners, size_t face, Quadrature quadrature,
                    Eye& eye, const Light& light) const;

  const Faces& faces_;
  const Camera& camera_;
  std::vector<Sight> sights_;
  double pixel_area_;
};

}  // namespace plumb::radiosity
