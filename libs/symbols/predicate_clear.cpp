#include <algorithm>

#include "symbols/predicates.h"

namespace primo::symbols {

Predicate clear_predicate() {
  return {"clear", 1, "nothing stands or lies on X; tables have no such literal",
          [](const WorldSnapshot& snapshot, State& state) {
            for (const auto& x : snapshot.bodies) {
              const bool covered = std::any_of(snapshot.bodies.begin(), snapshot.bodies.end(),
                                               [&](const auto& y) { return rests_on(snapshot, y, x); });
              if (x.kind != BodyKind::table && !covered) state.insert({"clear", {x.name}});
            }
          }};
}

}  // namespace primo::symbols
