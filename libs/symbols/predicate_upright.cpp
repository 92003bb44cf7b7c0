#include <cmath>

#include "symbols/predicates.h"

namespace primo::symbols {

Predicate upright_predicate() {
  return {"upright", 1,
          "X's axis (a cylinder's, or z of a box) is vertical, either way up; tables have no such literal",
          [](const WorldSnapshot& snapshot, State& state) {
            for (const auto& x : snapshot.bodies) {
              const bool vertical = std::abs(x.X_WB.linear()(2, 2)) >= std::cos(kUprightTolerance);
              if (x.kind != BodyKind::table && vertical) state.insert({"upright", {x.name}});
            }
          }};
}

}  // namespace primo::symbols
