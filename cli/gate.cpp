#include "cli/gate.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <filesystem>
#include <pugixml.hpp>
#include <sstream>
#include <stdexcept>

namespace plumb::cli {
namespace {

// A value of the file as words of the command line.
void add_words(const toml::node& node, std::vector<std::string>& words) {
  if (const auto* list = node.as_array()) {
    for (const toml::node& item : *list) add_words(item, words);
  } else if (const auto text = node.value<std::string>()) {
    words.push_back(*text);
  } else {
    std::ostringstream stream;
    node.visit([&](const auto& value) { stream << value; });
    words.push_back(stream.str());
  }
}

Entry read_entry(const toml::table& table) {
  Entry entry;
  std::vector<std::string> positional;
  for (const auto& [key, node] : table) {
    const std::string name(key.str());
    if (name == "name") {
      entry.outcome.name = node.value_or("");
    } else if (name == "expect") {
      entry.outcome.expected = node.value_or("");
    } else if (name != "test" && name != "reference" &&
               !(node.is_boolean() && !node.value_or(true))) {
      entry.arguments.push_back("--" + name);
      if (!node.is_boolean()) add_words(node, entry.arguments);
    }
  }
  const std::string test = table["test"].value_or("");
  entry.arguments.insert(entry.arguments.begin(), {test, table["reference"].value_or("")});
  if (entry.outcome.name.empty()) entry.outcome.name = test;
  return entry;
}

}  // namespace

std::vector<Entry> read_gate(const std::string& file) {
  toml::table gate;
  try {
    gate = toml::parse_file(file);
  } catch (const toml::parse_error& error) {
    throw std::runtime_error(
        fmt::format("{}:{}: {}", file, error.source().begin.line, error.description()));
  }
  std::vector<Entry> entries;
  if (const auto* list = gate["compare"].as_array()) {
    for (const toml::node& node : *list) {
      if (const auto* table = node.as_table()) entries.push_back(read_entry(*table));
    }
  }
  if (entries.empty()) throw std::runtime_error(file + ": no [[compare]] in it");
  return entries;
}

std::string to_junit(const std::vector<Outcome>& outcomes) {
  pugi::xml_document document;
  pugi::xml_node suite = document.append_child("testsuite");
  suite.append_attribute("name") = "plumb compare";
  suite.append_attribute("tests") = outcomes.size();
  for (const Outcome& outcome : outcomes) {
    pugi::xml_node test = suite.append_child("testcase");
    test.append_attribute("name") = outcome.name.c_str();
    test.append_attribute("time") = outcome.seconds;
    if (outcome.verdict == outcome.expected) continue;
    pugi::xml_node failure = test.append_child(outcome.verdict == "trouble" ? "error" : "failure");
    failure.append_attribute("message") =
        fmt::format("{}, not {}", outcome.verdict, outcome.expected).c_str();
    failure.text() = outcome.text.c_str();
  }
  std::ostringstream stream;
  document.save(stream, "  ");
  return stream.str();
}

}  // namespace plumb::cli
