#include <cmath>

#include "symbols/predicates.h"

namespace primo::symbols {

bool rests_on(const WorldSnapshot& snapshot, const SnapshotBody& x, const SnapshotBody& y) {
  if (x.name == y.name || x.kind == BodyKind::table || snapshot.in_hand.contains(x.name)) return false;
  return std::abs(bottom_height(x) - top_height(y)) <= kSupportTolerance && above_footprint(y, x.X_WB.translation());
}

Predicate on_predicate() {
  return {"on", 2, "X stands or lies on Y", [](const WorldSnapshot& snapshot, State& state) {
            for (const auto& x : snapshot.bodies) {
              for (const auto& y : snapshot.bodies) {
                if (rests_on(snapshot, x, y)) state.insert({"on", {x.name, y.name}});
              }
            }
          }};
}

}  // namespace primo::symbols
