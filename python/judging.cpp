// SPDX-License-Identifier: Apache-2.0

#include "compare/judging.h"

#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "cli/words.h"
#include "compare/maps.h"
#include "images/printable.h"
#include "python/bindings.h"

namespace plumb::python {
namespace {

using Labels = nb::ndarray<const int, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

// Two pictures and what was found of them.
struct Judgment {
  Picture test, reference;
  Judged judged;

  Picture map(const std::string& kind) const {
    return to_picture("map", draw_map(cli::parse_map(kind), test, reference, judged.window,
                                      judged.comparison.flip));
  }
};

// Regions of pixels that lie at `window` in a picture of this size.
struct PlacedRegions {
  Regions regions;
  Window window;
  int width, height;

  // For a picture that has that size, or these pixels alone.
  Regions in(const Image& image) const {
    if (image.width == window.width && image.height == window.height) return regions;
    if (image.width != width || image.height != height) {
      throw std::invalid_argument(
          fmt::format("regions: a mask of {} x {} pixels is needed", image.width, image.height));
    }
    Regions whole{regions.names, std::vector(image.pixel(0, height), -1), regions.excludes_rest};
    for (int y = 0; y < window.height; ++y) {
      std::copy_n(&regions.of_pixel[size_t(y) * size_t(window.width)], window.width,
                  &whole.of_pixel[image.pixel(window.x, window.y + y)]);
    }
    return whole;
  }
};

// -1 for pixels in no region. `place` is where they lie, and the size of the whole picture; without
// it they are all of it.
PlacedRegions to_regions(const Words& names, const Labels& labels, bool excludes_rest,
                         const std::optional<std::array<int, 4>>& place) {
  const int width = int(labels.shape(1)), height = int(labels.shape(0));
  const auto [x, y, whole_width, whole_height] = place.value_or(std::array{0, 0, width, height});
  return {{names, {labels.data(), labels.data() + labels.size()}, excludes_rest},
          {x, y, width, height},
          whole_width,
          whole_height};
}

Judgment compare_pictures(Picture test, Picture reference, const Words& words,
                          const std::optional<PlacedRegions>& regions,
                          const std::optional<std::string>& mask, const std::string& test_name,
                          const std::string& reference_name, bool is_reference_a_file) {
  test.side = "test";
  reference.side = "reference";
  const ComparisonTerms terms = cli::parse_terms(words);
  bring_together(test, reference, terms);
  const Image& image = test.image;
  Regions used;
  if (regions) used = regions->in(image);
  if (mask) used = read_regions(*mask, image.width, image.height);
  std::optional<std::filesystem::path> file;
  if (is_reference_a_file) file = reference_name;
  Judged judged = judge(test, reference, used, terms, file);
  judged.files.test = printable(test_name);
  judged.files.reference = printable(reference_name);
  return {std::move(test), std::move(reference), std::move(judged)};
}

}  // namespace

void bind_judging(nb::module_& module) {
  nb::class_<PlacedRegions>(module, "Regions");
  module.def("regions", to_regions, nb::arg("names"), nb::arg("labels"), nb::arg("excludes_rest"),
             nb::arg("place").none() = nb::none());
  nb::class_<Judgment>(module, "Judgment")
      .def_prop_ro("verdict",
                   [](const Judgment& j) { return to_string(j.judged.comparison.verdict); })
      .def_prop_ro("explanation", [](const Judgment& j) { return j.judged.explanation(); })
      .def_prop_ro("report",
                   [](const Judgment& j) { return to_text(j.judged.comparison, j.judged.files); })
      .def_prop_ro(
          "json",
          [](const Judgment& j) { return to_json(j.judged.comparison, j.judged.files).dump(); })
      .def_ro("test", &Judgment::test)
      .def_ro("reference", &Judgment::reference)
      .def("map", &Judgment::map, nb::arg("kind"), nb::call_guard<nb::gil_scoped_release>());
  module.def("compare", compare_pictures, nb::arg("test"), nb::arg("reference"), nb::arg("words"),
             nb::arg("regions").none(), nb::arg("mask").none(), nb::arg("test_name"),
             nb::arg("reference_name"), nb::arg("is_reference_a_file"),
             nb::call_guard<nb::gil_scoped_release>());
}

}  // namespace plumb::python
