#include "renderer/scene_grammar.h"

#include <OpenImageIO/strutil.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>
#include <vector>

namespace plumb {
namespace {

// What an element holds, for each type where there are types: attributes with an @, parameters such
// as <float name="fov" value="40"/> as `float fov`, other elements by their tags. `!` means one,
// `*` any number, neither at most one; `|` separates alternatives and, after `=`, values.
const std::map<std::string, std::string> grammar = {
    {"", "scene!"},
    {"scene", "@version=3.0.0!, sensor!, shape*, bsdf*, default*"},
    {"sensor perspective",
     "float fov!, string fov_axis=x|y|diagonal|smaller|larger, transform to_world, film!"},
    // Without a filter Mitsuba takes a Gaussian.
    {"film hdrfilm",
     "integer width, integer height, string pixel_format=rgb, string component_format=float32, "
     "rfilter!"},
    {"rfilter box", ""},
    {"shape rectangle", "transform to_world, bsdf|ref, emitter"},
    {"shape cube", "transform to_world, bsdf|ref, emitter"},
    {"shape sphere", "point center, float radius, transform to_world, bsdf|ref, emitter"},
    // Without face normals Mitsuba makes some up for the vertices and shades smoothly.
    {"shape obj",
     "string filename!, boolean face_normals=true!, transform to_world, bsdf|ref, emitter"},
    {"bsdf diffuse", "rgb reflectance"},
    {"bsdf conductor", "string material=none!, rgb specular_reflectance"},
    {"bsdf twosided", "bsdf|ref!"},
    {"emitter area", "rgb radiance!"},
    {"ref", "@id!"},
    {"transform", "@name!, translate*, rotate*, scale*, matrix*, lookat*"},
    {"translate", "@x, @y, @z, @value"},
    {"scale", "@x, @y, @z, @value"},
    {"rotate", "@x, @y, @z, @value, @angle!"},
    {"matrix", "@value!"},
    {"lookat", "@origin!, @target!, @up!"},
    {"point", "@name!, @x, @y, @z, @value"}};
const std::string parameter_or_default = "@name!, @value!";

// In the order of the file. A loop, because files may nest deeper than the stack.
pugi::xml_node next(pugi::xml_node node) {
  if (node.first_child()) return node.first_child();
  while (node && !node.next_sibling()) node = node.parent();
  return node.next_sibling();
}

// An attribute or a child as the grammar labels it.
struct Item {
  std::string label;
  std::string value;
  pugi::xml_node node;
};

std::vector<Item> list_items(const pugi::xml_node& node) {
  std::vector<Item> items;
  for (const auto& a : node.attributes()) {
    items.push_back({fmt::format("@{}", a.name()), a.value(), node});
  }
  for (const auto& child : node.children()) {
    const std::string tag = child.type() == pugi::node_element ? child.name() : "text";
    const std::string name = tag == "default" ? "" : child.attribute("name").value();
    items.push_back(
        {name.empty() ? tag : tag + " " + name, child.attribute("value").value(), child});
  }
  return items;
}

std::string find_rule(const pugi::xml_node& node) {
  const std::string tag = node.name();
  if (const auto rule = grammar.find(tag); rule != grammar.end()) return rule->second;
  std::vector<std::string> types;
  for (const auto& [key, rule] : grammar) {
    if (!key.starts_with(tag + " ")) continue;
    types.push_back(key.substr(tag.size() + 1));
    if (types.back() == node.attribute("type").value()) {
      return "@type!, @id" + (rule.empty() ? "" : ", " + rule);
    }
  }
  if (types.empty()) return parameter_or_default;
  throw Refusal{node, fmt::format("unknown type; supported: {}", fmt::join(types, ", "))};
}

void check_items(const pugi::xml_node& node) {
  std::vector<Item> items = list_items(node);
  std::vector<std::string> labels;
  for (const std::string& slot : OIIO::Strutil::splits(find_rule(node), ", ")) {
    const auto parts = OIIO::Strutil::splits(OIIO::Strutil::strip(slot, "!*"), "=");
    const std::string& label = labels.emplace_back(parts[0]);
    const auto alternatives = OIIO::Strutil::splits(label, "|");
    const auto found = std::stable_partition(items.begin(), items.end(), [&](const Item& item) {
      return std::ranges::count(alternatives, item.label) == 0;
    });
    const auto count = items.end() - found;
    if (count == 0 && slot.ends_with('!')) throw Refusal{node, label + " is missing"};
    if (count > 1 && !slot.ends_with('*')) throw Refusal{found[1].node, label + " is given twice"};
    if (count > 0 && parts.size() > 1) {
      const auto values = OIIO::Strutil::splits(parts[1], "|");
      if (std::ranges::count(values, found->value) == 0) {
        throw Refusal{found->node, fmt::format("supported: {}", fmt::join(values, ", "))};
      }
    }
    items.erase(found, items.end());
  }
  if (items.empty()) return;
  throw Refusal{items[0].node, fmt::format("{} is not supported here; supported: {}",
                                           items[0].label, fmt::join(labels, ", "))};
}

void replace_defaults(const pugi::xml_document& document) {
  std::map<std::string, std::string, std::greater<>> defaults;  // $ab before $a
  for (pugi::xml_node node = document.first_child(); node; node = next(node)) {
    for (pugi::xml_attribute attribute : node.attributes()) {
      std::string value = attribute.value();
      for (const auto& [name, replacement] : defaults) {
        value = OIIO::Strutil::replace(value, "$" + name, replacement, true);
      }
      if (value.find('$') != value.npos) throw Refusal{node, "no <default> before this defines $"};
      attribute.set_value(value.c_str());
    }
    if (node.name() != std::string_view("default")) continue;
    const std::string name = node.attribute("name").value();
    if (name.empty() || !defaults.emplace(name, node.attribute("value").value()).second) {
      throw Refusal{node, "a default needs a name that no other has"};
    }
  }
}

}  // namespace

void check_grammar(const pugi::xml_document& document) {
  replace_defaults(document);
  check_items(document);
  std::set<std::string> ids;
  for (pugi::xml_node node = document.first_child(); node; node = next(node)) {
    check_items(node);
    const bool has_id = node.attribute("id") && node.name() != std::string_view("ref");
    if (has_id && !ids.insert(node.attribute("id").value()).second) {
      throw Refusal{node, "the id is taken"};
    }
  }
}

}  // namespace plumb
