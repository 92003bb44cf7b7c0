// Literals and states: closed-world sets of ground atoms.
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "core/result.h"

namespace primo::symbols {

inline constexpr std::size_t kMaxArity = 7;  ///< arguments of a literal

/// predicate(arguments…), or its negation. Ground when no argument begins with a capital.
struct Literal {
  std::string predicate;
  std::vector<std::string> arguments;
  bool negated = false;

  auto operator<=>(const Literal&) const = default;
  std::string text() const;  ///< "¬on(c1,t)"; without arguments "wet"
};

/// What holds; everything else does not.
using State = std::set<Literal>;

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

/// A well-formed experience: known, distinct objects that are no variables; ground, positive literals over them. Error:
/// data.
Status validate(const Experience& experience);

/// One JSON line: {"objects":[…],"s":[["on","c1","t"],…],"a":["grasp","c1"],"s2":[…]}; an "id" is written when it is
/// not empty.
std::string to_json_line(const Experience& experience);
Result<Experience> experience_from_json(const std::string& line);

}  // namespace primo::symbols
