#include "symbols/predicates.h"

namespace primo::symbols {

Predicate inhand_predicate() {
  return {"inhand", 1, "the hand holds X", [](const WorldSnapshot& snapshot, State& state) {
            for (const auto& x : snapshot.bodies) {
              if (snapshot.in_hand.contains(x.name)) state.insert({"inhand", {x.name}});
            }
          }};
}

}  // namespace primo::symbols
