// SPDX-License-Identifier: Apache-2.0

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <stdexcept>

#include "cli/diagnosis.h"
#include "cli/names.h"
#include "cli/scene_options.h"
#include "cli/words.h"
#include "python/bindings.h"

namespace plumb::python {
namespace {

struct Diagnosed {
  cli::Diagnosis diagnosis;
  double tolerance;
};

Diagnosed diagnose(Picture test, const Scene& scene, const std::string& tolerance,
                   const nb::object& progress) {
  test.side = "test";
  const double least = parse_fraction(tolerance);
  cli::warn_of_another_version(scene, test);
  auto found = watched(progress, [&](Watch& watch) {
    const auto show = [&](const std::string& text) { watch.show(text); };
    return cli::diagnose(scene, test, least, show, watch.stop);
  });
  if (!found) throw std::runtime_error("interrupted");
  return {std::move(*found), least};
}

Exhibit converge(const Words& words, const nb::object& progress) {
  return watched(progress, [&](Watch& watch) {
    return cli::converge(words, {[&](const std::string& text) { watch.show(text); }, watch.stop});
  });
}

}  // namespace

void bind_studies(nb::module_& module) {
  using cli::Suspect;
  nb::class_<Suspect>(module, "Suspect")
      .def_prop_ro("name", &cli::name_of)
      .def_ro("explained", &Suspect::explained)
      .def_prop_ro("is_refuted", [](const Suspect& s) { return s.agreement.is_refuted; })
      .def_prop_ro("within", [](const Suspect& s) { return s.agreement.within; })
      .def_prop_ro("rest", [](const Suspect& s) { return s.agreement.rest; });
  nb::class_<Diagnosed>(module, "Diagnosis")
      .def_prop_ro(
          "verdict",
          [](const Diagnosed& d) { return to_string(cli::verdict_of(d.diagnosis, d.tolerance)); })
      .def_prop_ro("suspects", [](const Diagnosed& d) { return d.diagnosis.suspects; })
      .def_prop_ro("tried", [](const Diagnosed& d) { return d.diagnosis.tried; })
      .def("__str__", [](const Diagnosed& d) { return cli::to_text(d.diagnosis, d.tolerance); });
  module.def("diagnose", diagnose, nb::arg("picture"), nb::arg("scene"), nb::arg("tolerance"),
             nb::arg("progress").none());
  nb::class_<Exhibit>(module, "Exhibit")
      .def_prop_ro("json", [](const Exhibit& e) { return to_json(e).dump(); })
      .def("__str__", [](const Exhibit& e) { return to_text(e); })
      .def(
          "write_plot", [](const Exhibit& e, const std::string& file) { write_plot(e.plot, file); },
          nb::arg("file"), nb::call_guard<nb::gil_scoped_release>());
  module.def("converge", converge, nb::arg("words"), nb::arg("progress").none());
}

}  // namespace plumb::python
