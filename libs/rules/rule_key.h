// A rule without its outcomes, as the search handles it.
#pragma once

#include <compare>
#include <vector>

#include "core/hash.h"
#include "rules/grounding.h"

namespace primo::rules {

/// Which variables (or constants) the action's terms are, and the context. Variables beyond the action's are deictic.
struct RuleKey {
  std::vector<std::int16_t> action;
  int variables = 0;
  std::vector<LiftedLiteral> context;
  auto operator<=>(const RuleKey&) const = default;

  int arguments() const { return count_arguments(action); }
  int references() const { return variables - arguments(); }
};

/// The same rule in the one form that all its renamings of variables share: the action's in order, unused ones dropped,
/// the context sorted, the deictic ones numbered so that it comes first among all numberings.
RuleKey canonical(RuleKey key);

/// Which variable each term of the scene's action becomes: 0, 1, … in order, the same object the same variable.
std::vector<std::int16_t> action_terms(const Scene& scene);

inline Hasher& add(Hasher& hasher, const LiftedLiteral& literal) {
  return hasher.bytes(literal.atom.data(), sizeof literal.atom)
      .add(static_cast<std::uint64_t>(literal.relation) * 2 + literal.negated)
      .add(literal.value);
}

struct RuleKeyHash {
  std::size_t operator()(const RuleKey& key) const;
};

struct LiteralHash {
  std::size_t operator()(const LiftedLiteral& literal) const;
};

}  // namespace primo::rules
