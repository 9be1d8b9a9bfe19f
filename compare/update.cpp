// SPDX-License-Identifier: Apache-2.0

#include "compare/update.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <fstream>
#include <iterator>

namespace plumb {
namespace {

namespace fs = std::filesystem;

using Names = std::vector<std::string>;

// The selection as the test itself has it.
Selection in_test(const Selection& selection) {
  Selection own = selection;
  if (own.layer) own.layer = name_on_each_side(*own.layer).first;
  for (std::string& name : own.channels) name = name_on_each_side(name).first;
  return own;
}

// The reference's name of one of the test's channels.
std::string name_in_reference(std::string name, const Selection& selection) {
  const auto [from, to] = name_on_each_side(selection.layer.value_or(""));
  if (!from.empty()) name = name.substr(from.size() + 1);
  for (const std::string& channel : selection.channels) {
    const auto [of_test, of_reference] = name_on_each_side(channel);
    if (name != of_test) continue;
    name = of_reference;
    break;
  }
  return to.empty() ? name : fmt::format("{}.{}", to, name);
}

Image compared_image(const Picture& picture, const Names& names) {
  Image image{picture.image.width, picture.image.height, names, {}, picture.image.provenance};
  for (size_t c = 0; c < names.size(); ++c) {
    if (picture.knows_noise(c)) image.channels.push_back("variance." + names[c]);
  }
  const size_t pixels = image.pixel(0, image.height);
  for (size_t p = 0; p < pixels; ++p) {
    for (size_t c = 0; c < names.size(); ++c) {
      image.values.push_back(static_cast<float>(picture.value(p, c)));
    }
    for (size_t c = 0; c < names.size(); ++c) {
      if (picture.knows_noise(c)) {
        image.values.push_back(static_cast<float>(picture.variance(p, c)));
      }
    }
  }
  return image;
}

void refuse_loss(const fs::path& reference, const Names& names) {
  if (!fs::exists(reference)) return;
  Names lost = read_picture("reference", {reference.string()}, "").image.channels;
  std::erase_if(lost, [&](const std::string& name) {
    return tells_noise(name) || std::ranges::count(names, name) > 0;
  });
  if (lost.empty()) return;
  throw ImageError(fmt::format("{}: --update would lose its {}, which was not compared",
                               reference.string(), fmt::join(lost, " ")));
}

}  // namespace

void update_reference(const fs::path& reference, const Names& test, const std::string& part,
                      const Selection& selection) {
  Picture picture = read_picture("test", test, name_on_each_side(part).first);
  Names names = match(picture, picture, in_test(selection));
  const bool is_all = part.empty() && selection.channels.empty() && !selection.layer;
  if (is_all && test.size() == 1 && reference.extension() == fs::path(test.front()).extension()) {
    std::ifstream stream(test.front(), std::ios::binary);
    return write_file(reference, std::string(std::istreambuf_iterator<char>(stream), {}));
  }
  for (std::string& name : names) name = name_in_reference(name, selection);
  if (!is_all) refuse_loss(reference, names);
  if (image_format(reference) == ImageFormat::png && names != Names{"R", "G", "B"}) {
    throw ImageError(
        fmt::format("{}: cannot hold {}, only R G B", reference.string(), fmt::join(names, " ")));
  }
  write_image(compared_image(picture, names), reference);
}

}  // namespace plumb
