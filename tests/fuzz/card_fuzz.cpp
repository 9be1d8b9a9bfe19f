// SPDX-License-Identifier: Apache-2.0

// Any bytes as the card of a picture.
#include <stdexcept>

#include "compare/card.h"
#include "tests/fuzz/stored.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const auto card = plumb::store("card.json", data, size);
  try {
    plumb::floors_of_card(card.parent_path() / "cycles.exr");
  } catch (const std::runtime_error&) {
  }
  return 0;
}
