// SPDX-License-Identifier: Apache-2.0

// Makes a test the new reference.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "compare/picture.h"

namespace plumb {

// Writes what was compared, in the format that the reference's name says: a copy of the file if it
// is one file of that format, all of which is compared; else the selected channels by their names
// in the reference, and their variances, of the picture that read_picture() makes of the files.
// Throws FileError if the test is no fit picture, if the format can't hold the channels, or if the
// reference has other channels than the selected ones, which would be lost.
void update_reference(const std::filesystem::path& reference, const std::vector<std::string>& test,
                      const std::string& part, const Selection& selection);

}  // namespace plumb
