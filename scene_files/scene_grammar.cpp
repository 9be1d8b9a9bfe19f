// SPDX-License-Identifier: Apache-2.0

#include "scene_files/scene_grammar.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <boost/algorithm/string/classification.hpp>
#include <boost/algorithm/string/finder.hpp>
#include <boost/algorithm/string/split.hpp>
#include <boost/algorithm/string/trim.hpp>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "scene/scene.h"

namespace plumb {
namespace {

std::vector<std::string> split(const std::string& text, const char* separator) {
  std::vector<std::string> parts;
  boost::iter_split(parts, text, boost::first_finder(separator));
  return parts;
}

std::string strip(const std::string& text, const char* characters) {
  return boost::trim_copy_if(text, boost::is_any_of(characters));
}

// What an element holds, for each type where there are types: attributes with an @, parameters such
// as <float name="fov" value="40"/> as `float fov`, other elements by their tags. A `color` is an
// rgb, a spectrum or a number; a `float` may be written as an integer. `!` means one, `*` any
// number, neither at most one. `|` separates alternatives and, after `=`, values. `~` has no
// effect, which is noted but for these values.
const std::string integrator =
    "integer rr_depth~, boolean hide_emitters=false, boolean strict_normals~";
const std::string film =
    "integer width, integer height, rfilter, boolean sample_border, boolean high_quality_edges, "
    "string pixel_format=rgb~, string component_format=float32~, string file_format=openexr~, "
    "boolean banner~, "
    "boolean attach_log~, float gamma~, float exposure~, "
    "integer crop_offset_x, integer crop_offset_y, integer crop_width, integer crop_height";
const std::string shape =
    "transform to_world, boolean flip_normals, bsdf, emitter, float silhouette_sampling_weight~";
const std::string mesh =
    "string filename!, boolean face_normals, boolean flip_tex_coords~, boolean collapse~, " + shape;
const std::string metal =
    "string material, color eta, color k, color specular_reflectance, boolean two_sided";
const std::string fov_axes = fmt::format("{}", fmt::join(Camera::fov_axis_names, "|"));

const std::map<std::string, std::string> grammar = {
    {"", "scene!"},
    {"scene", "@version!, integrator, sensor!, shape*, bsdf*, emitter*, default*, path*"},
    {"default", "@name!, @value!"},
    {"path", "@value!"},
    {"integrator path", "integer max_depth, " + integrator},
    {"integrator volpath", "integer max_depth, " + integrator},
    {"integrator volpathmis", "integer max_depth, " + integrator},
    {"integrator direct",
     "integer emitter_samples~, integer bsdf_samples~, integer shading_samples~, " + integrator},
    {"sensor perspective",
     "float fov, string fov_axis=" + fov_axes +
         ", string focal_length, "
         "float focus_distance~, float near_clip, float far_clip, float shutter_open~, "
         "float shutter_close~, float principal_point_offset_x, "
         "float principal_point_offset_y, transform to_world, film, sampler"},
    {"film hdrfilm", film},
    {"film ldrfilm", film + ", string tonemap_method~"},
    {"rfilter box", ""},
    {"rfilter tent", "float radius"},
    {"rfilter gaussian", "float stddev"},
    {"shape rectangle", shape},
    {"shape cube", shape},
    {"shape sphere", "point center, float radius, " + shape},
    {"shape obj", mesh},
    {"shape ply", mesh},
    {"bsdf diffuse", "color reflectance, boolean two_sided"},
    {"bsdf conductor", metal},
    {"bsdf roughconductor",
     "string distribution=ggx, float alpha, float alpha_u, float alpha_v, "
     "boolean sample_visible~, " +
         metal},
    {"bsdf dielectric",
     "float int_ior|string int_ior, float ext_ior|string ext_ior, color specular_reflectance, "
     "color specular_transmittance"},
    {"bsdf twosided", "bsdf!"},
    {"bsdf two_sided", "bsdf!"},
    {"emitter area", "color radiance, float sampling_weight~"},
    {"emitter constant", "color radiance, float sampling_weight~"},
    {"emitter point",
     "color intensity, point position, transform to_world, float sampling_weight~"},
    {"spectrum d65", "float scale, color color"},
    {"spectrum blackbody", "float temperature!, float scale"},
    {"spectrum uniform", "float value!"},
    {"spectrum", "@name!, @value|@filename!"},
    {"transform", "@name!, translate*, rotate*, scale*, matrix*, lookat*"},
    {"translate", "@x, @y, @z, @value"},
    {"scale", "@x, @y, @z, @value"},
    {"rotate", "@x, @y, @z, @value, @angle!"},
    {"matrix", "@value!"},
    {"lookat", "@origin!, @target!, @up!"},
    {"point", "@name!, @x, @y, @z, @value"}};
constexpr std::array parameters{"float", "integer", "boolean", "string", "rgb"};

// What to write instead, by how a message begins.
const std::vector<std::pair<std::string, std::string>> advice = {
    {"integrator ", R"(delete it, or write <integrator type="path">)"},
    {"rfilter ",
     R"(filters with negative weights can't be sampled: write <rfilter type="gaussian"/>)"},
    {"sensor ", R"(write type="perspective": cameras are pinholes)"},
    {"texture", R"(write <rgb name="reflectance" value="..."/>)"},
    {"boolean hide_emitters", "delete it: lamps are seen"},
    {"@version", R"(write <scene version="3.0.0">)"},
    {"sensor is missing", R"(a scene needs a <sensor type="perspective">)"},
    {"string tonemap", "delete it: pictures are linear"}};

std::string with_advice(const std::string& subject, const std::string& message) {
  for (const auto& [begin, text] : advice) {
    if (subject.starts_with(begin)) return message + "; " + text;
  }
  return message;
}

// An attribute or a child as the grammar labels it.
struct Item {
  std::string label;
  std::string value;
  pugi::xml_node node;
};

// Whether elements of this tag are objects of some type, whose own name says nothing.
bool is_object(const std::string& tag) {
  constexpr std::array others{"texture", "sampler", "medium", "ref"};
  return std::ranges::count(others, tag) > 0 || std::ranges::any_of(grammar, [&](const auto& rule) {
           return rule.first.starts_with(tag + " ") && tag != "spectrum";
         });
}

std::vector<Item> list_items(const pugi::xml_node& node) {
  std::vector<Item> items;
  for (const auto& a : node.attributes()) {
    if (a.name()[0] != ':') items.push_back({fmt::format("@{}", a.name()), a.value(), node});
  }
  for (const auto& child : node.children()) {
    const std::string tag = strip(child.name(), ":");
    const std::string name = child.attribute("name").value();
    const bool is_named = !name.empty() && tag != "default" && !is_object(tag);
    items.push_back({is_named ? tag + " " + name : tag, child.attribute("value").value(), child});
  }
  return items;
}

bool matches(const Item& item, const std::string& label) {
  const auto parts = split(label, " ");
  if (parts.size() < 2) return item.label == label;
  const std::string tag = item.label.substr(0, item.label.find(' '));
  if (!item.label.ends_with(" " + parts[1])) return false;
  if (parts[0] == "float") return tag == "float" || tag == "integer";
  if (parts[0] != "color") return tag == parts[0];
  return tag == "rgb" || tag == "spectrum" || tag == "float" || tag == "integer";
}

// The rule for an element; none if there is no such element or type.
const std::string* find_rule(SceneFile& file, const pugi::xml_node& node) {
  static const std::string parameter = "@name!, @value!";
  const std::string tag = node.name();
  const bool has_type = node.attribute("type");
  const std::string key = has_type ? tag + " " + node.attribute("type").value() : tag;
  if (const auto rule = grammar.find(key); rule != grammar.end()) return &rule->second;
  std::vector<std::string> types;
  for (const auto& [known, rule] : grammar) {
    if (known.starts_with(tag + " ")) types.push_back(known.substr(tag.size() + 1));
  }
  if (!types.empty()) {
    const std::string what = has_type ? "unknown type" : "the attribute type is missing";
    file.refuse(node, with_advice(tag + " ",
                                  fmt::format("{}; supported: {}", what, fmt::join(types, ", "))));
  } else if (std::ranges::count(parameters, tag) > 0) {
    return &parameter;
  }
  return nullptr;
}

// How a label is told: the attribute version, <sensor>, fov.
std::string spoken(const std::string& label) {
  if (label.starts_with('@')) return "the attribute " + split(label, "|@")[0].substr(1);
  return label.substr(label.find(' ') + 1);
}

void check_slot(SceneFile& file, const std::string& slot, std::vector<Item>& items,
                std::vector<std::string>& missing) {
  const auto parts = split(strip(slot, "!*~"), "=");
  const auto labels = split(parts[0], "|");
  const auto found = std::ranges::stable_partition(items, [&](const Item& item) {
    return std::ranges::none_of(labels, [&](const auto& label) { return matches(item, label); });
  });
  const auto count = found.size();
  if (count == 0 && slot.ends_with('!')) missing.push_back(parts[0]);
  if (count > 1 && !slot.ends_with('*')) {
    file.refuse(found[1].node, spoken(parts[0]) + " is given twice");
  }
  const auto values = parts.size() > 1 ? split(parts[1], "|") : std::vector<std::string>{};
  if (count > 0 && std::ranges::count(values, found.front().value) == 0) {
    if (slot.ends_with('~')) {
      file.note_no_effect(spoken(parts[0]));
    } else if (!values.empty()) {
      file.refuse(found.front().node,
                  with_advice(parts[0], fmt::format("supported: {}", fmt::join(values, ", "))));
    }
  }
  items.erase(found.begin(), found.end());
}

void check_items(SceneFile& file, const pugi::xml_node& node) {
  constexpr std::array unchecked{":text", "ref", "sampler"};
  if (std::ranges::count(unchecked, std::string_view(node.name())) > 0 && node.parent()) return;
  const std::string* rule = find_rule(file, node);
  if (rule == nullptr) return;
  for (const auto& a : node.attributes()) {
    if (node.attribute(a.name()) != a) {
      file.refuse(node, fmt::format("the attribute {} is given twice", a.name()));
    }
  }
  std::vector<Item> items = list_items(node);
  std::erase_if(items, [&](const Item& item) {
    constexpr std::array general{"@id", "@type", "@name", "@version"};
    const bool is_general = std::ranges::count(general, item.label) > 0;
    return is_general && (is_object(node.name()) || node.attribute("type"));
  });
  std::vector<std::string> labels, missing;
  for (const std::string& slot : split(*rule, ", ")) {
    if (slot.empty()) continue;
    labels.push_back(split(strip(slot, "@!*~"), "=")[0]);
    check_slot(file, slot, items, missing);
  }
  // What refers to nothing has been refused, and may be what is missing.
  const auto is_ref = [](const Item& item) { return item.label == "ref"; };
  const bool has_ref = std::erase_if(items, is_ref) > 0;
  for (const Item& item : items) {
    if (item.label == "include") continue;
    file.refuse(item.node,
                with_advice(item.label, fmt::format("{} is not supported here; "
                                                    "supported: {}",
                                                    spoken(item.label), fmt::join(labels, ", "))));
  }
  for (const std::string& label : missing) {
    if (!has_ref) file.refuse(node, with_advice(label, spoken(label) + " is missing"));
  }
}

}  // namespace

void check_grammar(SceneFile& file) {
  check_items(file, file.document());
  for (pugi::xml_node node = file.document().first_child(); node;) {
    check_items(file, node);
    const bool is_sampler = node.name() == std::string_view("sampler");  // whatever it holds
    node = is_sampler ? next_sibling_node(node) : next_node(node);
  }
}

}  // namespace plumb
