// SPDX-License-Identifier: Apache-2.0

// Of the light that leaves a patch, the part that reaches another one: the matrix of all of these.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "radiosity/teaching/patches.h"
#include "radiosity/work.h"

namespace plumb::radiosity::teaching {

class FormFactors {
 public:
  explicit FormFactors(size_t size) : size_(size), values_(size * size, 0.0) {}

  size_t size() const { return size_; }
  std::span<double> row(size_t i) { return {&values_[i * size_], size_}; }
  std::span<const double> row(size_t i) const { return {&values_[i * size_], size_}; }
  double row_sum(size_t i) const;

 private:
  size_t size_;
  std::vector<double> values_;
};

// From a point of a face to every patch, in closed form with exact visibility.
std::vector<double> point_factors(const Patches& patches, size_t face, const Vec3& point);

// The mean of these over the Gauss points of each patch. So what a row adds up to is exact, but
// reciprocity, area_i F_ij = area_j F_ji, has the error of four points.
FormFactors form_factors(const Patches& patches, const Work& work);

// Scales what the two sides say of each pair, in the mean, such that reciprocity is exact and the
// sums of rows stay what they are: as Sinkhorn's iteration does it (R. Sinkhorn, "A relationship
// between arbitrary positive matrices and doubly stochastic matrices", 1964).
void make_reciprocal(FormFactors& factors, const std::vector<double>& areas, const Work& work);

// By how much area_i F_ij differs from area_j F_ji in the mean, in parts of the mean of these.
double lack_of_reciprocity(const FormFactors& factors, const std::vector<double>& areas);

// Half a cube around a patch's middle, which stands on it, with cells that each see one patch
// (Cohen and Greenberg, "The hemi-cube: a radiosity solution for complex environments", SIGGRAPH
// 1985). The cells are those of the upper face, of resolution^2, and those of the four sides, of
// resolution^2 / 2 each.
class Hemicube {
 public:
  static constexpr size_t nothing = size_t(-1);

  Hemicube(const Patches& patches, size_t patch, int resolution);

  // The sum over the cells that see each patch, of what such a cell is worth.
  std::vector<double> factors(size_t patches) const;

  // As it is unfolded, rows from the top, twice the resolution wide and high; `nothing` also around
  // the faces.
  const std::vector<size_t>& cells() const { return cells_; }

 private:
  std::vector<size_t> cells_;
  std::vector<double> worth_;
};

}  // namespace plumb::radiosity::teaching
