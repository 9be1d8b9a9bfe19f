// SPDX-License-Identifier: Apache-2.0

// A picture of what `plumb render --samples` and `--crop` have drawn of it.
#pragma once

#include <string>
#include <vector>

#include "images/image.h"

namespace plumb::cli {

// The parts in these files, in any order, as one: those of the same pixels have samples that follow
// each other, and different ones make up a rectangle. It has the bits that rendering it at once
// would have given, and the sums that more samples can be added to if the parts have them. It holds
// the whole and, of the parts, those of the same pixels at once.
//
// `is_last` says that nothing will be added: the sums are left out, and parts of different pixels
// have to make up the picture. Throws ImageError, which names the file or what overlaps or lacks.
Image merge_parts(const std::vector<std::string>& files, bool is_last);

}  // namespace plumb::cli
