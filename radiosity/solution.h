// SPDX-License-Identifier: Apache-2.0

// The light that faces send to each other, bounce by bounce.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "radiosity/elements.h"
#include "radiosity/eye.h"
#include "radiosity/work.h"

namespace plumb::radiosity {

// How much links and gathering may get wrong, and elements after which a finer solution has more of
// them. A level has a quarter of the tolerance of the one before.
struct Resolution {
  double opening;         // of a link: the sum of two radii over their distance, at most
  double link_tolerance;  // of a link: how much its form factor varies over the receiver
  double tolerance;       // of light from a cluster, in parts of the mean radiance
  double unevenness;      // Solution::unevenness()
  static Resolution level(int n);
};

// Elements and clusters of two faces are linked where each is small as seen from the other
// (Hanrahan, Salzman and Aupperle, "A rapid hierarchical radiosity algorithm", SIGGRAPH 1991), with
// exact form factors and exact visibility from the Gauss points of the one that receives. Light of
// n bounces goes through the links, becomes that of n + 1, and so on (Jacobi's iteration).
class Solution {
 public:
  // Of the bounces that are wanted at what is seen, those with at least one reflection before; and
  // of their light, that with the origin, if there is one. Throws Stopped; std::length_error if
  // links would need more than `most_bytes`; and std::runtime_error if light doesn't fade.
  // `coarser`, if there is one, is the solution of the same elements before they were refined: what
  // it knows of their geometry is not computed again.
  Solution(const Elements& elements, const Resolution& resolution, const BounceRange& bounces,
           const LightOrigin* origin, std::unique_ptr<Solution> coarser, size_t most_bytes,
           const Work& work);

  size_t links() const { return links_; }

  // For each element without children: by how much its radiance differs from what its parent's is
  // there, in parts of its own or of a tenth of the mean, times the square of its nearness, because
  // what is far sees no more than its mean and slope, times its radius in parts of the scene's
  // size.
  const std::vector<double>& unevenness() const { return unevenness_; }

  // Irradiance / pi that elements send to the eye.
  Rgb gather(Eye& eye) const;

 private:
  enum class Halving { neither, receiver, sender };

  struct Links {
    std::vector<uint32_t> from;
    std::vector<Matrix> matrix;
  };

  bool comes_before(uint32_t a, uint32_t b) const;  // among links
  void find_correction();
  void connect(size_t to, std::vector<uint32_t> candidates, const Work& work);
  Halving halving(size_t to, size_t from) const;
  double most_arriving(const Element& element, size_t face, const Vec3& point, double radius) const;
  std::vector<size_t> take_known(size_t to, Solution* coarser);
  void fill(size_t to, const std::vector<size_t>& unknown, Eye& eye);
  Linear<double> seen_from(const Element& element, Eye& eye) const;
  Linear<Rgb> direct(Eye& eye, const Element& element, int depth) const;
  std::vector<Linear<Rgb>> send(const std::vector<Linear<Rgb>>& light) const;
  std::vector<Linear<Rgb>> reflect(const std::vector<Linear<Rgb>>& light) const;
  void darken(std::vector<Linear<Rgb>>& light, const LightOrigin& origin, bool is_one) const;
  void bounce(const BounceRange& bounces, const LightOrigin* origin, const Work& work);
  void find_roughness();
  double difference(size_t parent, size_t child) const;
  bool is_rough(const Eye& eye, size_t from, bool may_be_hidden) const;
  Rgb visit(Eye& eye, size_t from, const Convex& part, std::vector<const Cone*>& cones,
            size_t first_cone) const;

  const Elements& elements_;
  Resolution resolution_;
  std::vector<Links> into_;  // for each element
  size_t links_ = 0;
  std::vector<Linear<Rgb>> radiance_;  // for each element
  std::vector<double> roughness_, unevenness_;
  std::vector<Linear<double>> seen_;  // how much of all directions, by what reflects
  std::vector<Linear<Rgb>> correction_;
  double typical_ = 0.0;
};

}  // namespace plumb::radiosity
