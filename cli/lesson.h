// SPDX-License-Identifier: Apache-2.0

// What a course on radiosity shows, made of any scene of matte polygons.
#pragma once

#include <filesystem>

#include "radiosity/work.h"
#include "scene/scene.h"

namespace plumb::cli {

// Writes pictures, plots, and lesson.json with all numbers into a folder, part by part;
// pictures are brighter by so many stops. Throws what radiosity::draw() throws,
// std::invalid_argument if there is no lamp, radiosity::Stopped, FileError, and std::runtime_error
// if gnuplot is not installed.
void teach(const Scene& scene, const std::filesystem::path& folder, double exposure,
           size_t most_bytes, const radiosity::Work& work);

}  // namespace plumb::cli
