// SPDX-License-Identifier: Apache-2.0

#include "compare/card.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace plumb {

std::optional<CardFloors> floors_of_card(const std::filesystem::path& picture) {
  const auto file = std::filesystem::path(picture).replace_filename("card.json");
  std::ifstream stream(file);
  if (!stream) return {};
  try {
    const auto card = nlohmann::json::parse(stream);
    for (const auto& entry : card.at("pictures")) {
      if (entry.at("file") != picture.filename().string() || !entry.contains("floor")) continue;
      const double whole = entry.at("floor").at("wholePercent");
      double worst = whole;
      for (const double floor : entry.at("floor").at("regionsPercent")) {
        worst = std::max(worst, floor);
      }
      return CardFloors{{whole / 100.0}, {worst / 100.0}};
    }
  } catch (const nlohmann::json::exception& error) {
    throw std::runtime_error(fmt::format("{}: {}", file.string(), error.what()));
  }
  return {};
}

}  // namespace plumb
