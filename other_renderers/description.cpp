// SPDX-License-Identifier: Apache-2.0

#include "other_renderers/description.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <map>
#include <memory>
#include <ranges>
#include <regex>
#include <set>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <utility>

#include "other_renderers/export.h"
#include "other_renderers/plain_scene.h"

namespace plumb {
namespace {

namespace fs = std::filesystem;

const std::regex placeholder(R"(\{(\w+)\})");

// What a program may not know, by the words of docs/renderers.md.
bool is_sphere(const Shape& s) { return std::holds_alternative<Sphere>(s.geometry); }
bool is_plain_mirror(const Shape& s) { return s.bsdf.is_mirror() && !s.bsdf.is_metal(); }
bool is_metal(const Shape& s) { return s.bsdf.is_metal(); }
bool is_rough(const Shape& s) { return s.bsdf.alpha > 0.0; }
bool is_two_sided(const Shape& s) { return s.bsdf.two_sided && !is_glass(s); }

template <bool (*Is)(const Shape&)>
bool any_shape(const Scene& scene) {
  return std::ranges::any_of(scene.shapes, Is);
}

const std::map<std::string, bool (*)(const Scene&), std::less<>> abilities{
    {"spheres", any_shape<is_sphere>},
    {"mirrors", any_shape<is_plain_mirror>},
    {"metals", any_shape<is_metal>},
    {"rough_metals", any_shape<is_rough>},
    {"glass", any_shape<is_glass>},
    {"two_sided", any_shape<is_two_sided>},
    {"points", [](const Scene& scene) { return !scene.points.empty(); }},
    {"sky", [](const Scene& scene) { return scene.has_sky(); }}};

const std::map<std::string, Decoding::Transfer, std::less<>> transfers{
    {"linear", Decoding::Transfer::linear},
    {"srgb", Decoding::Transfer::srgb},
    {"gamma2.2", Decoding::Transfer::gamma}};

template <typename Map>
std::string words_of(const Map& map) {
  std::string words;
  for (const auto& entry : map) words += (words.empty() ? "" : ", ") + entry.first;
  return words;
}

[[noreturn]] void refuse(const toml::node& node, const std::string& why) {
  const toml::source_region& place = node.source();
  const std::string file = place.path ? *place.path : "description";
  throw std::invalid_argument(
      fmt::format("{}:{}:{}: {}", file, place.begin.line, place.begin.column, why));
}

// Takes the keys of a table one by one; what is left in the end is unknown.
class Table {
 public:
  explicit Table(const toml::table& table) : table_(table) {}

  const toml::node* find(const std::string& key) {
    known_.insert(key);
    return table_.get(key);
  }

  const toml::node& need(const std::string& key) {
    const toml::node* node = find(key);
    if (node == nullptr) refuse(table_, fmt::format("there is no '{}'", key));
    return *node;
  }

  template <typename Value>
  Value value(const std::string& key, const Value& otherwise, const char* what) {
    const toml::node* node = find(key);
    if (node == nullptr) return otherwise;
    const auto found = node->value<Value>();
    if (!found) refuse(*node, fmt::format("'{}' must be {}", key, what));
    return *found;
  }

  template <typename Map>
  typename Map::mapped_type one_of(const std::string& key, const Map& map,
                                   const std::string& otherwise) {
    const std::string word = value(key, otherwise, "a text");
    const auto found = map.find(word);
    if (found == map.end()) {
      refuse(need(key), fmt::format("'{}' must be one of {}", key, words_of(map)));
    }
    return found->second;
  }

  std::vector<std::string> words(const std::string& key) {
    const toml::node* node = find(key);
    std::vector<std::string> words;
    if (node == nullptr) return words;
    const toml::array* list = node->as_array();
    if (list == nullptr) refuse(*node, fmt::format("'{}' must be a list of texts", key));
    for (const toml::node& item : *list) {
      const auto word = item.value<std::string>();
      if (!word || !item.is_string()) refuse(item, fmt::format("'{}' must hold texts", key));
      words.push_back(*word);
    }
    return words;
  }

  void refuse_others() const {
    for (const auto& [key, node] : table_) {
      if (!known_.contains(std::string(key.str()))) {
        refuse(node, fmt::format("'{}' is no key of a description", key.str()));
      }
    }
  }

 private:
  const toml::table& table_;
  std::set<std::string> known_;
};

bool has(const Command& command, const std::string& name) {
  return std::ranges::any_of(command, [&](const std::string& argument) {
    return argument.find("{" + name + "}") != std::string::npos;
  });
}

std::string replace(std::string text, const std::map<std::string, std::string>& values) {
  for (const auto& [name, value] : values) {
    const std::string mark = "{" + name + "}";
    for (size_t at = 0; (at = text.find(mark, at)) != std::string::npos; at += value.size()) {
      text.replace(at, mark.size(), value);
    }
  }
  return text;
}

// A command of the file, whose program may be named as seen from the file.
Command command_of(Table& table, const std::string& key, const fs::path& folder) {
  Command command = table.words(key);
  if (table.find(key) != nullptr && command.empty()) {
    refuse(table.need(key), fmt::format("'{}' names no program", key));
  }
  for (std::string& argument : command) argument = replace(argument, {{"here", folder.string()}});
  if (!command.empty() && command[0].find('/') != std::string::npos) {
    command[0] = (folder / command[0]).lexically_normal().string();
  }
  return command;
}

void check_placeholders(const toml::node& node, const Command& command) {
  static const std::set<std::string> known{"scene", "output", "spp",    "seed",   "bounces",
                                           "depth", "width",  "height", "threads"};
  for (const std::string& argument : command) {
    for (std::sregex_iterator match(argument.begin(), argument.end(), placeholder), end;
         match != end; ++match) {
      if (!known.contains((*match)[1])) {
        refuse(node, fmt::format("'{}' is no placeholder", match->str()));
      }
    }
  }
  for (const char* name : {"scene", "output"}) {
    if (!has(command, name)) refuse(node, fmt::format("'command' lacks '{{{}}}'", name));
  }
}

Command fill(const Command& command, const Job& job, const std::string& picture,
             const std::string& all_bounces) {
  const Camera& camera = job.scene.camera;
  const int threads = job.settings.threads;
  const std::map<std::string, std::string> values{
      {"scene", job.file.string()},
      {"output", picture},
      {"spp", std::to_string(job.settings.samples_per_pixel)},
      {"seed", std::to_string(job.seed)},
      {"bounces", job.most_bounces ? std::to_string(*job.most_bounces) : all_bounces},
      {"depth", job.most_bounces ? std::to_string(*job.most_bounces + 1) : all_bounces},
      {"width", std::to_string(camera.width)},
      {"height", std::to_string(camera.height)},
      {"threads",
       std::to_string(threads > 0 ? threads : int(std::thread::hardware_concurrency()))}};
  Command filled;
  for (const std::string& argument : command) filled.push_back(replace(argument, values));
  return filled;
}

void take_scene(Table& table, OtherRenderer& renderer) {
  const std::string format = table.value<std::string>("scene", "mitsuba", "a text");
  if (format == "mitsuba") return;
  if (format == "json") {
    renderer.format = SceneFormat{".json", plain_scene};
    return;
  }
  for (const OtherRenderer& other : other_renderers()) {
    if (other.word != format || !other.format) continue;
    renderer.format = other.format;
    renderer.script_name = other.script_name;
    renderer.script = other.script;
    renderer.drawn_otherwise = other.drawn_otherwise;
    return;
  }
  refuse(table.need("scene"), "'scene' must be mitsuba, json, povray or cycles");
}

void take_obstacles(Table& table, OtherRenderer& renderer) {
  const std::vector<std::string> words = table.words("cannot");
  for (const std::string& word : words) {
    if (!abilities.contains(word)) {
      refuse(table.need("cannot"), fmt::format("'{}' is none of {}", word, words_of(abilities)));
    }
  }
  renderer.obstacle = [words](const Scene& scene) -> std::string {
    for (const std::string& word : words) {
      if (abilities.at(word)(scene))
        return "knows no " + std::regex_replace(word, std::regex("_"), " ");
    }
    return "";
  };
}

void take_picture(Table& table, OtherRenderer& renderer) {
  renderer.picture = "picture." + table.value<std::string>("output", "exr", "a file's extension");
  const toml::node* node = table.find("picture");
  if (node == nullptr) return;
  if (!node->is_table()) refuse(*node, "'picture' must be a table");
  Table picture(*node->as_table());
  Decoding& decoding = renderer.decoding;
  decoding.transfer = picture.one_of("colour_space", transfers, "linear");
  decoding.scale = picture.value("scale", 1.0, "a number");
  decoding.flipped = picture.value("flipped", false, "true or false");
  decoding.mirrored = picture.value("mirrored", false, "true or false");
  picture.refuse_others();
}

OtherRenderer describe(Table table, const fs::path& file) {
  const fs::path folder = fs::absolute(file).parent_path();
  OtherRenderer renderer;
  renderer.word = file.stem().string();
  renderer.name = renderer.software = table.value("name", renderer.word, "a text");
  const Command command = command_of(table, "command", folder);
  check_placeholders(table.need("command"), command);
  const Command version = command_of(table, "version", folder);
  renderer.probe = version.empty() ? Command{"true"} : version;
  renderer.how_to_install =
      fmt::format("{} is not there, which {} starts", command[0], file.string());
  renderer.has_samples = has(command, "spp");
  renderer.has_seeds = has(command, "seed");
  renderer.counts_bounces = has(command, "bounces") || has(command, "depth");
  renderer.takes_threads = has(command, "threads");
  renderer.promises_same_bits = table.value("same_bits", false, "true or false");
  renderer.is_single_precision = table.value("single_precision", false, "true or false");
  renderer.time_limit = table.value("time_limit", 600.0, "a number of seconds");
  renderer.must_report = false;
  const auto all_bounces = table.value<std::string>("all_bounces", "1000", "a text");
  take_scene(table, renderer);
  take_obstacles(table, renderer);
  take_picture(table, renderer);
  table.refuse_others();
  renderer.runs = [=, picture = renderer.picture](const Job& job) -> std::vector<Run> {
    return {{fill(command, job, picture, all_bounces)}};
  };
  return renderer;
}

}  // namespace

OtherRenderer read_description(const fs::path& file) {
  if (!fs::exists(file)) {
    throw std::runtime_error(file.string() + ": there is no such description of a renderer");
  }
  try {
    const toml::table table = toml::parse_file(file.string());
    return describe(Table(table), file);
  } catch (const toml::parse_error& error) {
    std::ostringstream place;
    place << error.source().begin;
    throw std::invalid_argument(
        fmt::format("{}, {}: {}", file.string(), place.str(), std::string(error.description())));
  }
}

}  // namespace plumb
