// SPDX-License-Identifier: Apache-2.0

// Any bytes as a scene; one that is accepted is rendered, small.
#include "renderer/render.h"
#include "scene_files/scene_reader.h"
#include "tests/fuzz/stored.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  static const auto mesh =
      plumb::store("a.obj", reinterpret_cast<const uint8_t*>(triangle.data()), triangle.size());
  try {
    plumb::Scene scene = plumb::read_scene(plumb::store("scene.xml", data, size));
    scene.camera.width = scene.camera.height = 2;
    plumb::Film film(2, 2);
    plumb::Settings settings;
    settings.threads = 1;
    settings.bounces = {0, 3};
    plumb::render(scene, settings, {{0, 2}}, film);
  } catch (const plumb::SceneError&) {
  }
  return 0;
}
