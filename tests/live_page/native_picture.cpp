// SPDX-License-Identifier: Apache-2.0

// A picture of `plumb`'s renderer on the instruction set that WebAssembly's vectors are like: SSE4,
// which has no fused multiply-add either. Writes means and variances as 32-bit floats, and tells
// what they cost and claim:
//   native_picture SCENE.xml SAMPLES FILE
#include <fmt/format.h>
#include <hwy/targets.h>

#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "renderer/film.h"
#include "renderer/render.h"
#include "scene_files/scene_reader.h"

int main(int argc, char** argv) {
  if (argc != 4 || (hwy::SupportedTargets() & HWY_SSE4) == 0) return 1;
  hwy::SetSupportedTargetsForTest(HWY_SSE4);
  const plumb::Scene scene = plumb::read_scene(argv[1]);
  plumb::Film film(scene.camera.width, scene.camera.height);
  const plumb::Cost cost = render(scene, {.seed = 1, .bounces = {}, .threads = 1},
                                  {.samples = {0, std::stoi(argv[2])}}, film);
  std::ofstream file(argv[3], std::ios::binary);
  for (const std::vector<float>& values : {film.mean(), film.variance()}) {
    file.write(reinterpret_cast<const char*>(values.data()),
               static_cast<std::streamsize>(values.size() * sizeof(float)));
  }
  fmt::print("{{\"samplesPerSecond\": {}, \"relativeError\": {}}}\n",
             static_cast<double>(cost.samples) / cost.wall_seconds, film.relative_error());
  return file.good() ? 0 : 1;
}
