// SPDX-License-Identifier: Apache-2.0

// Any bytes as a mesh: PLY if they begin so, else OBJ.
#include "scene_files/mesh_reader.h"

#include <cstdint>

#include "scene_files/scene_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    (text.starts_with("ply") ? plumb::read_ply : plumb::read_obj)("a", text, {});
  } catch (const plumb::SceneError&) {
  }
  return 0;
}
