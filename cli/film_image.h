// SPDX-License-Identifier: Apache-2.0

// From films and masks to images and back: the picture with its noise, the replicates that merging
// needs, and the provenance.
#pragma once

#include "compare/picture.h"
#include "images/image.h"
#include "renderer/film.h"
#include "renderer/render.h"
#include "renderer/settings.h"
#include "scene/scene.h"
#include "scene_files/region_mask.h"

#include <string>

namespace plumb {

// Channels R G B and, if two replicates have samples, variance.R G B. A part of a render also gets
// the sum of each replicate r that has samples, exactly: replicate<r>.sum<k>.R G B, k = 0 to 3, add
// up to it.
Image to_image(const Film& film, bool is_part);

// The same for a comparison: its replicates are those that have samples.
Picture to_picture(const std::string& side, const Film& film);

// Whether it has the sums of replicates, of which samples can be added; and an image without them.
bool has_sums(const Image& image);
Image without_sums(Image image);
inline constexpr const char* lacks_sums =
    "lacks sums: only what --samples has rendered can get more samples";

// Says in the image where its pixels lie in a picture of this size; nothing if they are all of it.
void put_into_picture(Image& image, const Window& window, int width, int height);

// A colour for each region, the same in all of the scene's masks of a kind, and black for none; the
// provenance says the regions' names. Where the window lies in the camera's picture is said, too.
Image to_image(const RegionMask& mask, const Window& window, const Camera& camera);

// Adds the samples of a part, which has the film's window. Throws ImageError if it lacks a sum.
void add_part(Film& film, const Image& part, const SampleRange& samples);

// Processor (named by /proc on x86 only) and threads; 0: as many as the machine has.
std::string host(int most_threads);

// All that the picture depends on, how noisy it is, and what it has cost.
Provenance describe(const Scene& scene, const Settings& settings, const SampleRange& samples,
                    const Film& film, const Cost& cost);

}  // namespace plumb
