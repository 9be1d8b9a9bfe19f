// Between films and images: the picture with its noise, the replicates that merging needs, and the
// metadata.
#pragma once

#include "images/image.h"
#include "renderer/film.h"
#include "renderer/render.h"
#include "renderer/scene.h"
#include "renderer/settings.h"

namespace plumb {

// Channels R G B and, if two replicates have samples, variance.R G B. A part of a render also gets
// the mean of each replicate r that has samples, as replicate<r>.R G B.
Image to_image(const Film& film, bool is_part);

// Adds the samples of a part. Throws ImageError if it has another size or lacks a replicate.
void add_part(Film& film, const Image& part, const SampleRange& samples);

// All that the picture depends on, how noisy it is, and what it has cost.
Metadata describe(const Scene& scene, const Settings& settings, const SampleRange& samples,
                  const Film& film, const Cost& cost);

}  // namespace plumb
