// Rules and definitions of derived predicates from anywhere: read or refused with a reason; what was read is written
// and read the same.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "rules/export.h"
#include "rules/rule.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(data, data + size);
  if (const auto definition = primo::symbols::definition_from_text(text); definition.ok()) {
    const auto again = primo::symbols::definition_from_text(definition->text());
    if (!again.ok() || !(*again == *definition)) std::abort();
  } else if (definition.error().message.empty()) {
    std::abort();
  }
  const auto rules = primo::rules::rules_from_json(text);
  if (!rules.ok()) {
    if (rules.error().message.empty()) std::abort();
    return 0;
  }
  const std::string written = primo::rules::to_json(*rules);
  const auto again = primo::rules::rules_from_json(written);
  if (!again.ok() || primo::rules::to_json(*again) != written) std::abort();
  // Whatever the rules are, they can be printed and exported, or not for a reason.
  primo::rules::to_text(*rules);
  primo::rules::to_latex(*rules);
  const auto ppddl = primo::rules::to_ppddl(*rules);
  if (!ppddl.ok() && ppddl.error().message.empty()) std::abort();
  return 0;
}
