#include "symbols/predicates.h"

namespace primo::symbols {

Predicate box_predicate() {
  return {"box", 1, "X is a box", [](const WorldSnapshot& snapshot, State& state) {
            for (const auto& x : snapshot.bodies) {
              if (x.kind == BodyKind::box) state.insert({"box", {x.name}});
            }
          }};
}

}  // namespace primo::symbols
