// SPDX-License-Identifier: Apache-2.0

#include "compare/gate.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <chrono>
#include <exception>
#include <pugixml.hpp>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <tuple>

#include "images/printable.h"

namespace plumb {
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

[[noreturn]] void refuse(const toml::source_region& place, std::string_view reason) {
  throw std::runtime_error(fmt::format("{}:{}: {}", *place.path, place.begin.line, reason));
}

Verdict parse_verdict(const toml::node& node) {
  for (const Verdict verdict :
       {Verdict::same, Verdict::different, Verdict::inconclusive, Verdict::trouble}) {
    if (node.value_or(std::string()) == to_string(verdict)) return verdict;
  }
  refuse(node.source(), "'expect' is not one of same, different, inconclusive, trouble");
}

GateEntry read_entry(const toml::table& table) {
  const std::string test = table["test"].value_or("");
  GateEntry entry;
  entry.name = printable(table["name"].value_or(test));
  if (const toml::node* expected = table.get("expect")) entry.expected = parse_verdict(*expected);
  entry.arguments = {test, table["reference"].value_or("")};
  for (const auto& [key, node] : table) {
    const std::string_view name = key.str();
    if (name == "test" || name == "reference" || name == "name" || name == "expect") continue;
    if (node.is_boolean() && !node.value_or(true)) continue;
    entry.arguments.push_back(fmt::format("--{}", name));
    if (!node.is_boolean()) add_words(node, entry.arguments);
  }
  return entry;
}

// Their names, as seen from the folder.
void add_pictures(const std::filesystem::path& folder, std::set<std::string>& names) {
  const std::set<std::string> extensions = {".exr",  ".png", ".hdr",  ".pfm",  ".tif",
                                            ".tiff", ".jpg", ".jpeg", ".webp", ".tga",
                                            ".bmp",  ".dpx", ".ppm"};
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file() && extensions.contains(entry.path().extension().string()))
      names.insert(entry.path().lexically_relative(folder).string());
  }
}

}  // namespace

std::vector<GateEntry> pair_folders(const std::filesystem::path& test,
                                    const std::filesystem::path& reference) {
  std::set<std::string> names;
  add_pictures(test, names);
  add_pictures(reference, names);
  std::vector<GateEntry> entries;
  for (const std::string& name : names) {
    entries.push_back({.name = printable(name), .arguments = {test / name, reference / name}});
  }
  if (entries.empty()) {
    throw std::runtime_error(
        fmt::format("no picture in {} or {}", test.string(), reference.string()));
  }
  return entries;
}

std::vector<GateEntry> read_gate(const std::filesystem::path& file) {
  std::vector<GateEntry> entries;
  try {
    const toml::table gate = toml::parse_file(file.string());
    if (const auto* list = gate["compare"].as_array()) {
      for (const toml::node& node : *list) {
        const auto* table = node.as_table();
        if (table == nullptr) refuse(node.source(), "not a [[compare]]");
        entries.push_back(read_entry(*table));
      }
    }
  } catch (const toml::parse_error& error) {
    refuse(error.source(), error.description());
  }
  if (entries.empty()) throw std::runtime_error(file.string() + ": no [[compare]] in it");
  return entries;
}

void run_entry(GateEntry& entry,
               const std::function<std::pair<Verdict, std::string>(const GateEntry&)>& compare) {
  const auto start = std::chrono::steady_clock::now();
  entry.verdict = Verdict::trouble;
  try {
    std::tie(entry.verdict, entry.explanation) = compare(entry);
  } catch (const std::exception& error) {
    entry.explanation = fmt::format("trouble: {}\n", printable(error.what(), LineEnds::kept));
  } catch (...) {
    entry.explanation = "trouble: unknown exception\n";
  }
  entry.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

int exit_code_of(const std::vector<GateEntry>& entries) {
  for (const Verdict gravest :
       {Verdict::trouble, Verdict::different, Verdict::same, Verdict::inconclusive}) {
    for (const GateEntry& entry : entries) {
      if (entry.is_as_expected() || entry.verdict != gravest) continue;
      return std::max(1, static_cast<int>(gravest));
    }
  }
  return 0;
}

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
