// SPDX-License-Identifier: Apache-2.0

// What two pictures have in common besides the scene, by what they say of themselves: the samples,
// and with them the noise.
#pragma once

#include "compare/picture.h"

namespace plumb {

// Whether both took the very same samples: our program with the same method, sampler, bounces, seed
// and samples, and the same size. Version and precision may differ, and so may the scene: what
// changed may be the thing to be found. Of two means of several files nothing is known.
bool are_paired(const Picture& a, const Picture& b);

// Whether both took some samples in common, so that the difference has less noise than the two have
// together: the same program and scene, and samples of both that have the same seed. Of our program
// all samples of a picture have one seed; of another one each replicate has its own, counted from
// the first one. A picture that doesn't tell has none in common with any.
bool share_samples(const Picture& a, const Picture& b);

// Throws ImageError if both tell which scene they are of, and it is not the same.
void refuse_other_scenes(const Picture& a, const Picture& b);

}  // namespace plumb
