// SPDX-License-Identifier: Apache-2.0

// Any bytes as a gate, and what CI servers are told of it.
#include <pugixml.hpp>
#include <stdexcept>

#include "compare/gate.h"
#include "tests/fuzz/stored.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  try {
    auto entries = plumb::read_gate(plumb::store("gate.toml", data, size));
    for (auto& entry : entries) {
      plumb::run_entry(entry, [](const auto& e) -> std::pair<plumb::Verdict, std::string> {
        for (const std::string& argument : e.arguments) {
          if (argument == "--codes") throw std::runtime_error(e.arguments.back());
        }
        return {plumb::Verdict::different, "different: " + e.arguments.back()};
      });
    }
    pugi::xml_document document;
    if (!document.load_string(plumb::to_junit(entries).c_str())) __builtin_trap();
  } catch (const std::runtime_error&) {
  }
  return 0;
}
