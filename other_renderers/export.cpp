#include "other_renderers/export.h"

#include <fmt/format.h>

#include <cctype>
#include <stdexcept>
#include <string>

#include "images/output_file.h"

namespace plumb {

namespace fs = std::filesystem;

fs::path export_scene(const OtherRenderer& renderer, const Scene& scene, const fs::path& file) {
  fs::path script = fs::path(file).replace_filename(renderer.script_name);
  if (script == file) {
    throw std::runtime_error(fmt::format("{}: is the name of its include", file.string()));
  }
  write_file(file, renderer.format->text(scene));
  write_file(script, renderer.script);
  return script;
}

std::string box_filter_note(const std::string& renderer, const Filter& filter) {
  constexpr const char* names[] = {"box", "tent", "gaussian"};  // as in Filter::Kind
  if (filter.kind == Filter::Kind::box && filter.size == 0.5) return "";
  return fmt::format("{} draws a box filter, the scene asks for {} {}", renderer,
                     names[size_t(filter.kind)], filter.size);
}

std::string comment(const std::string& mark, const std::string& note) {
  return note.empty() ? "" : fmt::format("{}{}\n", mark, note);
}

std::string plain_identifier(const std::string& id) {
  std::string plain = id;
  for (char& c : plain) {
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  }
  return plain;
}

}  // namespace plumb
