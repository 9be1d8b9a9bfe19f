// SPDX-License-Identifier: Apache-2.0

// Mean and noise of what was measured several times, independently.
#pragma once

namespace plumb {

// A value's replicates, which all count the same. Welford, "Note on a Method for Calculating
// Corrected Sums of Squares and Products", Technometrics 4(3), 1962.
template <typename Real>
struct Replicates {
  Real count = 0;
  Real mean = 0;
  Real squares = 0;  // the sum of the squared deviations from the mean

  void add(Real value) {
    const Real before = value - mean;
    mean += before / ++count;
    squares += before * (value - mean);
  }

  // The variance of the mean, without bias; 0 for a single replicate, which does not tell.
  Real variance() const { return count > 1 ? squares / (count * (count - 1)) : 0; }
};

}  // namespace plumb
