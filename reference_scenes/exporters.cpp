#include "reference_scenes/exporters.h"

#include <fmt/format.h>

#include <cctype>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>

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
  std::ofstream stream(file, std::ios::binary);
  if (!(stream << text << std::flush)) {
    throw std::runtime_error(fmt::format("{}: can't be written", file.string()));
  }
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

}  // namespace

fs::path export_to_povray(const Scene& scene, const fs::path& file) {
  return write_both(file, povray_scene(scene), "plumbline.inc", povray_include);
}

fs::path export_to_cycles(const Scene& scene, const fs::path& file) {
  return write_both(file, cycles_scene(scene), "plumbline_cycles.py", cycles_include);
}

std::string plain_identifier(const std::string& id) {
  std::string plain = id;
  for (char& c : plain) {
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  }
  return plain;
}

}  // namespace plumb
