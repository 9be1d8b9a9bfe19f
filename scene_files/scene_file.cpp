// SPDX-License-Identifier: Apache-2.0

#include "scene_files/scene_file.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <boost/algorithm/string/erase.hpp>
#include <boost/algorithm/string/replace.hpp>
#include <boost/algorithm/string/trim.hpp>
#include <string_view>

#include "scene_files/scene_reader.h"

namespace plumb {
namespace {

namespace fs = std::filesystem;
using pugi::xml_node;

// Attributes of our own: where an element stands, "box.xml:12", and whether it is a copy.
constexpr const char* place = ":place";
constexpr const char* copied = ":copied";
// What was refused in an element.
constexpr const char* refused = ":refused";
// Text stands in an element of its own, so that its place is known, too.
constexpr const char* text_tag = ":text";

std::string_view tag(const xml_node& node) { return node.name(); }

std::string describe(const xml_node& node) {
  if (node.type() != pugi::node_element) return "";
  if (tag(node) == text_tag) return fmt::format("'{}': ", node.attribute("value").value());
  std::string text = fmt::format("<{}", node.name());
  constexpr size_t longest = 60;
  for (const auto& a : node.attributes()) {
    std::string value = a.value();
    if (value.size() > longest) value = value.substr(0, longest - 3) + "...";
    if (a.name()[0] != ':') text += fmt::format(" {}=\"{}\"", a.name(), value);
  }
  std::ranges::replace(text, '\n', ' ');
  return text + ">: ";
}

// UTF-16, told by its first bytes, as UTF-8.
std::string to_utf8(const std::string& bytes) {
  const bool is_little = bytes.starts_with("\xff\xfe") || bytes.starts_with(std::string("<\0", 2));
  const bool is_big = bytes.starts_with("\xfe\xff") || bytes.starts_with(std::string("\0<", 2));
  if (!is_little && !is_big) return bytes;
  std::wstring wide;
  for (size_t i = 0; i + 1 < bytes.size(); i += 2) {
    const auto first = static_cast<unsigned char>(bytes[i]);
    const auto second = static_cast<unsigned char>(bytes[i + 1]);
    wide += static_cast<wchar_t>(is_little ? second << 8 | first : first << 8 | second);
  }
  return pugi::as_utf8(wide);
}

// Blanks, and characters that are not seen at all.
bool is_invisible(std::string text) {
  for (const char* hidden : {"\xef\xbb\xbf", "\xe2\x80\x8b", "\xe2\x80\x8c", "\xe2\x80\x8d"}) {
    boost::erase_all(text, hidden);
  }
  return boost::trim_copy(text).empty();
}

// As Mitsuba 3 does for scenes of before 2.0: nearClip is near_clip.
std::string to_snake_case(const std::string& name) {
  std::string snake;
  for (size_t i = 0; i < name.size(); ++i) {
    const bool is_upper = std::isupper(static_cast<unsigned char>(name[i])) != 0;
    if (is_upper && i > 0 && std::islower(static_cast<unsigned char>(name[i - 1]))) snake += '_';
    snake += is_upper ? static_cast<char>(std::tolower(name[i])) : name[i];
  }
  return snake;
}

// How many nodes an element holds, itself included, as far as that is less.
int size_up_to(const xml_node& element, int most) {
  int size = 0;
  const xml_node end = next_sibling_node(element);
  for (xml_node node = element; node != end && size < most; node = next_node(node)) ++size;
  return size;
}
constexpr int most_copied_nodes = 1000000;

void upgrade(xml_node node) {
  if (tag(node) == "lookAt") node.set_name("lookat");
  auto name = node.attribute("name");
  if (!name || tag(node) == "default") return;
  name.set_value(to_snake_case(name.value()).c_str());
  if (name.value() == std::string_view("diffuse_reflectance")) name.set_value("reflectance");
}

// Says of every element in `text` where it stands in the file, and puts texts into elements.
void mark_places(const std::string& file, const std::string& text, const xml_node& root) {
  const xml_node first =
      root.find_child([](const xml_node& n) { return !!n.attribute("version"); });
  const std::string version = first.attribute("version").value();
  const bool is_old = version.starts_with("0.") || version.starts_with("1.");
  int line = 1;
  std::ptrdiff_t offset = 0;
  for (xml_node node = root.first_child(); node;) {
    const auto start = node.offset_debug();
    line += static_cast<int>(std::count(text.begin() + offset, text.begin() + start, '\n'));
    offset = start;
    const xml_node following = next_node(node);
    xml_node element = node;
    if (node.type() != pugi::node_element) {
      element = node.parent().insert_child_before(text_tag, node);
      element.append_attribute("value") = node.value();
      node.parent().remove_child(node);
    }
    element.append_attribute(place) = fmt::format("{}:{}", file, line).c_str();
    if (is_old) upgrade(element);
    if (tag(element) == text_tag && is_invisible(element.attribute("value").value())) {
      element.parent().remove_child(element);
    }
    node = following;
  }
}

}  // namespace

xml_node next_node(xml_node node) {
  return node.first_child() ? node.first_child() : next_sibling_node(node);
}

xml_node next_sibling_node(xml_node node) {
  while (node && !node.next_sibling()) node = node.parent();
  return node.next_sibling();
}

std::string SceneFile::place_of(const xml_node& node) const {
  return node.attribute(place).as_string((file_.string() + ":1").c_str());
}

SceneFile::SceneFile(const fs::path& file, FileSource& source) : file_(file), source_(source) {
  if (!source.exists(file)) throw SceneError(file.string() + ": no such file");
  parse(file, document_);
  follow();
  resolve_references();
}

void SceneFile::refuse(const std::string& text) { refusals_.add(text); }

void SceneFile::refuse(const xml_node& node, const std::string& what) {
  refuse(fmt::format("{}: {}{}", place_of(node), describe(node), what));
  for (xml_node n = node; n && !is_refused(n); n = n.parent()) n.append_attribute(refused);
}

bool SceneFile::is_refused(const xml_node& node) { return node.attribute(refused); }

void SceneFile::note(const std::string& text) { notes_.add(text); }

void SceneFile::note(const xml_node& node, const std::string& what) {
  note(fmt::format("{}: {}{}", place_of(node), describe(node), what));
}

void SceneFile::note_no_effect(const std::string& what) { without_effect_.add(what); }

std::vector<std::string> SceneFile::notes() const {
  std::vector<std::string> all = notes_.texts;
  if (!without_effect_.texts.empty()) {
    all.push_back(fmt::format("{}: without effect here: {}", file_.string(),
                              fmt::join(without_effect_.texts, ", ")));
  }
  return all;
}

void SceneFile::throw_refusals() const {
  constexpr size_t most = 100;
  std::vector<std::string> told = refusals_.texts;
  if (told.empty()) return;
  if (told.size() > most) {
    told.resize(most);
    told.push_back(fmt::format("and {} more", refusals_.texts.size() - most));
  }
  throw SceneError(fmt::format("{}", fmt::join(told, "\n")));
}

fs::path SceneFile::find(const xml_node& node, const std::string& name) const {
  std::vector<fs::path> folders(folders_.begin(), folders_.end());
  const std::string at = place_of(node);
  folders.push_back(fs::path(at.substr(0, at.rfind(':'))).parent_path());
  for (const fs::path& folder : folders) {
    if (source_.exists(folder / name)) return folder / name;
  }
  return file_.parent_path() / name;
}

void SceneFile::parse(const fs::path& file, pugi::xml_document& document) {
  const std::string text = to_utf8(read_bytes(file));
  if (text.empty()) throw SceneError(file.string() + ": cannot be read or is empty");
  // As a fragment, so that text outside of <scene> is seen.
  constexpr auto options = pugi::parse_default | pugi::parse_fragment | pugi::parse_trim_pcdata;
  const auto result = document.load_buffer(text.data(), text.size(), options, pugi::encoding_utf8);
  if (!result) {
    const auto line = 1 + std::count(text.begin(), text.begin() + result.offset, '\n');
    throw SceneError(fmt::format("{}:{}: {}", file.string(), line, result.description()));
  }
  mark_places(file.string(), text, document);
}

// Parameters count from where they are given on, in included files, too.
void SceneFile::follow() {
  for (xml_node node = document_.first_child(); node;) {
    replace_parameters(node);
    const std::string value = node.attribute("value").value();
    if (tag(node) == "default") {
      const std::string name = node.attribute("name").value();
      if (name.empty()) refuse(node, "a default needs a name");
      parameters_.emplace(name, value);
    }
    if (tag(node) == "path") folders_.push_front(find(node, value));
    node = tag(node) == "include" ? include(node) : next_node(node);
  }
}

void SceneFile::replace_parameters(const xml_node& node) {
  for (pugi::xml_attribute attribute : node.attributes()) {
    std::string value = attribute.value();
    if (value.find('$') == value.npos || attribute.name()[0] == ':') continue;
    for (const auto& [name, replacement] : parameters_) {
      boost::replace_all(value, "$" + name, replacement);
    }
    if (const size_t at = value.find('$'); at != value.npos) {
      const size_t end = value.find_first_of(" ,/.$", at + 1);
      refuse(node, "no <default> before this defines " + value.substr(at, end - at));
    }
    constexpr size_t longest = 10000000;
    if (value.size() > longest) throw SceneError(file_.string() + ": a value of over 10 MB");
    attribute.set_value(value.c_str());
  }
}

// Puts the children of the included scene in the place of the element. Returns what comes next.
xml_node SceneFile::include(xml_node node) {
  constexpr int most = 100;
  const fs::path file = find(node, node.attribute("filename").value());
  if (!source_.is_file(file)) {
    refuse(node, fmt::format("{}: {}", file.string(),
                             source_.exists(file) ? "is not a file" : "no such file"));
    return next_node(node);
  }
  if (++includes_ > most) throw SceneError(file_.string() + ": includes more than 100 files");
  pugi::xml_document included;
  parse(file, included);
  const xml_node scene = included.child("scene");
  xml_node following;
  for (const xml_node& child : (scene ? scene : included).children()) {
    const xml_node copy = node.parent().insert_copy_before(child, node);
    if (!following) following = copy;
  }
  if (!following) following = next_node(node);
  node.parent().remove_child(node);
  return following;
}

void SceneFile::resolve_references() {
  std::map<std::string, xml_node> targets;
  for (xml_node node = document_.first_child(); node; node = next_node(node)) {
    const auto id = node.attribute("id");
    if (!id || tag(node) == "ref") continue;
    if (!targets.emplace(id.value(), node).second) refuse(node, "the id is taken");
  }
  int copied_nodes = 0;
  for (xml_node node = document_.first_child(); node;) {
    const std::string id = node.attribute("id").value();
    const auto target = targets.find(id);
    if (tag(node) != "ref" || id.empty()) {
      node = next_node(node);
      continue;
    }
    const auto is_target = [&](const xml_node& n) {
      return n == target->second || (n.attribute(copied) && n.attribute("id").value() == id);
    };
    xml_node above = target == targets.end() ? xml_node() : node.parent();
    while (above && !is_target(above)) above = above.parent();
    if (target == targets.end() || above) {
      refuse(node, above ? "refers to what it stands in" : "nothing has this id");
      node = next_node(node);
      continue;
    }
    copied_nodes += size_up_to(target->second, most_copied_nodes);
    if (copied_nodes >= most_copied_nodes) {
      throw SceneError(file_.string() + ": its references lead to a million elements");
    }
    xml_node copy = node.parent().insert_copy_before(target->second, node);
    copy.append_attribute(copied);
    node.parent().remove_child(node);
    node = copy;
  }
}

}  // namespace plumb
