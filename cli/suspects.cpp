// SPDX-License-Identifier: Apache-2.0

#include "cli/suspects.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace plumb::cli {
namespace {

// A number, or the one of those usual ones that it may be.
std::string number_text(double number, const std::vector<double>& usual, double error) {
  constexpr double pi = std::numbers::pi;
  for (const double known : usual) {
    if (std::abs(number / known - 1.0) > std::max(1e-3, 3.0 * error / number)) continue;
    for (const auto& [word, value] :
         {std::pair("pi", pi), {"1/pi", 1 / pi}, {"4/pi", 4 / pi}, {"pi/4", pi / 4}}) {
      if (known == value) return fmt::format("{:.4g}, {}", number, word);
    }
  }
  return std::isfinite(number) ? fmt::format("{:.4g}", number) : "all";
}

}  // namespace

std::string name_of(const Suspect& suspect) {
  std::string name;
  for (const auto& [fault, number] : suspect.plantings) {
    const FaultDescription& row = description(fault);
    name += fmt::format("{}`{}`", name.empty() ? "" : " and ", row.name);
    const bool is_told = number && (fault == Fault::exposure || *number != row.numbers.front());
    if (is_told) name += " (" + number_text(*number, row.numbers, suspect.number_error) + ")";
  }
  return name + (suspect.has_mis ? "" : " without MIS");
}

std::vector<Suspect> all_suspects(const Scene& scene) {
  const bool has_glass = std::ranges::any_of(
      scene.shapes, [](const Shape& shape) { return shape.bsdf.kind == Bsdf::Kind::dielectric; });
  const auto samples_lamps = [](Fault fault) {
    return fault == Fault::emitter_cosine || fault == Fault::inverse_pi ||
           fault == Fault::half_lamp_area || fault == Fault::inverse_square ||
           fault == Fault::even_lamp;
  };
  std::vector<Suspect> suspects;
  for (const FaultDescription& row : faults()) {
    if (row.is_of_glass && !has_glass) continue;
    suspects.push_back({{{row.fault}}});
    if (samples_lamps(row.fault)) suspects.push_back({{{row.fault}}, false});
  }
  return suspects;
}

std::optional<Suspect> both(const Suspect& a, const Suspect& b) {
  Suspect sum{a.plantings, a.has_mis && b.has_mis};
  sum.plantings.insert(sum.plantings.end(), b.plantings.begin(), b.plantings.end());
  std::ranges::sort(sum.plantings, {}, &Planting::fault);
  const auto of_integrator = [](const Planting& p) {
    return description(p.fault).site == FaultSite::integrator;
  };
  const bool is_twice =
      std::ranges::adjacent_find(sum.plantings, {}, &Planting::fault) != sum.plantings.end();
  if (is_twice || std::ranges::count_if(sum.plantings, of_integrator) > 1) return {};
  return sum;
}

bool adds_to(const Suspect& a, const Suspect& b) {
  return a.plantings.size() > b.plantings.size() &&
         std::ranges::includes(a.plantings, b.plantings, {}, &Planting::fault, &Planting::fault);
}

void refute_what_is_worse(std::vector<Suspect>& suspects, double Suspect::* squares,
                          double Suspect::* deviation) {
  const auto most = [&](const Suspect& suspect) {
    return suspect.agreement.is_refuted ? suspect.*squares + clearly * suspect.*deviation
                                        : std::numeric_limits<double>::infinity();
  };
  const auto best = std::ranges::min_element(suspects, {}, most);
  for (Suspect& suspect : suspects) {
    if (suspect.agreement.is_refuted) continue;
    if (suspect.*squares - clearly * suspect.*deviation <= most(*best)) continue;
    suspect.agreement.is_refuted = true;
    suspect.agreement.rest = "more than with " + name_of(*best);
  }
}

bool have_same_faults(const Suspect& a, const Suspect& b) {
  return std::ranges::equal(a.plantings, b.plantings, {}, &Planting::fault, &Planting::fault);
}

bool is_drawn(const Planting& planting) {
  return description(planting.fault).site != FaultSite::picture ||
         planting.fault == Fault::smeared_indirect || planting.fault == Fault::ambient;
}

int side_without_shared_noise(const Suspect& suspect) {
  constexpr Fault narrow[] = {Fault::gaussian_filter, Fault::blackman_harris_filter,
                              Fault::mitchell_filter, Fault::denoised};
  constexpr Fault gaussian[] = {Fault::blurred, Fault::smeared, Fault::smeared_indirect};
  constexpr double deviations = 4.0;
  int side = 1;
  for (const Planting& p : suspect.plantings) {
    double reach = 0.0;
    if (std::ranges::find(narrow, p.fault) != std::end(narrow)) reach = block_side;
    if (std::ranges::find(gaussian, p.fault) != std::end(gaussian)) {
      reach = deviations * p.number.value_or(description(p.fault).numbers.front());
    }
    if (reach > 0.0) side = std::max(side, block_side * int(std::ceil(reach / block_side)));
  }
  return side;
}

bool repeats_noise(const Suspect& suspect) {
  return std::ranges::any_of(suspect.plantings, [](const Planting& p) {
    return p.fault == Fault::webgl_random || p.fault == Fault::webgl_demo;
  });
}

}  // namespace plumb::cli
