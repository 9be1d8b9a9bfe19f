// SPDX-License-Identifier: Apache-2.0

// Mitsuba 3, which reads scene files as they are.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "other_renderers/export.h"
#include "other_renderers/plumbline_mitsuba.py.h"

namespace plumb {
namespace {

std::vector<Run> runs(const Job& job) {
  const double x_fov = 360.0 / std::numbers::pi * std::atan(job.scene.camera.half_width());
  return script_call({"python3", "plumbline_mitsuba.py", job.file}, job,
                     {"--x-fov", fmt::format("{}", x_fov)});
}

}  // namespace

OtherRenderer mitsuba() {
  return {.word = "mitsuba",
          .name = "Mitsuba",
          .software = "Mitsuba",
          .probe = {"python3", "-c", "import mitsuba; print(mitsuba.__version__)"},
          .how_to_install = "python3 is not installed, which Mitsuba needs",
          .script_name = "plumbline_mitsuba.py",
          .script = plumbline_mitsuba_py,
          .runs = runs};
}

}  // namespace plumb
