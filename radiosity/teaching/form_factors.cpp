// SPDX-License-Identifier: Apache-2.0

#include "radiosity/teaching/form_factors.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "radiosity/convex.h"
#include "radiosity/eye.h"

namespace plumb::radiosity::teaching {
namespace {

// Adds what the eye, where it is, sees of each patch.
void add_seen(const Patches& patches, Eye& eye, double factor, std::span<double> sums) {
  const Faces& faces = patches.faces();
  const Vec3& normal = faces[eye.face()].normal;
  std::vector<const Cone*> cones;
  std::vector<Convex> pieces;
  size_t face = faces.list().size();  // that of the cones; none yet
  for (size_t j = 0; j < patches.size(); ++j) {
    const Element& patch = patches[j];
    if (!eye.sees_front(patch.face)) continue;
    if (patch.face != face) eye.find_cones(face = patch.face, cones);
    pieces.assign(1, eye.relative(patch.outline()));
    if (faces.view(eye.face(), face).is_cut) {
      pieces[0] = cut(pieces[0], normal, 0.0, faces.slack()).before;
      if (pieces[0].size == 0) continue;
    }
    for (const Cone* cone : cones) subtract(pieces, *cone);
    for (const Convex& piece : pieces) sums[j] += factor * form_factor(normal, piece);
  }
}

}  // namespace

double FormFactors::row_sum(size_t i) const {
  const auto values = row(i);
  return std::accumulate(values.begin(), values.end(), 0.0);
}

std::vector<double> point_factors(const Patches& patches, size_t face, const Vec3& point) {
  std::vector<double> sums(patches.size(), 0.0);
  Eye eye(patches.faces());
  eye.move_to(face, point);
  add_seen(patches, eye, 1.0, sums);
  return sums;
}

FormFactors form_factors(const Patches& patches, const Work& work) {
  FormFactors factors(patches.size());
  tbb::enumerable_thread_specific<Eye> eyes(patches.faces());
  work.for_each("form factors", factors.size(), [&](size_t i) {
    const Element& patch = patches[i];
    Eye& eye = eyes.local();
    for (size_t q = 0; q < size_t(patch.points); ++q) {
      eye.move_to(patch.face, patch.point[q]);
      add_seen(patches, eye, patch.area[q] / patch.whole, factors.row(i));
    }
  });
  return factors;
}

void make_reciprocal(FormFactors& factors, const std::vector<double>& areas, const Work& work) {
  constexpr int most_iterations = 1000;
  constexpr double rounding = 1e-15;
  const size_t size = factors.size();
  std::vector<double> wanted(size), scale(size, 1.0), next(size);
  for (size_t i = 0; i < size; ++i) wanted[i] = areas[i] * factors.row_sum(i);
  for (size_t i = 0; i < size; ++i) {
    for (size_t j = 0; j < i; ++j) {
      double &there = factors.row(i)[j], &back = factors.row(j)[i];
      there = back = (areas[i] * there + areas[j] * back) / 2.0;
    }
  }
  double change = 1.0;
  for (int k = 0; k < most_iterations && change > rounding; ++k) {
    work.check();
    tbb::parallel_for(size_t{0}, size, [&](size_t i) {
      const auto row = factors.row(i);
      const double sum = std::inner_product(row.begin(), row.end(), scale.begin(), 0.0);
      next[i] = sum > 0.0 ? std::sqrt(scale[i] * wanted[i] / sum) : scale[i];
    });
    change = 0.0;
    for (size_t i = 0; i < size; ++i)
      change = std::max(change, std::abs(next[i] - scale[i]) * wanted[i] / areas[i]);
    scale.swap(next);
  }
  for (size_t i = 0; i < size; ++i) {
    for (size_t j = 0; j < size; ++j) factors.row(i)[j] *= scale[i] * scale[j] / areas[i];
  }
}

double lack_of_reciprocity(const FormFactors& factors, const std::vector<double>& areas) {
  double sum = 0.0, all = 0.0;
  for (size_t i = 0; i < factors.size(); ++i) {
    for (size_t j = 0; j < factors.size(); ++j) {
      sum += std::abs(areas[i] * factors.row(i)[j] - areas[j] * factors.row(j)[i]);
      all += areas[i] * factors.row(i)[j];
    }
  }
  return sum / all;
}

Hemicube::Hemicube(const Patches& patches, size_t patch, int resolution)
    : cells_(size_t(4 * resolution * resolution), nothing), worth_(cells_.size(), 0.0) {
  const Element& of = patches[patch];
  const Face& face = patches.faces()[of.face];
  const double cell = 2.0 / resolution;
  tbb::parallel_for(0, 2 * resolution, [&](int row) {
    for (int column = 0; column < 2 * resolution; ++column) {
      // Along the unfolded cube, whose upper face is from -1 to 1: what is beyond is folded down.
      const double across = (column + 0.5) * cell - 2.0, down = (row + 0.5) * cell - 2.0;
      const double x = std::clamp(across, -1.0, 1.0), y = std::clamp(down, -1.0, 1.0);
      const double low = std::abs(across - x) + std::abs(down - y), z = 1.0 - low;
      if (across != x && down != y) continue;
      const double squared = x * x + y * y + z * z;
      const auto i = static_cast<size_t>(row * 2 * resolution + column);
      // The cosines at the patch and at the cell, over pi and the squared distance.
      worth_[i] = z * cell * cell / (std::numbers::pi * squared * squared);
      const auto hit = patches.trace(of.center, face.u * x - face.v * y + face.normal * z);
      if (hit) cells_[i] = hit->patch;
    }
  });
}

std::vector<double> Hemicube::factors(size_t patches) const {
  std::vector<double> sums(patches, 0.0);
  for (size_t i = 0; i < cells_.size(); ++i) {
    if (cells_[i] != nothing) sums[cells_[i]] += worth_[i];
  }
  return sums;
}

}  // namespace plumb::radiosity::teaching
