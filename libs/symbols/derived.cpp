#include "symbols/derived.h"

#include <algorithm>
#include <functional>
#include <map>

namespace primo::symbols {
namespace {

using Kind = Formula::Kind;
using Binding = std::map<std::string, std::string>;

/// Bindings of variables to different objects for which a formula is true. Positive literals are looked up in the state
/// instead of trying all objects.
class Solver {
 public:
  Solver(const std::vector<std::string>& objects, const State& state) : objects_(objects), state_(state) {}

  using Found = std::function<bool(const Binding&)>;  // false: enough

  /// All extensions of `binding` by `variables` that make the formula true. False when `found` had enough.
  bool solve(const Formula& formula, Binding& binding, const std::vector<std::string>& variables, const Found& found) {
    std::vector<const Formula*> parts;
    flatten(formula, parts);
    return extend(parts, binding, variables, found);
  }

 private:
  static void flatten(const Formula& formula, std::vector<const Formula*>& parts) {
    if (formula.kind == Kind::conjunction && !formula.negated) {
      for (const auto& part : formula.parts) flatten(part, parts);
    } else {
      parts.push_back(&formula);
    }
  }

  static bool is_free(const std::string& term, const Binding& binding, const std::vector<std::string>& variables) {
    return !binding.contains(term) && std::find(variables.begin(), variables.end(), term) != variables.end();
  }

  bool extend(const std::vector<const Formula*>& parts, Binding& binding, const std::vector<std::string>& variables,
              const Found& found) {
    for (const auto* part : parts) {
      if (part->kind != Kind::literal || part->negated || part->literal.relation != Relation::none) continue;
      const auto& arguments = part->literal.arguments;
      if (std::any_of(arguments.begin(), arguments.end(),
                      [&](const std::string& term) { return is_free(term, binding, variables); })) {
        return match(*part, parts, binding, variables, found);
      }
    }
    for (const auto& variable : variables) {
      if (binding.contains(variable)) continue;
      for (const auto& object : objects_) {
        if (is_used(object, binding)) continue;
        binding[variable] = object;
        const bool more = extend(parts, binding, variables, found);
        binding.erase(variable);
        if (!more) return false;
      }
      return true;
    }
    for (const auto* part : parts) {
      if (!is_true(*part, binding)) return true;
    }
    return found(binding);
  }

  static bool is_used(const std::string& object, const Binding& binding) {
    return std::any_of(binding.begin(), binding.end(), [&](const auto& entry) { return entry.second == object; });
  }

  /// Goes on with every atom of the state that the literal may be.
  bool match(const Formula& part, const std::vector<const Formula*>& parts, Binding& binding,
             const std::vector<std::string>& variables, const Found& found) {
    for (auto at = state_.lower_bound({part.literal.predicate, {}}); at != state_.end(); ++at) {
      if (at->predicate != part.literal.predicate) break;
      if (at->arguments.size() != part.literal.arguments.size() || at->relation != Relation::none) continue;
      Binding extended = binding;
      bool fits = true;
      for (std::size_t i = 0; i < at->arguments.size() && fits; ++i) {
        const std::string& term = part.literal.arguments[i];
        const std::string& object = at->arguments[i];
        if (const auto bound = extended.find(term); bound != extended.end()) {
          fits = bound->second == object;
        } else if (is_free(term, extended, variables)) {
          fits = !is_used(object, extended);
          extended[term] = object;
        } else {
          fits = term == object;
        }
      }
      if (fits && !extend(parts, extended, variables, found)) return false;
    }
    return true;
  }

  bool is_true(const Formula& formula, Binding& binding) {
    if (formula.kind == Kind::literal) {
      Literal literal = formula.literal;
      for (auto& term : literal.arguments) {
        if (const auto bound = binding.find(term); bound != binding.end()) term = bound->second;
      }
      return holds(literal, state_) != formula.negated;
    }
    if (formula.kind == Kind::conjunction) {
      const bool all = std::all_of(formula.parts.begin(), formula.parts.end(),
                                   [&](const Formula& part) { return is_true(part, binding); });
      return all != formula.negated;
    }
    Formula part = formula.parts.front();
    const bool all = formula.kind == Kind::forall;
    if (all) part.negated = !part.negated;  // for all: not exists not
    bool exists = false;
    solve(part, binding, formula.variables, [&](const Binding&) {
      exists = true;
      return false;
    });
    return (exists != all) != formula.negated;
  }

  const std::vector<std::string>& objects_;
  const State& state_;
};

Literal instance(const Definition& definition, const Binding& binding) {
  Literal literal = definition.head;
  for (auto& argument : literal.arguments) argument = binding.at(argument);
  return literal;
}

void derive_formula(const Definition& definition, Solver& solver, State& derived) {
  Binding binding;
  solver.solve(definition.body, binding, definition.head.arguments, [&](const Binding& found) {
    derived.insert(instance(definition, found));
    return true;
  });
}

void derive_count(const Definition& definition, Solver& solver, State& derived) {
  const Formula anything{.kind = Kind::conjunction};
  Binding none;
  solver.solve(anything, none, definition.head.arguments, [&](const Binding& head) {
    Literal literal = instance(definition, head);
    Binding binding = head;
    std::set<Binding> counted;
    solver.solve(definition.body, binding, definition.counted, [&](const Binding& found) {
      counted.insert(found);
      return true;
    });
    literal.value = static_cast<std::int32_t>(counted.size());
    derived.insert(std::move(literal));
    return true;
  });
}

void derive_closure(const Definition& definition, const State& state, State& derived) {
  std::map<std::string, std::set<std::string>> next;
  const auto& step = definition.body.literal;
  const bool forward = step.arguments.front() == definition.head.arguments.front();
  for (auto at = state.lower_bound({step.predicate, {}}); at != state.end() && at->predicate == step.predicate; ++at) {
    if (at->arguments.size() == 2) next[at->arguments[forward ? 0 : 1]].insert(at->arguments[forward ? 1 : 0]);
  }
  for (const auto& [from, direct] : next) {
    std::set<std::string> reached = direct;
    std::vector<std::string> open(direct.begin(), direct.end());
    while (!open.empty()) {
      const auto at = next.find(open.back());
      open.pop_back();
      if (at == next.end()) continue;
      for (const auto& to : at->second) {
        if (reached.insert(to).second) open.push_back(to);
      }
    }
    reached.erase(from);
    for (const auto& to : reached) derived.insert({definition.head.predicate, {from, to}});
  }
}

}  // namespace

State derive(const std::vector<Definition>& definitions, const std::vector<std::string>& objects, const State& state) {
  State derived, all = state;
  for (const auto& definition : definitions) {
    State fresh;
    Solver solver(objects, all);
    switch (definition.kind) {
      case Definition::Kind::formula:
        derive_formula(definition, solver, fresh);
        break;
      case Definition::Kind::count:
        derive_count(definition, solver, fresh);
        break;
      case Definition::Kind::closure:
        derive_closure(definition, all, fresh);
        break;
    }
    all.insert(fresh.begin(), fresh.end());
    derived.insert(fresh.begin(), fresh.end());
  }
  return derived;
}

}  // namespace primo::symbols
