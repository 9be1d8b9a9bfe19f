// SPDX-License-Identifier: Apache-2.0

// Other renderers in the help of commands.
#pragma once

#include <string>

#include "other_renderers/other_renderer.h"

namespace plumb::cli {

// "a, b or c", where `text` gives a, b and c, or nothing for a renderer that is left out.
template <typename Text>
std::string list_renderers(Text text) {
  std::string list, last;
  for (const OtherRenderer& renderer : other_renderers()) {
    const std::string next = text(renderer);
    if (next.empty()) continue;
    if (!last.empty()) list += (list.empty() ? "" : ", ") + last;
    last = next;
  }
  return list.empty() ? last : list + " or " + last;
}

}  // namespace plumb::cli
