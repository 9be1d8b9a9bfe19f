// SPDX-License-Identifier: Apache-2.0

#include "radiosity/teaching/patch_picture.h"

#include <cmath>
#include <utility>

#include "radiosity/faces.h"
#include "radiosity/teaching/exchange.h"
#include "radiosity/teaching/film.h"

namespace plumb::radiosity::teaching {

Picture draw_patches(const Scene& scene, const Settings& settings, const Work& work) {
  const auto most = static_cast<size_t>(std::sqrt(double(settings.most_bytes) / sizeof(double)));
  Picture best;
  try {
    const Faces faces(scene, settings.most_bytes, work);
    for (const size_t count : {250, 1000}) {
      const Patches patches = Patches::of_about(faces, count, true, most);
      const Exchange exchange(patches, form_factors(patches, work), work);
      Picture next{.rgb = Film(patches, scene.camera, work).flat(exchange.light(settings.bounces)),
                   .elements = patches.size(),
                   .links = patches.size() * patches.size(),
                   .level = best.level + 1};
      if (best.level >= 0) estimate_error(next, best, scene.camera);
      best = std::move(next);
    }
  } catch (const Stopped&) {
    best.why_ended = "interrupted";
  }
  return best;
}

}  // namespace plumb::radiosity::teaching
