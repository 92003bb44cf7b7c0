#include "symbols/predicates.h"

#include <array>

namespace primo::symbols {

std::span<const Predicate> predicates() {
  static const std::array table = {on_predicate(),    inhand_predicate(), cylinder_predicate(), box_predicate(),
                                   table_predicate(), clear_predicate(),  upright_predicate()};
  return table;
}

State observe(const WorldSnapshot& snapshot) {
  State state;
  for (const auto& predicate : predicates()) predicate.observe(snapshot, state);
  return state;
}

}  // namespace primo::symbols
