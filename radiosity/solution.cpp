// SPDX-License-Identifier: Apache-2.0

#include "radiosity/solution.h"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace plumb::radiosity {
namespace {

using Eyes = tbb::enumerable_thread_specific<Eye>;

// Lit from before the plane of each other.
bool see_each_other(const Faces& faces, const Element& a, const Element& b) {
  if (!faces.view(a.face, b.face).is_any) return false;
  const auto is_before = [&](const Face& plane, const Element& element) {
    return std::ranges::any_of(element.outline(), [&](const Vec3& corner) {
      return plane.normal.dot(corner) - plane.offset > faces.slack();
    });
  };
  return is_before(faces[a.face], b) && is_before(faces[b.face], a);
}

double largest(const std::vector<Linear<Rgb>>& functions) {
  double most = 0.0;
  for (const Linear<Rgb>& f : functions) most = std::max({most, f[0].x, f[0].y, f[0].z});
  return most;
}

}  // namespace

Resolution Resolution::level(int n) {
  const double part = std::pow(0.25, n);
  return {.opening = 0.7 * std::pow(part, 0.125),
          .link_tolerance = 1e-3 * std::sqrt(part),
          .tolerance = 4e-4 * part,
          .unevenness = 4e-4 * part};
}

Solution::Solution(const Elements& elements, const Resolution& resolution,
                   const BounceRange& bounces, const LightOrigin* origin,
                   std::unique_ptr<Solution> coarser, size_t most_bytes, const Work& work)
    : elements_(elements),
      resolution_(resolution),
      into_(elements.size()),
      radiance_(elements.size(), dark),
      roughness_(elements.size(), 0.0),
      unevenness_(elements.size(), 0.0),
      seen_(elements.size(), {0.0, 0.0, 0.0}),
      correction_(elements.size(), dark) {
  std::vector<uint32_t> roots(elements.roots());
  std::iota(roots.begin(), roots.end(), 0U);
  work.for_each("links", roots.size(), [&](size_t i) { connect(roots[i], roots, work); });
  for (const Links& links : into_) links_ += links.from.size();
  if (links_ * sizeof(Matrix) > most_bytes) {
    throw std::length_error(
        fmt::format("{} elements with {} links need {:.1f} GB, more than half of the memory",
                    elements.leaves(), links_, double(links_ * sizeof(Matrix)) / 1e9));
  }
  Eyes eyes(elements.faces());
  work.for_each("form factors", elements.size(),
                [&](size_t i) { fill(i, take_known(i, coarser.get()), eyes.local()); });
  work.for_each("energy balance", elements.size(), [&](size_t i) {
    const bool is_known = coarser != nullptr && i < coarser->seen_.size();
    if (!elements[i].has_children())
      seen_[i] = is_known ? coarser->seen_[i] : seen_from(elements[i], eyes.local());
  });
  find_correction();
  work.for_each("direct light", elements.size(), [&](size_t i) {
    if (!elements_[i].has_children()) radiance_[i] = direct(eyes.local(), elements_[i], 6);
  });
  bounce(bounces, origin, work);
  find_roughness();
}

// Which of the two to take in halves: the one that a link would be too coarse for; neither, if a
// link does. What varies over the receiver is most of what large or near senders send, and shadows,
// which are sharp near the thing that casts them.
Solution::Halving Solution::halving(size_t to, size_t from) const {
  const Element &a = elements_[to], &b = elements_[from];
  const bool is_smaller = b.has_children() && (!a.has_children() || b.radius > a.radius);
  const Halving larger = is_smaller         ? Halving::sender
                         : a.has_children() ? Halving::receiver
                                            : Halving::neither;
  const double part = (a.radius + b.radius) / (a.center - b.center).length();
  if (part > resolution_.opening || larger == Halving::neither) return larger;
  const Faces& faces = elements_.faces();
  const double variation = most_arriving(b, a.face, a.center, a.radius) * a.radius * a.radius /
                           (a.center - b.center).length2();
  if (a.has_children() && variation > resolution_.link_tolerance) return Halving::receiver;
  for (const int q : faces.view(a.face, b.face).obstacles) {
    const auto polygon = static_cast<size_t>(q);
    if (!faces.may_block(polygon, a.outline(), b.outline())) continue;
    if (part > 0.5 * resolution_.opening) return larger;
    if (a.has_children() && a.radius > 0.5 * faces.distance(a.center, polygon)) {
      return Halving::receiver;
    }
  }
  return Halving::neither;
}

// A bound on the form factor to an element, from points of a face within `radius` around a point.
double Solution::most_arriving(const Element& element, size_t face, const Vec3& point,
                               double radius) const {
  const Faces& faces = elements_.faces();
  const Vec3 towards = element.center - point;
  const double squared = towards.length2(), room = element.radius + radius;
  const double here = std::max(0.0, room + faces[face].normal.dot(towards));
  const double there = std::max(0.0, room - faces[element.face].normal.dot(towards));
  return std::min(1.0, element.whole * here * there / (std::numbers::pi * squared * squared));
}

bool Solution::comes_before(uint32_t a, uint32_t b) const {
  return std::pair(elements_[a].face, a) < std::pair(elements_[b].face, b);
}

void Solution::connect(size_t to, std::vector<uint32_t> candidates, const Work& work) {
  if (work.is_stopped()) return;
  const Element& element = elements_[to];
  std::vector<uint32_t> for_children;
  auto& links = into_[to].from;
  while (!candidates.empty()) {
    const uint32_t from = candidates.back();
    candidates.pop_back();
    const Element& other = elements_[from];
    if (!see_each_other(elements_.faces(), element, other)) continue;
    switch (halving(to, from)) {
      case Halving::neither: links.push_back(from); break;
      case Halving::receiver: for_children.push_back(from); break;
      case Halving::sender:
        candidates.push_back(static_cast<uint32_t>(other.child));
        candidates.push_back(static_cast<uint32_t>(other.child + 1));
    }
  }
  std::ranges::sort(links, [&](uint32_t a, uint32_t b) { return comes_before(a, b); });
  if (!element.has_children()) return;
  const auto child = static_cast<size_t>(element.child);
  tbb::parallel_invoke([&] { connect(child, for_children, work); },
                       [&] { connect(child + 1, for_children, work); });
}

// Takes the matrices of links that the coarser solution has, too, and frees it of all that lead to
// the same element; returns the places of the others.
std::vector<size_t> Solution::take_known(size_t to, Solution* coarser) {
  Links& links = into_[to];
  links.matrix.resize(links.from.size());
  std::vector<size_t> unknown;
  Links known;
  if (coarser != nullptr && to < coarser->into_.size()) std::swap(known, coarser->into_[to]);
  size_t i = 0;
  for (size_t k = 0; k < links.from.size(); ++k) {
    while (i < known.from.size() && comes_before(known.from[i], links.from[k])) ++i;
    const bool is_same = i < known.from.size() && known.from[i] == links.from[k];
    if (is_same) links.matrix[k] = known.matrix[i];
    if (!is_same) unknown.push_back(k);
  }
  return unknown;
}

void Solution::fill(size_t to, const std::vector<size_t>& unknown, Eye& eye) {
  const Element& element = elements_[to];
  const Faces& faces = elements_.faces();
  Links& links = into_[to];
  std::vector<const Cone*> cones, before;
  for (size_t q = 0; q < size_t(element.points); ++q) {
    eye.move_to(element.face, element.point[q]);
    size_t face = faces.list().size();  // that of the cones; none yet
    for (const size_t k : unknown) {
      const Element& other = elements_[links.from[k]];
      if (!eye.sees_front(other.face)) continue;
      if (other.face != face) eye.find_cones(face = other.face, cones);
      const Convex part = eye.relative(other.outline());
      before.clear();
      for (const Cone* cone : cones) {
        if (!cone->misses(part)) before.push_back(cone);
      }
      const Vec3 weights = eye.weights(face, part, before, other.frame(faces[face]));
      for (int i = 0; i < 3; ++i) links.matrix[k].rows[size_t(i)] += weights * element.fit[q][i];
    }
  }
}

// Radiance that the lamps' light makes: from halves of the element where it isn't linear.
Linear<Rgb> Solution::direct(Eye& eye, const Element& element, int depth) const {
  const Faces& faces = elements_.faces();
  const Face& face = faces[element.face];
  Linear<Rgb> result = dark;
  std::array<Rgb, Element::most_points> values;
  double most = 0.0, error = 0.0;
  for (size_t q = 0; q < size_t(element.points); ++q) {
    eye.move_to(element.face, element.point[q]);
    values[q] = face.reflectance * eye.direct();
    for (int i = 0; i < 3; ++i) result[size_t(i)] += values[q] * element.fit[q][i];
  }
  for (size_t q = 0; q < size_t(element.points); ++q) {
    const Vec3 parts = element.parts(face, element.point[q]);
    const Rgb off = value(result, parts) - values[q];
    for (int c = 0; c < 3; ++c) {
      most = std::max(most, values[q][c]);
      error = std::max(error, std::abs(off[c]));
    }
  }
  const double rise = std::max(result[1].length(), result[2].length());
  // Four points see nothing of what is quadratic, which is about the square of the rise.
  const double tolerance = 10.0 * resolution_.tolerance * most;
  const bool is_linear = error < tolerance && rise * rise < 20.0 * tolerance * most;
  if (depth == 0 || most == 0.0 || is_linear) return result;
  result = dark;
  for (const Element& half : element.halves(faces)) {
    half.to_parent.add_to(result, direct(eye, half, depth - 1));
  }
  return result;
}

// Irradiance / pi at the elements without children.
std::vector<Linear<Rgb>> Solution::send(const std::vector<Linear<Rgb>>& light) const {
  std::vector<Linear<Rgb>> arriving(light.size(), dark);
  tbb::parallel_for(size_t{0}, light.size(), [&](size_t to) {
    const Links& links = into_[to];
    for (size_t k = 0; k < links.from.size(); ++k) {
      links.matrix[k].add_to(arriving[to], light[links.from[k]]);
    }
  });
  elements_.push(arriving);
  for (size_t i = 0; i < light.size(); ++i) {
    const Rgb mean = arriving[i][0];
    for (size_t k = 0; k < 3; ++k) arriving[i][k] += correction_[i][k] * mean;
  }
  return arriving;
}

Linear<double> Solution::seen_from(const Element& element, Eye& eye) const {
  const Faces& faces = elements_.faces();
  Linear<double> seen{0.0, 0.0, 0.0};
  for (size_t q = 0; q < size_t(element.points); ++q) {
    eye.move_to(element.face, element.point[q]);
    double sum = 0.0;
    for (size_t face = 0; face < faces.list().size(); ++face) {
      if (faces[face].reflects()) sum += eye.form_factor_of(face);
    }
    for (int i = 0; i < 3; ++i) seen[size_t(i)] += sum * element.fit[q][i];
  }
  return seen;
}

// What links to clusters lose of the same radiance from everywhere, of which all that is seen is
// known exactly: so that no energy is lost or made.
void Solution::find_correction() {
  const std::vector<Linear<Rgb>> one(elements_.size(), {Rgb(1.0), Rgb(0.0), Rgb(0.0)});
  const std::vector<Linear<Rgb>> arriving = send(one);
  for (size_t i = 0; i < elements_.size(); ++i) {
    const double sum = arriving[i][0].x;
    if (elements_[i].has_children() || sum < 1e-9) continue;
    for (size_t k = 0; k < 3; ++k) correction_[i][k] = (Rgb(seen_[i][k]) - arriving[i][k]) / sum;
  }
}

std::vector<Linear<Rgb>> Solution::reflect(const std::vector<Linear<Rgb>>& light) const {
  std::vector<Linear<Rgb>> reflected = send(light);
  for (size_t i = 0; i < light.size(); ++i) {
    for (Rgb& part : reflected[i]) part *= elements_.faces()[elements_[i].face].reflectance;
  }
  return reflected;
}

// Leaves no light on the shapes of the origin, or on all others.
void Solution::darken(std::vector<Linear<Rgb>>& light, const LightOrigin& origin,
                      bool is_one) const {
  for (size_t i = 0; i < light.size(); ++i) {
    const size_t shape = elements_.faces()[elements_[i].face].shape;
    if ((origin.has_shape[shape] != 0) == is_one) light[i] = dark;
  }
}

void Solution::bounce(const BounceRange& bounces, const LightOrigin* origin, const Work& work) {
  constexpr int endless = 10000;
  constexpr double negligible = 1e-11;
  std::vector<Linear<Rgb>> light =
      std::exchange(radiance_, std::vector<Linear<Rgb>>(into_.size(), dark));
  const double first = largest(light);
  const bool is_last = origin != nullptr && origin->way == LightOrigin::Way::last;
  // What none of the shapes has reflected.
  std::vector<Linear<Rgb>> other;
  if (origin != nullptr && !is_last) other = light;
  for (int bounce = 1; bounce < bounces.last; ++bounce) {
    work.check();
    work.show(fmt::format("bounce {}", bounce));
    elements_.pull(light);
    if (!other.empty()) {
      darken(other, *origin, true);
      elements_.pull(other);
    }
    if (bounces.contains(bounce + 1)) {
      for (size_t i = 0; i < light.size(); ++i) {
        for (size_t k = 0; k < 3; ++k) {
          radiance_[i][k] += light[i][k] - (other.empty() ? Rgb(0.0) : other[i][k]);
        }
      }
    }
    const double before = largest(light);
    light = reflect(light);
    if (!other.empty()) other = reflect(other);
    const double after = largest(light), fading = after / before;
    if (after <= 0.0 || (fading < 1.0 && after / (1.0 - fading) < negligible * first)) break;
    if (bounce == endless || (bounce > 100 && fading > 1.0 - 1e-7)) {
      throw std::runtime_error(
          fmt::format("light hardly fades: {:.3g} % of it is left after {} bounces",
                      100.0 * after / first, bounce));
    }
  }
  if (is_last) darken(radiance_, *origin, false);
}

void Solution::find_roughness() {
  double sum = 0.0, area = 0.0;
  for (size_t i = 0; i < elements_.roots(); ++i) {
    sum += radiance_[i][0].dot(Rgb(1.0)) * elements_[i].whole;
    area += elements_[i].whole;
  }
  typical_ = sum / area;
  for (size_t i = elements_.size(); i-- > 0;) {
    if (!elements_[i].has_children()) continue;
    for (const int c : {elements_[i].child, elements_[i].child + 1}) {
      const auto child = static_cast<size_t>(c);
      const double off = difference(i, child);
      roughness_[i] = std::max(roughness_[i], roughness_[child] + off);
      const double own = radiance_[child][0].dot(Rgb(1.0)) + 0.1 * typical_;
      if (off <= 0.0) continue;
      unevenness_[child] = off / own * std::pow(elements_[child].nearness, 2) *
                           elements_[child].radius / elements_[child].detail;
    }
  }
}

// Of the radiance of an element from its parent's, the largest at its Gauss points.
double Solution::difference(size_t parent, size_t child) const {
  const Element &whole = elements_[parent], &half = elements_[child];
  const Face& face = elements_.faces()[half.face];
  double most = 0.0;
  for (size_t q = 0; q < size_t(half.points); ++q) {
    const Rgb off = value(radiance_[parent], whole.parts(face, half.point[q])) -
                    value(radiance_[child], half.parts(face, half.point[q]));
    most = std::max(most, std::abs(off.x) + std::abs(off.y) + std::abs(off.z));
  }
  return most;
}

Rgb Solution::gather(Eye& eye) const {
  Rgb sum(0.0);
  std::vector<const Cone*> cones;
  size_t face = elements_.faces().list().size();  // that of the cones; none yet
  for (size_t root = 0; root < elements_.roots(); ++root) {
    const Element& element = elements_[root];
    if (!eye.sees_front(element.face)) continue;
    if (element.face != face) eye.find_cones(face = element.face, cones);
    sum += visit(eye, root, eye.relative(element.outline()), cones, 0);
  }
  return sum;
}

// Whether the children would tell something else: by how much light arrives from the element at
// most, how far from linear it is, and how much of that is told apart from where the eye is.
bool Solution::is_rough(const Eye& eye, size_t from, bool may_be_hidden) const {
  const Element& element = elements_[from];
  const double factor = most_arriving(element, eye.face(), eye.point(), 0.0);
  const double squared = (element.center - eye.point()).length2();
  const double share =
      std::min(1.0, may_be_hidden ? 0.3 : element.radius * element.radius / squared);
  return factor * share * roughness_[from] > resolution_.tolerance * typical_;
}

// `cones`, from the first one that counts on, is left as it was.
Rgb Solution::visit(Eye& eye, size_t from, const Convex& part, std::vector<const Cone*>& cones,
                    size_t first_cone) const {
  const Element& element = elements_[from];
  const size_t end = cones.size();
  Rgb sum(0.0);
  bool is_hidden = false;
  for (size_t i = first_cone; i < end; ++i) {
    if (cones[i]->misses(part)) continue;
    is_hidden = is_hidden || cones[i]->covers(part);
    cones.push_back(cones[i]);
  }
  const bool is_near = is_rough(eye, from, cones.size() > end);
  if (is_hidden) {
    sum = Rgb(0.0);
  } else if (is_near && element.has_children()) {
    for (const int child : {element.child, element.child + 1}) {
      sum +=
          visit(eye, size_t(child), eye.relative(elements_[size_t(child)].outline()), cones, end);
    }
  } else {
    const Face& face = elements_.faces()[element.face];
    const Vec3 w =
        eye.weights(element.face, part, std::span(cones).subspan(end), element.frame(face));
    sum = value(radiance_[from], w);
  }
  cones.resize(end);
  return sum;
}

}  // namespace plumb::radiosity
