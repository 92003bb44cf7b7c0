#include "symbols/predicates.h"

namespace primo::symbols {

Predicate table_predicate() {
  return {"table", 1, "X is a table", [](const WorldSnapshot& snapshot, State& state) {
            for (const auto& x : snapshot.bodies) {
              if (x.kind == BodyKind::table) state.insert({"table", {x.name}});
            }
          }};
}

}  // namespace primo::symbols
