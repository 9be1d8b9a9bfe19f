// SPDX-License-Identifier: Apache-2.0

// Reads scene files: a subset of Mitsuba 3's XML, so that Mitsuba draws the very same file.
// scene_files/scene_grammar.cpp lists what is supported. Whatever else a file holds is refused:
// nothing is skipped in silence.
#pragma once

#include <filesystem>
#include <stdexcept>

#include "scene/scene.h"
#include "scene_files/file_source.h"

namespace plumb {

// What is wrong with a scene file and where: "cornell.xml:12: <shape type="cone">: ...".
class SceneError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Throws SceneError.
Scene read_scene(const std::filesystem::path& path);

// The same of files that need not be on a disk. Scene::hash stays empty.
Scene read_scene(const std::filesystem::path& path, FileSource& source);

}  // namespace plumb
