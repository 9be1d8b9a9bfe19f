// SPDX-License-Identifier: Apache-2.0

#include "images/stored_image.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <limits>

#include "images/printable.h"

namespace plumb {

PixelWindow unite(const PixelWindow& a, const PixelWindow& b) {
  const int64_t x = std::min(a.x, b.x), y = std::min(a.y, b.y);
  return {x, y, std::max(a.x + a.width, b.x + b.width) - x,
          std::max(a.y + a.height, b.y + b.height) - y};
}

void fail(const std::filesystem::path& file, std::string_view what, std::string_view reason) {
  throw ImageError(fmt::format("{}: {}: {}", file.string(), what, reason));
}

int find_part(const std::vector<std::string>& names, const std::string& part,
              const std::filesystem::path& file) {
  std::vector<std::string> known;
  for (size_t i = 0; i < names.size(); ++i) {
    if (part.empty() || part == names[i] || part == std::to_string(i)) return static_cast<int>(i);
    known.push_back(fmt::format("{} '{}'", i, names[i]));
  }
  fail(file, fmt::format("no part '{}'", part), fmt::format("it has {}", fmt::join(known, ", ")));
}

void check_size(const StoredImage& stored, const PixelWindow& frame,
                const std::filesystem::path& file) {
  if (stored.image.channels.empty()) fail(file, "cannot decode", "it has no channels");
  if (std::max(frame.width, frame.height) > std::numeric_limits<int>::max()) {
    fail(file, "picture too large", fmt::format("{} x {} pixels", frame.width, frame.height));
  }
  const double needed = double(frame.width) * double(frame.height) *
                        double(stored.image.channels.size()) * sizeof(float);
  rlimit allowed{};
  ::getrlimit(RLIMIT_RSS, &allowed);
  const double installed = double(::sysconf(_SC_PHYS_PAGES)) * double(::sysconf(_SC_PAGESIZE));
  const double half = 0.5 * std::min(installed, double(allowed.rlim_cur));
  if (needed <= half) return;
  const auto [wanted, present] = told_apart(needed / 1e9, half / 1e9);
  fail(file, "picture too large",
       fmt::format("{} x {} pixels of {} channels need {} GB, half of the memory is {} GB",
                   frame.width, frame.height, stored.image.channels.size(), wanted, present));
}

}  // namespace plumb
