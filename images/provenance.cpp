// SPDX-License-Identifier: Apache-2.0

#include "images/provenance.h"

#include <fmt/format.h>

#include <cstdlib>
#include <stdexcept>
#include <string_view>
#include <type_traits>

#include "images/printable.h"
#include "images/provenance_attributes.h"

namespace plumb {
namespace {

constexpr std::string_view prefix = "plumbline:";
constexpr std::string_view region_prefix = "plumbline:region";

// What a field is for the parts of one render: the same for all, a cost that adds up, or neither.
enum class Of { render, cost, picture };

// Calls `visit` with the name in files, the member and what it is for parts, for each field but
// the regions, in the order in which they are written.
template <typename Visit>
void for_each_field(Visit visit) {
  using P = Provenance;
  visit("renderer", &P::renderer, Of::render);
  visit("version", &P::version, Of::render);
  visit("scene", &P::scene, Of::render);
  visit("sceneHash", &P::scene_hash, Of::render);
  visit("sceneNotes", &P::scene_notes, Of::picture);
  visit("method", &P::method, Of::render);
  visit("sampler", &P::sampler, Of::render);
  visit("precision", &P::precision, Of::render);
  visit("bounces", &P::bounces, Of::render);
  visit("light", &P::light, Of::render);
  visit("quality", &P::quality, Of::render);
  visit("settings", &P::settings, Of::render);
  visit("seed", &P::seed, Of::render);
  visit("samples", &P::samples, Of::picture);
  visit("crop", &P::crop, Of::picture);
  visit("brightness", &P::brightness, Of::render);
  visit("replicates", &P::replicates, Of::render);
  visit("relativeError", &P::relative_error, Of::picture);
  visit("imageFloor", &P::image_floor, Of::picture);
  visit("regionFloor", &P::region_floor, Of::picture);
  visit("wallSeconds", &P::wall_seconds, Of::cost);
  visit("cpuSeconds", &P::cpu_seconds, Of::cost);
  visit("processSeconds", &P::process_seconds, Of::cost);
  visit("rays", &P::rays, Of::cost);
  visit("runs", &P::runs, Of::picture);
  visit("host", &P::host, Of::picture);
  visit("fault", &P::fault, Of::render);
  visit("scale", &P::scale, Of::picture);
}

// The name of the first field that makes the two no parts of one render; empty if there is none.
std::string first_difference(const Provenance& a, const Provenance& b) {
  std::string first;
  for_each_field([&](const char* name, auto member, Of of) {
    if (of == Of::render && first.empty() && a.*member != b.*member) first = name;
  });
  return first;
}

}  // namespace

double Provenance::samples_per_pixel() const {
  const std::string range = samples.value_or("");
  const size_t middle = range.find(':');
  if (middle == std::string::npos) return 0.0;
  return std::strtod(&range[middle + 1], nullptr) - std::strtod(range.c_str(), nullptr);
}

bool is_same_render(const Provenance& a, const Provenance& b) {
  return first_difference(a, b).empty() && a.samples == b.samples && a.crop == b.crop;
}

void add_part(Provenance& whole, const Provenance& part) {
  if (const std::string name = first_difference(whole, part); !name.empty()) {
    throw std::invalid_argument(fmt::format("not the same {} as in the parts before", name));
  }
  for_each_field([&](const char*, auto member, Of of) {
    if constexpr (std::is_same_v<decltype(member), std::optional<double> Provenance::*>) {
      if (of != Of::cost || !(part.*member)) return;
      whole.*member = (whole.*member).value_or(0.0) + *(part.*member);
    }
  });
  if (!whole.host) {
    whole.host = part.host;
  } else if (part.host && whole.host->find(*part.host) == std::string::npos) {
    *whole.host += "; " + *part.host;
  }
}

Attributes to_attributes(const Provenance& provenance) {
  Attributes attributes;
  for_each_field([&](const char* name, auto member, Of) {
    if (!(provenance.*member)) return;
    attributes.emplace_back(fmt::format("{}{}", prefix, name), *(provenance.*member));
  });
  for (const auto& [colour, name] : provenance.regions) {
    attributes.emplace_back(fmt::format("{}{}", region_prefix, colour), name);
  }
  return attributes;
}

Provenance to_provenance(const Attributes& attributes) {
  Provenance provenance;
  for (const auto& [name, value] : attributes) {
    for_each_field([&](const char* field, auto member, Of) {
      if (name != fmt::format("{}{}", prefix, field)) return;
      using Type = typename std::remove_reference_t<decltype(provenance.*member)>::value_type;
      const auto* found = std::get_if<Type>(&value);
      if (found == nullptr) return;
      if constexpr (std::is_same_v<Type, std::string>) {
        const bool has_lines = field == std::string_view("sceneNotes");
        provenance.*member = printable(*found, has_lines ? LineEnds::kept : LineEnds::escaped);
      } else {
        provenance.*member = *found;
      }
    });
    if (!name.starts_with(region_prefix)) continue;
    if (const auto* region = std::get_if<std::string>(&value)) {
      provenance.regions.emplace_back(printable(name.substr(region_prefix.size())),
                                      printable(*region));
    }
  }
  return provenance;
}

}  // namespace plumb
