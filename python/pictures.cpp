// SPDX-License-Identifier: Apache-2.0

#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <fmt/format.h>

#include <algorithm>

#include "compare/picture.h"
#include "images/provenance_attributes.h"
#include "python/bindings.h"

namespace plumb::python {
namespace {

using View = nb::ndarray<nb::numpy, const float, nb::ndim<3>>;
using Values = nb::ndarray<const float, nb::ndim<3>, nb::c_contig, nb::device::cpu>;

View view(nb::handle owner, const Image& image, const std::vector<float>& values) {
  return View(
      values.data(),
      {size_t(image.height), size_t(image.width), values.size() / image.pixel(0, image.height)},
      owner);
}

// With "variance." channels if there are variances.
Picture from_arrays(const Values& values, const Words& channels,
                    const std::optional<Values>& variances, int64_t samples) {
  Image image{int(values.shape(1)), int(values.shape(0)), channels, {}, {}};
  if (samples > 0) image.provenance.samples = fmt::format("0:{}", samples);
  const size_t stride = channels.size();
  if (!variances) {
    image.values.assign(values.data(), values.data() + values.size());
    return to_picture("picture", std::move(image));
  }
  for (const std::string& channel : channels) image.channels.push_back("variance." + channel);
  image.values.resize(2 * values.size());
  for (size_t i = 0; i < values.size(); i += stride) {
    std::copy_n(values.data() + i, stride, &image.values[2 * i]);
    std::copy_n(variances->data() + i, stride, &image.values[2 * i + stride]);
  }
  return to_picture("picture", std::move(image));
}

Picture mean(const std::vector<const Picture*>& pictures) {
  return mean_of("picture", pictures.size(), [&](size_t i) { return pictures[i]->image; });
}

// The picture as an image that holds its noise, too.
Image whole_image(const Picture& picture) {
  Image image = picture.image;
  if (picture.file_variances.empty()) return image;
  const size_t stride = image.channels.size();
  std::vector<size_t> pictured;
  image.channels.clear();
  for (size_t c = 0; c < stride; ++c) {
    if (!tells_noise(picture.image.channels[c])) pictured.push_back(c);
  }
  for (const char* prefix : {"", "variance."}) {
    for (const size_t c : pictured) image.channels.push_back(prefix + picture.image.channels[c]);
  }
  image.values.clear();
  for (size_t i = 0; i < picture.image.values.size(); i += stride) {
    for (const size_t c : pictured) image.values.push_back(picture.image.values[i + c]);
    for (const size_t c : pictured) image.values.push_back(picture.file_variances[i + c]);
  }
  image.provenance.replicates = static_cast<int>(picture.degrees_of_freedom) + 1;
  return image;
}

}  // namespace

void bind_pictures(nb::module_& module) {
  nb::class_<Picture>(module, "Picture")
      .def_prop_ro("width", [](const Picture& p) { return p.image.width; })
      .def_prop_ro("height", [](const Picture& p) { return p.image.height; })
      .def_prop_ro("channels", [](const Picture& p) { return p.image.channels; })
      .def_prop_ro("notes", [](const Picture& p) { return p.image.notes; })
      .def_prop_ro("samples_per_pixel", [](const Picture& p) { return p.samples_per_pixel(); })
      .def_prop_ro("provenance", [](const Picture& p) { return to_attributes(p.image.provenance); })
      .def_prop_ro("values",
                   [](nb::handle_t<Picture> self) {
                     const auto& p = nb::cast<const Picture&>(self);
                     return view(self, p.image, p.image.values);
                   })
      .def_prop_ro("variances",
                   [](nb::handle_t<Picture> self) -> std::optional<View> {
                     const auto& p = nb::cast<const Picture&>(self);
                     if (p.file_variances.empty()) return {};
                     return view(self, p.image, p.file_variances);
                   })
      .def(
          "write",
          [](const Picture& p, const std::string& file, double exposure) {
            write_image(whole_image(p), file, exposure);
          },
          nb::arg("file"), nb::arg("exposure"), nb::call_guard<nb::gil_scoped_release>());
  module.def(
      "read",
      [](const Words& files, const std::string& part, bool codes) {
        return read_picture("picture", files, part, codes ? Integers::codes : Integers::linear);
      },
      nb::arg("files"), nb::arg("part"), nb::arg("codes"),
      nb::call_guard<nb::gil_scoped_release>());
  module.def("from_arrays", from_arrays, nb::arg("values"), nb::arg("channels"),
             nb::arg("variances").none(), nb::arg("samples"));
  module.def("mean", mean, nb::arg("pictures"), nb::call_guard<nb::gil_scoped_release>());
}

}  // namespace plumb::python
