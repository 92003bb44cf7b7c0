// States and rules in small integers, and the binding of a rule's variables: the inner loop of prediction and learning.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "symbols/literal.h"

namespace primo::rules {

/// A predicate's index, then its terms, then −1. In a ground atom a term is an object's index; in a lifted one a
/// variable's, or constant(object).
using Atom = std::array<std::int16_t, 1 + symbols::kMaxArity>;

constexpr std::int16_t constant(int object) { return static_cast<std::int16_t>(-2 - object); }

struct LiftedLiteral {
  Atom atom{};
  bool negated = false;
  auto operator<=>(const LiftedLiteral&) const = default;
};

/// Indices of predicates; the same name with another number of arguments is another predicate.
class Vocabulary {
 public:
  std::int16_t intern(const std::string& name, std::size_t arity);
  const std::string& name(std::int16_t predicate) const { return names_[static_cast<std::size_t>(predicate)]; }

 private:
  std::map<std::pair<std::string, std::size_t>, std::int16_t> indices_;
  std::vector<std::string> names_;
};

/// One (s, a) or (s, a, s′). The atoms are sorted.
struct Scene {
  int objects = 0;
  std::vector<Atom> before, after;
  std::vector<std::int16_t> action;    ///< the objects it is applied to
  std::vector<LiftedLiteral> changes;  ///< s → s′, over objects: negated ones vanished
};

/// `objects` in the order of their indices. Objects that occur in a literal but not in the list get further indices.
Scene make_scene(Vocabulary& vocabulary, const std::vector<std::string>& objects, const symbols::State& before,
                 const symbols::Literal& action, const symbols::State& after);

/// A rule's action and context. Variables 0 … arguments−1 are bound by the action, the others are deictic.
class Pattern {
 public:
  Pattern(std::vector<std::int16_t> action, int variables, const std::vector<LiftedLiteral>& context);

  /// The number of ways to bind the variables to distinct objects so that the context holds before the action: 0, 1, or
  /// 2 for more than one. `binding` (variable → object) is the first way found.
  int count_bindings(const Scene& scene, std::vector<std::int16_t>& binding) const;

 private:
  int extend(const Scene& scene, std::vector<std::int16_t>& binding, std::size_t stage,
             std::vector<std::int16_t>& first) const;

  std::vector<std::int16_t> action_;
  std::size_t arguments_ = 0;
  std::vector<std::vector<LiftedLiteral>>
      stages_;  // literals that can be tested once that many deictic variables are bound
};

/// Number of variables that an action's terms bind.
int count_arguments(const std::vector<std::int16_t>& action);

/// The lifted atom with its variables replaced.
Atom instantiate(const Atom& lifted, const std::vector<std::int16_t>& binding);

bool contains(const std::vector<Atom>& sorted_atoms, const Atom& atom);

}  // namespace primo::rules
