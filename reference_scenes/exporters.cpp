#include "reference_scenes/exporters.h"

#include <fmt/format.h>

#include <cctype>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>

#include "images/output_file.h"
#include "includes.h"

namespace plumb {
namespace {

namespace fs = std::filesystem;

// A file that says the same already may be a link to the one that several scenes share.
void write_text(const fs::path& file, std::string_view text) {
  std::ifstream old(file, std::ios::binary);
  if (old && std::string(std::istreambuf_iterator<char>(old), {}) == text) return;
  if (fs::is_symlink(file)) {
    throw std::runtime_error(fmt::format("{}: links to a file that is another", file.string()));
  }
  write_file(file, text);
}

fs::path write_both(const fs::path& file, std::string_view scene, const char* include_name,
                    std::string_view include_text) {
  fs::path include = fs::path(file).replace_filename(include_name);
  if (include == file) {
    throw std::runtime_error(fmt::format("{}: is the name of its include", file.string()));
  }
  write_text(file, scene);
  write_text(include, include_text);
  return include;
}

std::string filter_name(const Camera& camera) {
  constexpr const char* names[] = {"box", "tent", "gaussian"};  // as in Filter::Kind
  return fmt::format("{} {}", names[size_t(camera.filter.kind)], camera.filter.size);
}

}  // namespace

fs::path export_to_povray(const Scene& scene, const fs::path& file) {
  return write_both(file, povray_scene(scene), "plumbline.inc", povray_include);
}

fs::path export_to_cycles(const Scene& scene, const fs::path& file) {
  return write_both(file, cycles_scene(scene), "plumbline_cycles.py", cycles_include);
}

double cycles_filter_width(const Filter& filter) {
  constexpr double widest = 10.0;
  const double width = 4.0 * filter.size;
  return filter.kind == Filter::Kind::gaussian && width <= widest ? width : 0.0;
}

std::string povray_filter_note(const Camera& camera) {
  if (camera.filter.kind == Filter::Kind::box && camera.filter.size == 0.5) return "";
  return fmt::format("POV-Ray draws a box filter, the scene asks for {}", filter_name(camera));
}

std::string cycles_filter_note(const Camera& camera) {
  const Filter& filter = camera.filter;
  if (filter.kind == Filter::Kind::box && filter.size == 0.5) return "";
  if (cycles_filter_width(filter) == 0.0) {
    return fmt::format("Cycles draws a box filter, the scene asks for {}", filter_name(camera));
  }
  if (filter.crosses_border) return "";
  return "Cycles counts what lies beside the picture for its outermost pixels, the scene doesn't";
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
