// What may stand where in a scene file.
#pragma once

#include <pugixml.hpp>
#include <string>

namespace plumb {

// Thrown for what cannot stay as it is in a scene file.
struct Refusal {
  pugi::xml_node node;
  std::string what;
};

// Replaces each `$name` by what the `default` elements before it say; then throws Refusal unless
// all elements and attributes are supported, complete and unique.
void check_grammar(const pugi::xml_document& document);

}  // namespace plumb
