#include "symbols/predicates.h"

namespace primo::symbols {

Predicate cylinder_predicate() {
  return {"cylinder", 1, "X is a cylinder", [](const WorldSnapshot& snapshot, State& state) {
            for (const auto& x : snapshot.bodies) {
              if (x.kind == BodyKind::cylinder) state.insert({"cylinder", {x.name}});
            }
          }};
}

}  // namespace primo::symbols
