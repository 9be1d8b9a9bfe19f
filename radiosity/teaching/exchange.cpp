// SPDX-License-Identifier: Apache-2.0

#include "radiosity/teaching/exchange.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace plumb::radiosity::teaching {
namespace {

constexpr int endless = 10000;

Rgb sum_of(const FormFactors& factors, size_t i, const Light& light) {
  Rgb sum(0.0);
  const auto row = factors.row(i);
  for (size_t j = 0; j < row.size(); ++j) sum += light[j] * row[j];
  return sum;
}

Rgb mean_by_area(const std::vector<double>& areas, const Light& light) {
  Rgb sum(0.0);
  for (size_t i = 0; i < areas.size(); ++i) sum += light[i] * areas[i];
  return sum / std::accumulate(areas.begin(), areas.end(), 0.0);
}

}  // namespace

Exchange::Exchange(const Patches& patches, FormFactors raw, const Work& progress)
    : factors(std::move(raw)), areas(patches.areas()), work(progress) {
  make_reciprocal(factors, areas, work);
  for (const Element& patch : patches.list()) {
    reflectance.push_back(patches.faces()[patch.face].reflectance);
    emission.push_back(patches.faces()[patch.face].radiance);
  }
}

Light Exchange::reflect(const Light& light) const {
  work.check();
  Light result(size());
  tbb::parallel_for(size_t{0}, size(),
                    [&](size_t i) { result[i] = reflectance[i] * sum_of(factors, i, light); });
  return result;
}

Light Exchange::light(const BounceRange& bounces) const {
  constexpr double negligible = 1e-16;
  Light sum(size(), Rgb(0.0)), last = emission;
  const double all = power(emission);
  for (int bounce = 0; bounce <= bounces.last && power(last) > negligible * all; ++bounce) {
    if (bounce == endless) throw std::runtime_error("light doesn't fade: all reflects everything");
    if (bounces.contains(bounce)) {
      for (size_t i = 0; i < size(); ++i) sum[i] += last[i];
    }
    last = reflect(last);
  }
  return sum;
}

void Exchange::jacobi(Light& light) const {
  light = reflect(light);
  for (size_t i = 0; i < size(); ++i) light[i] += emission[i];
}

void Exchange::gauss_seidel(Light& light) const {
  for (size_t i = 0; i < size(); ++i)
    light[i] = emission[i] + reflectance[i] * sum_of(factors, i, light);
}

double Exchange::power(const Light& light) const {
  double sum = 0.0;
  for (size_t i = 0; i < size(); ++i) sum += light[i].dot(Rgb(1.0)) * areas[i];
  return sum;
}

double Exchange::error(const Light& light, const Light& exact) const {
  double squares = 0.0;
  for (size_t i = 0; i < size(); ++i) {
    const double off = (light[i] - exact[i]).dot(Rgb(1.0));
    squares += off * off * areas[i];
  }
  const double area = std::accumulate(areas.begin(), areas.end(), 0.0);
  return std::sqrt(squares * area) / (power(exact) - power(emission));
}

Rgb Exchange::spectral_radius() const {
  constexpr double precision = 1e-9;
  Light light(size(), Rgb(1.0));
  Rgb radius(0.0);
  for (int k = 0; k < endless; ++k) {
    const Rgb before = radius;
    light = reflect(light);
    // Light was scaled to a mean of 1.
    radius = mean_by_area(areas, light);
    for (Rgb& value : light) {
      for (int c = 0; c < 3; ++c) value[c] = radius[c] > 0.0 ? value[c] / radius[c] : 0.0;
    }
    if ((radius - before).length() < precision) break;
  }
  return radius;
}

Rgb Exchange::bound() const {
  Rgb most(0.0);
  for (const Rgb& value : reflectance) {
    for (int c = 0; c < 3; ++c) most[c] = std::max(most[c], value[c]);
  }
  return most;
}

Shooting::Shooting(const Exchange& exchange)
    : exchange_(exchange), light_(exchange.emission), unshot_(exchange.emission) {}

void Shooting::shoot() {
  const auto& areas = exchange_.areas;
  size_t from = 0;
  double most = 0.0;
  for (size_t i = 0; i < areas.size(); ++i) {
    const double power = unshot_[i].dot(Rgb(1.0)) * areas[i];
    if (power > most) {
      most = power;
      from = i;
    }
  }
  const Rgb sent = std::exchange(unshot_[from], Rgb(0.0)) * areas[from];
  const auto row = exchange_.factors.row(from);
  for (size_t j = 0; j < areas.size(); ++j) {
    const Rgb gain = exchange_.reflectance[j] * sent * (row[j] / areas[j]);
    light_[j] += gain;
    unshot_[j] += gain;
  }
}

Light Shooting::with_ambient() const {
  const Rgb mean_reflectance = mean_by_area(exchange_.areas, exchange_.reflectance);
  const Rgb ambient = mean_by_area(exchange_.areas, unshot_) / (Rgb(1.0) - mean_reflectance);
  Light result = light_;
  for (size_t i = 0; i < result.size(); ++i) result[i] += exchange_.reflectance[i] * ambient;
  return result;
}

}  // namespace plumb::radiosity::teaching
