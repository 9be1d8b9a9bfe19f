// Many comparisons in one go, as a file lists them.
#pragma once

#include <string>
#include <vector>

#include "compare/equivalence.h"

namespace plumb::cli {

// How a comparison ended, beside what was expected.
struct Outcome {
  std::string name;
  std::string verdict;  // or "trouble"
  std::string expected = "same";
  std::string text;  // why
  double seconds = 0;
};

// A comparison in a gate file:
//   [[compare]]
//   test = "out/cornell.exr"              # relative to the gate file
//   reference = "references/cornell.exr"
//   tolerance = "0.5%"                    # any option of 'plumb compare', without its dashes
//   name = "Cornell box"                  # default: the test's file name
//   expect = "different"                  # for a companion that must fail; default: "same"
struct Entry {
  Outcome outcome;
  std::vector<std::string> arguments;  // of 'plumb compare'
};

// Throws std::runtime_error with the place of what is wrong.
std::vector<Entry> read_gate(const std::string& file);

// JUnit's XML, as CI servers read it.
std::string to_junit(const std::vector<Outcome>& outcomes);

}  // namespace plumb::cli
