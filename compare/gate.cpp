// SPDX-License-Identifier: Apache-2.0

#include "compare/gate.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <chrono>
#include <exception>
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

Verdict parse_verdict(const toml::node& node) {
  const std::string word = node.value_or("");
  std::string all;
  for (const Verdict verdict :
       {Verdict::same, Verdict::different, Verdict::inconclusive, Verdict::trouble}) {
    if (word == to_string(verdict)) return verdict;
    all += fmt::format("{}{}", all.empty() ? "" : ", ", to_string(verdict));
  }
  const toml::source_region& place = node.source();
  throw std::runtime_error(
      fmt::format("{}:{}: 'expect' is not one of {}", *place.path, place.begin.line, all));
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
    if (!entry.is_regular_file() || !extensions.contains(entry.path().extension().string()))
      continue;
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
        if (table == nullptr) {
          throw std::runtime_error(
              fmt::format("{}:{}: not a [[compare]]", file.string(), node.source().begin.line));
        }
        entries.push_back(read_entry(*table));
      }
    }
  } catch (const toml::parse_error& error) {
    throw std::runtime_error(
        fmt::format("{}:{}: {}", file.string(), error.source().begin.line, error.description()));
  }
  if (entries.empty()) throw std::runtime_error(file.string() + ": no [[compare]] in it");
  return entries;
}

void run_entry(GateEntry& entry,
               const std::function<std::pair<Verdict, std::string>(const GateEntry&)>& compare) {
  const auto start = std::chrono::steady_clock::now();
  try {
    std::tie(entry.verdict, entry.explanation) = compare(entry);
  } catch (const std::exception& error) {
    entry.verdict = Verdict::trouble;
    entry.explanation =
        fmt::format("{}: {}\n", to_string(entry.verdict), printable(error.what(), LineEnds::kept));
  } catch (...) {
    entry.verdict = Verdict::trouble;
    entry.explanation = fmt::format("{}: unknown exception\n", to_string(entry.verdict));
  }
  entry.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

int exit_code_of(const std::vector<GateEntry>& entries) {
  for (const Verdict gravest :
       {Verdict::trouble, Verdict::different, Verdict::same, Verdict::inconclusive}) {
    const auto is_such = [&](const GateEntry& entry) {
      return !entry.is_as_expected() && entry.verdict == gravest;
    };
    if (std::ranges::any_of(entries, is_such)) return std::max(1, static_cast<int>(gravest));
  }
  return 0;
}

}  // namespace plumb
