// Derived predicates and functions ("concepts"): what follows from a state, by definitions that people write in a file
// or the learner invents. One definition a line, each of names that the state or an earlier definition has:
//
//   clear(X) := not exists Y: on(Y,X)
//   above(X,Y) := closure on(X,Y)
//   height(X) := count Y: above(X,Y)
//   top(X) := clear(X) and exists Y: (on(X,Y) and not table(Y)) and height(X) >= 2
//
// As in rules, different variables are different objects. A quantifier reaches to the end of its parenthesis or line. A
// count is 0 where nothing is counted. # begins a comment.
#pragma once

#include <string>
#include <vector>

#include "core/result.h"
#include "symbols/literal.h"

namespace primo::symbols {

/// A literal, a conjunction, or a quantified conjunction; or the negation of one.
struct Formula {
  enum class Kind : std::uint8_t { literal, conjunction, exists, forall };
  Kind kind = Kind::literal;
  bool negated = false;
  Literal literal = {};                     ///< not negated itself
  std::vector<std::string> variables = {};  ///< quantified
  std::vector<Formula> parts = {};          ///< of a conjunction; the one formula that is quantified

  bool operator==(const Formula&) const = default;
};

struct Definition {
  enum class Kind : std::uint8_t { formula, closure, count };
  Literal head;  ///< its arguments are different variables; a count's is a function
  Kind kind = Kind::formula;
  std::vector<std::string> counted;  ///< variables, of a count
  Formula body;                      ///< of a closure: the literal

  bool operator==(const Definition&) const = default;
  std::string text() const;  ///< as above, on one line
};

inline constexpr std::size_t kMaxDefinitions = 1000;
inline constexpr std::size_t kMaxDerivedArity = 3;

/// One definition. Error (data): what is wrong at which character.
Result<Definition> definition_from_text(const std::string& line);
/// A file of them. Errors (data) with `name:line`: also a name that is defined twice or used before its definition.
Result<std::vector<Definition>> definitions_from_text(const std::string& text, const std::string& name);
/// Error (data): a name is defined twice, or used by a definition that stands before its own.
Status check_order(const std::vector<Definition>& definitions);

/// What follows from the state, by one definition after the other; only what is derived. The objects are those that
/// variables may be.
State derive(const std::vector<Definition>& definitions, const std::vector<std::string>& objects, const State& state);

}  // namespace primo::symbols
