// SPDX-License-Identifier: Apache-2.0

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <CLI/CLI.hpp>
#include <mutex>
#include <stdexcept>

#include "cli/scene_options.h"
#include "images/output_file.h"
#include "images/printable.h"
#include "python/bindings.h"
#include "radiosity/work.h"
#include "scene_files/scene_reader.h"

namespace plumb::python {
namespace {

// What the libraries say to the user, until Python asks for it.
std::mutex notices_mutex;
Words notices;

void hear(const std::string& line) {
  const std::lock_guard lock(notices_mutex);
  notices.push_back(printable(line));
}

Words take_notices() {
  const std::lock_guard lock(notices_mutex);
  return std::exchange(notices, {});
}

void raise(const char* name, const std::exception& error) {
  const nb::object type = nb::module_::import_("plumbline.errors").attr(name);
  PyErr_SetString(type.ptr(), printable(error.what(), LineEnds::kept).c_str());
}

void translate(const std::exception_ptr& thrown, void*) {
  try {
    std::rethrow_exception(thrown);
  } catch (const SceneError& error) {
    raise("SceneError", error);
  } catch (const FileError& error) {
    raise("PictureError", error);
  } catch (const CLI::Error& error) {
    raise("ArgumentError", error);
  } catch (const std::invalid_argument& error) {
    raise("ArgumentError", error);
  } catch (const std::runtime_error& error) {
    raise("Error", error);
  }
}

}  // namespace

NB_MODULE(_core, module) {
  module.attr("version") = PLUMB_VERSION;
  module.def("take_notices", take_notices);
  cli::say = hear;
  nb::register_exception_translator(translate);
  bind_pictures(module);
  bind_scenes(module);
  bind_judging(module);
  bind_studies(module);
}

}  // namespace plumb::python
