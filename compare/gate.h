// SPDX-License-Identifier: Apache-2.0

// A gate: a list of comparisons, each with the verdict that it must end with.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "compare/equivalence.h"

namespace plumb {

// A comparison in a gate file, and how it ended:
//   [[compare]]
//   test = "out/cornell.exr"              # relative to the gate file
//   reference = "references/cornell.exr"
//   tolerance = "0.5%"                    # any option of 'plumb compare', without its dashes
//   name = "Cornell box"                  # default: the test's file name
//   expect = "different"                  # for a companion that must fail; default: "same"
struct GateEntry {
  std::string name;
  Verdict expected = Verdict::same;
  std::vector<std::string> arguments;  // of 'plumb compare': both files, then the options

  Verdict verdict = Verdict::trouble;
  std::string explanation = {};  // in its first line the verdict with its reason
  double seconds = 0;            // that the comparison took

  bool is_as_expected() const { return verdict == expected; }
};

// Reads a gate file. Throws std::runtime_error, with the place, if it is not valid TOML, lists no
// comparison, or expects what is no verdict.
std::vector<GateEntry> read_gate(const std::filesystem::path& file);

// An entry for each picture (by its extension) in either of two folders and the folders in them;
// those of the same name are a pair. Throws std::runtime_error if there is none.
std::vector<GateEntry> pair_folders(const std::filesystem::path& test,
                                    const std::filesystem::path& reference);

// Fills in how an entry ended. `compare` gives the verdict and its explanation; what it throws,
// whatever that is, is trouble.
void run_entry(GateEntry& entry,
               const std::function<std::pair<Verdict, std::string>(const GateEntry&)>& compare);

// 0 if all entries ended as expected; else the exit code of the gravest one that did not: trouble
// (2) before different (1), also for what should have been different and is not, before
// inconclusive (3).
int exit_code_of(const std::vector<GateEntry>& entries);

// For CI servers JUnit's XML: a test case for each entry. One that did not end as expected is an
// error if it was trouble, else a failure.
std::string to_junit(const std::vector<GateEntry>& entries);

}  // namespace plumb
