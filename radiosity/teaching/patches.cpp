// SPDX-License-Identifier: Apache-2.0

#include "radiosity/teaching/patches.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <tuple>

namespace plumb::radiosity::teaching {
namespace {

// The distance from the nearest edge; negative outside.
double depth_inside(std::span<const Vec3> corners, const Vec3& normal, const Vec3& point) {
  double least = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < corners.size(); ++i) {
    const Vec3 along = corners[(i + 1) % corners.size()] - corners[i];
    if (along == Vec3(0.0)) continue;
    least = std::min(least, normal.dot(along.cross(point - corners[i])) / along.length());
  }
  return least;
}

}  // namespace

Patches::Patches(const Faces& faces, double radius, bool is_cut, size_t most)
    : faces_(faces), roots_(faces.list().size()) {
  for (size_t face = 0; face < roots_.size(); ++face) {
    for (const Element& part : parts_of(faces, face, is_cut)) {
      roots_[face].push_back(nodes_.size());
      nodes_.push_back({part});
      split(nodes_.size() - 1, radius, most);
    }
  }
  find_vertices();
}

Patches Patches::of_about(const Faces& faces, size_t count, bool is_cut, size_t most) {
  for (double radius = faces.size();; radius /= std::sqrt(std::sqrt(2.0))) {
    Patches patches(faces, radius, is_cut, most);
    if (patches.size() >= count) return patches;
  }
}

void Patches::split(size_t node, double radius, size_t most) {
  if (nodes_[node].element.radius <= radius) {
    if (list_.size() == most)
      throw std::runtime_error(fmt::format(
          "the matrix of more than {} patches doesn't fit into half of the memory", most));
    nodes_[node].patch = list_.size();
    list_.push_back(nodes_[node].element);
    return;
  }
  const size_t child = nodes_[node].child = nodes_.size();
  for (const Element& half : nodes_[node].element.halves(faces_)) nodes_.push_back({half});
  split(child, radius, most);
  split(child + 1, radius, most);
}

void Patches::find_vertices() {
  // Corners that are the same but for rounding have the same key, or that of a neighbour.
  std::map<std::tuple<size_t, int64_t, int64_t, int64_t>, size_t> known;
  const double unit = 1e-7 * faces_.size();
  for (const Element& patch : list_) {
    std::array<size_t, 4> own{};
    for (size_t i = 0; i < size_t(patch.size); ++i) {
      const Vec3 key = patch.corners[i] / unit;
      const auto [entry, is_new] = known.try_emplace(
          {patch.face, std::llround(key.x), std::llround(key.y), std::llround(key.z)},
          vertex_points_.size());
      if (is_new) {
        vertex_points_.push_back(patch.corners[i]);
        vertex_faces_.push_back(patch.face);
      }
      own[i] = entry->second;
    }
    vertices_.push_back(own);
  }
}

std::vector<double> Patches::areas() const {
  std::vector<double> areas;
  for (const Element& patch : list_) areas.push_back(patch.whole);
  return areas;
}

std::optional<Hit> Patches::trace(const Vec3& origin, const Vec3& direction) const {
  double nearest = std::numeric_limits<double>::infinity();
  size_t seen = roots_.size();
  const double slack = faces_.slack() / direction.length();
  for (size_t i = 0; i < roots_.size(); ++i) {
    const Face& face = faces_[i];
    const double slope = face.normal.dot(direction);
    if (slope == 0.0) continue;
    const double t = (face.offset - face.normal.dot(origin)) / slope;
    const bool is_back = slope > 0.0;
    // The front of a surface counts before a back at the same place.
    const double most = is_back || seen != roots_.size() ? nearest - slack : nearest + slack;
    if (t <= slack || t >= most) continue;
    if (depth_inside(face.outline.corners, face.normal, origin + direction * t) < 0.0) continue;
    nearest = t;
    seen = is_back ? roots_.size() : i;
  }
  if (seen == roots_.size()) return {};
  const Vec3 point = origin + direction * nearest;
  return Hit{patch_at(seen, point), point};
}

size_t Patches::patch_at(size_t face, const Vec3& point) const {
  const auto depth = [&](size_t node) {
    return depth_inside(nodes_[node].element.outline(), faces_[face].normal, point);
  };
  size_t node = *std::ranges::max_element(roots_[face], {}, depth);
  while (nodes_[node].child > 0) {
    const size_t child = nodes_[node].child;
    node = depth(child) >= depth(child + 1) ? child : child + 1;
  }
  return nodes_[node].patch;
}

std::vector<Rgb> Patches::mean_at_vertices(const std::vector<Rgb>& values) const {
  std::vector<Rgb> sum(vertex_points_.size(), Rgb(0.0));
  std::vector<double> area(sum.size(), 0.0);
  for (size_t i = 0; i < list_.size(); ++i) {
    for (size_t k = 0; k < size_t(list_[i].size); ++k) {
      sum[vertex(i, k)] += values[i] * list_[i].whole;
      area[vertex(i, k)] += list_[i].whole;
    }
  }
  for (size_t v = 0; v < sum.size(); ++v) sum[v] /= area[v];
  return sum;
}

std::array<double, 4> Patches::weights(size_t i, const Vec3& at) const {
  const Element& patch = list_[i];
  const Vec3 point = at + (patch.center - at) * 1e-6;  // on no edge, where angles are of no use
  const auto count = static_cast<size_t>(patch.size);
  std::array<double, 4> half_tangent{}, weights{};  // of the angle at the point to the next corner
  double sum = 0.0;
  for (size_t k = 0; k < count; ++k) {
    const Vec3 a = patch.corners[k] - point, b = patch.corners[(k + 1) % count] - point;
    half_tangent[k] = a.cross(b).length() / (a.length() * b.length() + a.dot(b));
  }
  for (size_t k = 0; k < count; ++k) {
    const double tangents = half_tangent[k] + half_tangent[(k + count - 1) % count];
    weights[k] = tangents / (patch.corners[k] - point).length();
    sum += weights[k];
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

std::vector<bool> Patches::has_t_vertex() const {
  const double room = 1e-6 * faces_.size();
  std::vector<bool> has(list_.size(), false);
  for (size_t i = 0; i < list_.size(); ++i) {
    const Element& patch = list_[i];
    for (size_t k = 0; k < size_t(patch.size); ++k) {
      const Vec3 edge = patch.corners[(k + 1) % size_t(patch.size)] - patch.corners[k];
      const double length = edge.length();
      for (size_t v = 0; v < vertex_points_.size(); ++v) {
        if (vertex_faces_[v] != patch.face) continue;
        const Vec3 offset = vertex_points_[v] - patch.corners[k];
        const double along = offset.dot(edge) / length;
        const bool is_between = along > room && along < length - room;
        if (is_between && offset.cross(edge).length() < room * length) has[i] = true;
      }
    }
  }
  return has;
}

}  // namespace plumb::radiosity::teaching
