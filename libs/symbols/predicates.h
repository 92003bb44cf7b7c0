// Predicates: ground literals from the geometry of a snapshot. One file and one line of predicates() for each.
#pragma once

#include <span>
#include <string_view>

#include "symbols/literal.h"
#include "symbols/snapshot.h"

namespace primo::symbols {

struct Predicate {
  std::string_view name;
  int arity = 1;
  std::string_view meaning;  ///< one sentence, for help and docs
  /// Adds every ground literal of this predicate that holds.
  void (*observe)(const WorldSnapshot&, State&) = nullptr;
};

/// The table of all predicates.
std::span<const Predicate> predicates();

/// All literals that hold; what is absent is false. Names of bodies must be distinct.
State observe(const WorldSnapshot& snapshot);

/// How far the lowest point of one body may be from the top of another that it stands on, m.
inline constexpr double kSupportTolerance = 0.006;
/// How far an upright body's axis may lean from the vertical, rad.
inline constexpr double kUprightTolerance = 0.3;

/// Whether x stands or lies on y: not in the hand, its lowest point at the top of y, its centre over y.
bool rests_on(const WorldSnapshot& snapshot, const SnapshotBody& x, const SnapshotBody& y);

Predicate on_predicate();
Predicate inhand_predicate();
Predicate cylinder_predicate();
Predicate box_predicate();
Predicate table_predicate();
Predicate clear_predicate();
Predicate upright_predicate();

}  // namespace primo::symbols
