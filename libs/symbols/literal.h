// Literals and states: closed-world sets of ground atoms, and values of integer functions.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/result.h"

namespace primo::symbols {

inline constexpr std::size_t kMaxArity = 7;  ///< arguments of a literal

/// How a literal speaks of an integer function's value; none: of a predicate.
enum class Relation : std::uint8_t { none, equal, at_least, at_most };

/// predicate(arguments…), or function(arguments…) = value (≥, ≤), or the negation of either. Ground when no argument
/// begins with a capital.
struct Literal {
  std::string predicate;
  std::vector<std::string> arguments;
  bool negated = false;
  Relation relation = Relation::none;
  std::int32_t value = 0;  ///< 0 for a predicate

  auto operator<=>(const Literal&) const = default;
  std::string text() const;  ///< "¬on(c1,t)", "size(c1)=3"; without arguments "wet"
};

/// What holds; everything else does not. A function has at most one value for the same arguments.
using State = std::set<Literal>;

/// The function's value; nothing where it has none.
std::optional<std::int32_t> value_of(const State& state, const std::string& function,
                                     const std::vector<std::string>& arguments);

/// Whether the ground literal is true. A comparison with a value that is not there is false, its negation true.
bool holds(const Literal& literal, const State& state);

/// Makes the ground literal true: a predicate's is added or (negated) taken away; a function gets the value, or
/// (negated) loses it.
void make_true(const Literal& literal, State& state);

/// (s, a, s′) with its identity. Objects are all constants that exist in the scene.
struct Experience {
  std::string id;  ///< unique; experiences are de-duplicated and ordered by it
  std::vector<std::string> objects;
  State before;
  Literal action;
  State after;
};

/// Whether a term is a variable: it begins with a capital.
bool is_variable(const std::string& term);

/// A well-formed experience: known, distinct objects that are no variables; ground, positive literals over them; one
/// value a function. Error: data.
Status validate(const Experience& experience);

/// One JSON line: {"objects":[…],"s":[["on","c1","t"],["size","c1",3],…],"a":["grasp","c1"],"s2":[…]}; an "id" is
/// written when it is not empty.
std::string to_json_line(const Experience& experience);
Result<Experience> experience_from_json(const std::string& line);

/// {"objects":[…],"s":[…]}: where a plan begins. The other keys of an experience are allowed and not looked at.
struct Situation {
  std::vector<std::string> objects;
  State state;
};
Result<Situation> situation_from_json(const std::string& text);

}  // namespace primo::symbols
