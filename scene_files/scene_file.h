// SPDX-License-Identifier: Apache-2.0

// A scene file as one tree: included files stand where they were included, `$names` are replaced by
// their values and references by copies of what they refer to. What is wrong with it is collected,
// so that all of it can be told at once.
#pragma once

#include <deque>
#include <filesystem>
#include <map>
#include <pugixml.hpp>
#include <set>
#include <string>
#include <vector>

#include "scene_files/file_source.h"

namespace plumb {

// The next element or text in the order of the file; null after the last one. A loop over it copes
// with files that nest deeper than the stack.
pugi::xml_node next_node(pugi::xml_node node);
pugi::xml_node next_sibling_node(pugi::xml_node node);  // not in the element itself

// Texts in the order in which they came, each once.
struct Lines {
  std::vector<std::string> texts;
  std::set<std::string> known;

  void add(const std::string& text) {
    if (known.insert(text).second) texts.push_back(text);
  }
};

class SceneFile {
 public:
  // Reads XML in UTF-8 or UTF-16. Throws SceneError if that is not possible. `source` must outlive
  // this.
  SceneFile(const std::filesystem::path& file, FileSource& source);

  const pugi::xml_document& document() const { return document_; }

  // Says what can't stay as it is, or what is taken in a way that its author should know. `what`
  // follows the place and the element: "box.xml:12: <float name="fov" value="a">: ...".
  void refuse(const pugi::xml_node& node, const std::string& what);
  void note(const pugi::xml_node& node, const std::string& what);

  // Notes that something has no effect, in one line with all else that has none.
  void note_no_effect(const std::string& what);

  // Says what is wrong with, or to be known of, another file, place included.
  void refuse(const std::string& text);
  void note(const std::string& text);

  static bool is_refused(const pugi::xml_node& node);  // the element or anything in it
  std::vector<std::string> notes() const;

  // Throws SceneError with all refusals, a line each, if there are any.
  void throw_refusals() const;

  // A file that an element names is looked for in the folders of <path>, then beside the file that
  // the element stands in, then beside the scene file.
  std::filesystem::path find(const pugi::xml_node& node, const std::string& name) const;

  // The bytes of a file; none if it can't be read.
  std::string read_bytes(const std::filesystem::path& file) { return source_.read(file); }

 private:
  std::string place_of(const pugi::xml_node& node) const;  // "box.xml:12"
  void parse(const std::filesystem::path& file, pugi::xml_document& document);
  void follow();
  void replace_parameters(const pugi::xml_node& node);
  pugi::xml_node include(pugi::xml_node node);
  void resolve_references();

  std::filesystem::path file_;
  FileSource& source_;
  pugi::xml_document document_;
  std::deque<std::filesystem::path> folders_;
  std::map<std::string, std::string, std::greater<>> parameters_;  // $ab before $a
  Lines refusals_, notes_, without_effect_;
  int includes_ = 0;
};

}  // namespace plumb
