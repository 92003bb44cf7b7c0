// Which names are predicates, functions and actions, with how many arguments: one name means one thing in all data.
#pragma once

#include <map>
#include <string>

#include "symbols/literal.h"

namespace primo::symbols {

class Signatures {
 public:
  /// Notes every name in the experience. Error (data): one is used with another number of arguments, or as a function
  /// here and a predicate there; `where` says where this one stands. Actions have names of their own. Nothing is noted
  /// of an experience that is refused.
  Status add(const Experience& experience, const std::string& where);
  Status add(const Literal& literal, const std::string& where) { return note(uses_, "", literal, where); }
  Status add_action(const Literal& literal, const std::string& where) {
    return note(actions_, "the action ", literal, where);
  }

 private:
  struct Use {
    std::size_t arity = 0;
    bool function = false;
    std::string where;  ///< first
  };
  using Uses = std::map<std::string, Use>;
  bool knows(const Experience& experience) const;
  static Status note(Uses& uses, const std::string& kind, const Literal& literal, const std::string& where);

  Uses uses_, actions_;
};

}  // namespace primo::symbols
