// SPDX-License-Identifier: Apache-2.0

#include "compare/junit.h"

#include <fmt/format.h>

#include <pugixml.hpp>
#include <sstream>

namespace plumb {

std::string to_junit(const std::vector<GateEntry>& entries) {
  pugi::xml_document document;
  pugi::xml_node suite = document.append_child("testsuite");
  suite.append_attribute("name") = "plumb compare";
  suite.append_attribute("tests") = entries.size();
  for (const GateEntry& entry : entries) {
    pugi::xml_node test = suite.append_child("testcase");
    test.append_attribute("name") = entry.name.c_str();
    test.append_attribute("time") = entry.seconds;
    if (entry.is_as_expected()) continue;
    const bool is_trouble = entry.verdict == Verdict::trouble;
    pugi::xml_node failure = test.append_child(is_trouble ? "error" : "failure");
    failure.append_attribute("message") =
        fmt::format("{}, not {}", to_string(entry.verdict), to_string(entry.expected)).c_str();
    failure.text() = entry.explanation.c_str();
  }
  std::ostringstream stream;
  document.save(stream, "  ");
  return stream.str();
}

}  // namespace plumb
