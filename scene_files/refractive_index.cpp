// SPDX-License-Identifier: Apache-2.0

#include "scene_files/refractive_index.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <boost/algorithm/string/case_conv.hpp>
#include <iterator>
#include <ranges>

namespace plumb {
namespace {

struct Transparent {
  const char* name;
  double index;
};

// As in Mitsuba's include/mitsuba/render/ior.h.
constexpr Transparent transparent[] = {
    {"vacuum", 1.0},      {"helium", 1.000036},        {"hydrogen", 1.000132},
    {"air", 1.000277},    {"carbon dioxide", 1.00045}, {"water", 1.333},
    {"acetone", 1.36},    {"ethanol", 1.361},          {"carbon tetrachloride", 1.461},
    {"glycerol", 1.4729}, {"benzene", 1.501},          {"silicone oil", 1.52045},
    {"bromine", 1.661},   {"water ice", 1.31},         {"fused quartz", 1.458},
    {"pyrex", 1.47},      {"acrylic glass", 1.49},     {"polypropylene", 1.49},
    {"bk7", 1.5046},      {"sodium chloride", 1.544},  {"amber", 1.55},
    {"pet", 1.575},       {"diamond", 2.419}};

struct Metal {
  const char* name;
  double eta[3];
  double k[3];
};

constexpr Metal metals[] = {
#include "scene_files/metals.inc"
};

template <class List>
std::string names(const List& list) {
  return fmt::format(
      "{}",
      fmt::join(list | std::views::transform([](const auto& item) { return item.name; }), ", "));
}

}  // namespace

std::optional<double> refractive_index(const std::string& name) {
  const std::string lower = boost::to_lower_copy(name);
  const auto* found = std::ranges::find(transparent, lower, &Transparent::name);
  if (found == std::end(transparent)) return {};
  return found->index;
}

std::optional<std::pair<Rgb, Rgb>> complex_refractive_index(const std::string& name) {
  // All but these were measured by Palik, who may be named.
  constexpr std::string_view source = "_palik", others[] = {"a-C", "Ag", "Al", "Au", "Cr", "W"};
  const auto* found = std::ranges::find(metals, name, &Metal::name);
  if (found == std::end(metals) && name.ends_with(source)) {
    const std::string metal = name.substr(0, name.size() - source.size());
    if (std::ranges::count(others, metal) == 0)
      found = std::ranges::find(metals, metal, &Metal::name);
  }
  if (found == std::end(metals)) return {};
  const auto rgb = [](const double(&v)[3]) { return Rgb(v[0], v[1], v[2]); };
  return std::pair(rgb(found->eta), rgb(found->k));
}

std::string names_of_transparent() { return names(transparent); }
std::string names_of_metals() { return "none, " + names(metals); }

}  // namespace plumb
