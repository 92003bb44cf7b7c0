// States and rules in small integers, and the binding of a rule's variables: the inner loop of prediction and learning.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "symbols/literal.h"

namespace primo::rules {

using symbols::Relation;

/// A predicate's or function's index, then its terms, then −1. In a ground atom a term is an object's index; in a
/// lifted one a variable's, or constant(k).
using Atom = std::array<std::int16_t, 1 + symbols::kMaxArity>;

/// The k-th constant: an object that is the same in every scene, and that a rule may name.
constexpr std::int16_t constant(int k) { return static_cast<std::int16_t>(-2 - k); }
constexpr bool is_constant(std::int16_t term) { return term <= -2; }
constexpr std::size_t constant_index(std::int16_t term) { return static_cast<std::size_t>(-2 - term); }

struct LiftedLiteral {
  Atom atom{};
  Relation relation = Relation::none;
  bool negated = false;
  std::int32_t value = 0;
  auto operator<=>(const LiftedLiteral&) const = default;
};

/// The terms of an atom, up to the first −1.
template <class A>
auto terms(A& atom) {
  std::size_t end = 1;
  while (end < atom.size() && atom[end] != -1) ++end;
  return std::span(atom.data() + 1, end - 1);
}

/// Indices of predicates and functions.
class Vocabulary {
 public:
  std::int16_t intern(const std::string& name, std::size_t arity);
  const std::string& name(std::int16_t predicate) const { return names_[static_cast<std::size_t>(predicate)]; }
  std::size_t size() const { return names_.size(); }
  /// Gives the indices in the order of the names, and what each old index becomes; nothing when they were in order.
  std::vector<std::int16_t> sort();

 private:
  std::map<std::pair<std::string, std::size_t>, std::int16_t> indices_;
  std::vector<std::string> names_;
};

/// A function's value.
struct Valued {
  Atom atom{};
  std::int32_t value = 0;
  auto operator<=>(const Valued&) const = default;
};

/// One (s, a) or (s, a, s′). What is derived from s is in `before` and `values`, but never in `changes`.
struct Scene {
  int objects = 0;
  std::vector<Atom> before;             ///< sorted
  std::vector<Valued> values;           ///< before, sorted
  std::vector<std::int16_t> action;     ///< the objects it is applied to
  std::vector<LiftedLiteral> changes;   ///< s → s′, over objects, sorted: negated ones vanished
  std::vector<std::int16_t> constants;  ///< the object that each constant is; −1: it is not in the scene
};

/// `objects` in the order of their indices. Objects that occur in a literal but not in the list get further indices.
/// `derived` holds in s beside `before`.
Scene make_scene(Vocabulary& vocabulary, const std::vector<std::string>& objects, const symbols::State& before,
                 const symbols::Literal& action, const symbols::State& after,
                 const std::vector<std::string>& constants = {}, const symbols::State& derived = {});

/// Whether the literal holds before the action. `binding`: variable → object. A literal about a constant that is not in
/// the scene is false, its negation true.
bool holds(const Scene& scene, const LiftedLiteral& literal, const std::vector<std::int16_t>& binding);
/// The same after the action.
bool holds_after(const Scene& scene, const LiftedLiteral& literal, const std::int16_t* binding);

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

/// Binds the variables of an action's terms; false when the scene's action is another.
bool bind_action(const std::vector<std::int16_t>& action, const Scene& scene, std::vector<std::int16_t>& binding);

/// Number of variables that an action's terms bind.
int count_arguments(const std::vector<std::int16_t>& action);

}  // namespace primo::rules
