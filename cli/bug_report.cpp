// SPDX-License-Identifier: Apache-2.0

#include "cli/bug_report.h"

#include <Imath/ImathConfig.h>
#include <OpenEXR/OpenEXRConfig.h>
#include <OpenImageIO/oiioversion.h>
#include <fmt/format.h>
#include <hwy/highway.h>
#include <sys/utsname.h>
#include <tbb/version.h>
#include <CLI/Version.hpp>
#include <pugixml.hpp>

#include <boost/version.hpp>
#include <fstream>

#include "cli/film_image.h"
#include "cli/scene_options.h"
#include "other_renderers/runner.h"
#include "renderer/trace.h"

namespace plumb::cli {
namespace {

std::string system_name() {
  std::string name = "unknown system";
  std::ifstream release("/etc/os-release");
  for (std::string line; std::getline(release, line);) {
    if (line.starts_with("PRETTY_NAME=\"")) name = line.substr(13, line.size() - 14);
  }
  utsname kernel{};
  ::uname(&kernel);
  return fmt::format("{}, {} {}, {}", name, kernel.sysname, kernel.release, kernel.machine);
}

// Those that it was compiled with; of oneTBB the one that runs, too.
std::string libraries() {
  // 90100 is 9.1.0, and 1130 is 1.13.
  const auto fmt =
      fmt::format("{}.{}.{}", FMT_VERSION / 10000, FMT_VERSION / 100 % 100, FMT_VERSION % 100);
  const auto pugixml = fmt::format("{}.{}", PUGIXML_VERSION / 1000, PUGIXML_VERSION / 10 % 100);
  return fmt::format(
      "OpenImageIO {}, OpenEXR {}, Imath {}, Highway {}.{}.{}, oneTBB {} ({}), Boost {}, fmt {}, "
      "pugixml {}, CLI11 {}",
      OIIO_VERSION_STRING, OPENEXR_VERSION_STRING, IMATH_VERSION_STRING, HWY_MAJOR, HWY_MINOR,
      HWY_PATCH, TBB_VERSION_STRING, TBB_runtime_version(), BOOST_LIB_VERSION, fmt, pugixml,
      CLI11_VERSION);
}

}  // namespace

std::string bug_report() {
  std::string text = "plumb " PLUMB_VERSION;
  const auto add = [&](const std::string& what, const std::string& value) {
    text += fmt::format("\n{:<10} {}", what, value);
  };
  add("commit", PLUMB_COMMIT);
  add("compiler", PLUMB_COMPILER);
  add("processor", fmt::format("{}, {}", host(0), trace_target()));
  add("system", system_name());
  add("libraries", libraries());
  add("scenes", scene_folder().string());
  for (const OtherRenderer& renderer : other_renderers()) {
    add(renderer.word, installed_version(renderer).value_or("not found"));
  }
  return text;
}

}  // namespace plumb::cli
