// SPDX-License-Identifier: Apache-2.0

// Renders a scene eight times, and compares the mean of the first four pictures with that of the
// others: a program by somebody who has Plumbline installed.
#include <cstdio>
#include <string>
#include <vector>

#include "compare/report.h"
#include "renderer/render.h"
#include "scene_files/scene_reader.h"

plumb::Picture draw(const plumb::Scene& scene, const std::string& side, uint32_t first_seed) {
  std::vector<std::string> files;
  for (uint32_t seed = first_seed; seed < first_seed + 4; ++seed) {
    plumb::Film film(scene.camera.width, scene.camera.height);
    plumb::render(scene, {.seed = seed, .bounces = {}}, {.samples = {0, 16}}, film);
    files.push_back(std::to_string(seed) + ".exr");
    plumb::write_image({film.width(), film.height(), {"R", "G", "B"}, film.mean(), {}},
                       files.back());
  }
  return plumb::read_picture(side, files, "");
}

int main(int, char** arguments) {
  const plumb::Scene scene = plumb::read_scene(arguments[1]);
  plumb::Picture test = draw(scene, "test", 0);
  plumb::Picture reference = draw(scene, "reference", 4);
  const auto channels = plumb::match(test, reference, {}, false);
  const plumb::Window whole{0, 0, scene.camera.width, scene.camera.height};
  const auto comparison = plumb::compare(test, reference, channels, whole, {}, {});
  std::printf("%s", plumb::explain(comparison, {}).c_str());
  return comparison.verdict == plumb::Verdict::different ? 1 : 0;
}
