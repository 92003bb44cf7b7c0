// Damaged texts for the tests of readers.
#pragma once

#include <string>

#include "core/random.h"

namespace primo::test {

/// The text with one to three random edits: a byte changed, up to three cut, or up to seven of its own put in again.
inline std::string mutated(std::string text, Random& random) {
  for (std::uint64_t edits = 1 + random.below(3); edits > 0 && !text.empty(); --edits) {
    const auto at = random.below(text.size());
    switch (random.below(3)) {
      case 0:
        text[at] = static_cast<char>(random.below(256));
        break;
      case 1:
        text.erase(at, 1 + random.below(3));
        break;
      default:
        text.insert(at, text.substr(random.below(text.size()), random.below(8)));
    }
  }
  return text;
}

}  // namespace primo::test
