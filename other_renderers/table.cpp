// SPDX-License-Identifier: Apache-2.0

// The table of other renderers. Who adds one adds its function here, in both places.
#include <stdexcept>

#include "other_renderers/description.h"
#include "other_renderers/other_renderer.h"

namespace plumb {

// Each is in the file of its name.
OtherRenderer povray();
OtherRenderer cycles();
OtherRenderer mitsuba();

const std::vector<OtherRenderer>& other_renderers() {
  static const std::vector<OtherRenderer> table{povray(), cycles(), mitsuba()};
  return table;
}

OtherRenderer other_renderer(const std::string& word) {
  if (word.ends_with(".toml")) return read_description(word);
  std::string words;
  for (const OtherRenderer& renderer : other_renderers()) {
    if (renderer.word == word) return renderer;
    words += (words.empty() ? "" : ", ") + renderer.word;
  }
  throw std::invalid_argument("'" + word + "' is not one of " + words +
                              ", and no renderer's description, FILE.toml");
}

}  // namespace plumb
