#include "symbols/signatures.h"

namespace primo::symbols {
namespace {

std::string arguments(std::size_t n) { return std::to_string(n) + (n == 1 ? " argument" : " arguments"); }

}  // namespace

bool Signatures::knows(const Experience& experience) const {
  for (const auto* state : {&experience.before, &experience.after}) {
    for (const auto& literal : *state) {
      if (!uses_.contains(literal.predicate)) return false;
    }
  }
  return actions_.contains(experience.action.predicate);
}

Status Signatures::add(const Experience& experience, const std::string& where) {
  const auto note_all = [&](Signatures& into) -> Status {
    for (const auto* state : {&experience.before, &experience.after}) {
      for (const auto& literal : *state) PRIMO_TRY(into.add(literal, where));
    }
    return into.add_action(experience.action, where);
  };
  if (knows(experience)) return note_all(*this);
  Signatures with = *this;
  PRIMO_TRY(note_all(with));
  *this = std::move(with);
  return success();
}

Status Signatures::note(Uses& uses, const std::string& kind, const Literal& literal, const std::string& where) {
  const bool function = literal.relation != Relation::none;
  auto at = uses.find(literal.predicate);
  if (at == uses.end()) {
    uses.emplace(literal.predicate, Use{literal.arguments.size(), function, where});
    return success();
  }
  const Use& use = at->second;
  if (use.arity != literal.arguments.size()) {
    return Error{Code::data, where + ": " + kind + literal.predicate + " has " + arguments(literal.arguments.size()) +
                                 ", but " + std::to_string(use.arity) + " in " + use.where};
  }
  if (use.function != function) {
    return Error{Code::data, where + ": " + literal.predicate + (function ? " has a value" : " has no value") +
                                 ", other than in " + use.where};
  }
  return success();
}

}  // namespace primo::symbols
