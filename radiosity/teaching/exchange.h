// SPDX-License-Identifier: Apache-2.0

// Ways to solve the radiosity equation B = E + rho F B for radiances B of patches: exitance is pi
// times that. All of them throw std::runtime_error if light doesn't fade.
#pragma once

#include <vector>

#include "radiosity/teaching/form_factors.h"
#include "radiosity/teaching/patches.h"

namespace plumb::radiosity::teaching {

using Light = std::vector<Rgb>;  // of each patch

// Throws Stopped wherever it takes long.
struct Exchange {
  FormFactors factors;  // made reciprocal
  std::vector<double> areas;
  Light reflectance, emission;
  const Work& work;

  Exchange(const Patches& patches, FormFactors raw, const Work& progress);

  size_t size() const { return areas.size(); }

  // What becomes of light after one bounce: rho F times it.
  Light reflect(const Light& light) const;

  // Light of so many bounces, added up bounce by bounce; the solution by default.
  Light light(const BounceRange& bounces = {}) const;

  // New values by Jacobi's rule, from old ones alone; or by Gauss's and Seidel's, from those that
  // are known.
  void jacobi(Light& light) const;
  void gauss_seidel(Light& light) const;

  // Radiance times area, over patches and channels: the light that leaves all patches, up to pi.
  double power(const Light& light) const;
  // The root of the mean of the squared difference, by area, over the mean of what `exact` has
  // beside emission.
  double error(const Light& light, const Light& exact) const;

  // What a bounce leaves of light in the long run, by power iteration.
  Rgb spectral_radius() const;
  // It is no larger than the largest reflectance.
  Rgb bound() const;
};

// Progressive refinement: patches shoot what they have not sent yet, the one with most of it first
// (Cohen, Chen, Wallace and Greenberg, "A progressive refinement approach to fast radiosity image
// generation", SIGGRAPH 1988). A shot needs a row of the matrix alone.
class Shooting {
 public:
  explicit Shooting(const Exchange& exchange);

  void shoot();
  const Light& light() const { return light_; }
  double unshot_power() const { return exchange_.power(unshot_); }

  // With a guess of what has not been sent: as if it were spread evenly, and all surfaces were of
  // the mean reflectance.
  Light with_ambient() const;

 private:
  const Exchange& exchange_;
  Light light_, unshot_;
};

}  // namespace plumb::radiosity::teaching
