#include "rules/invent.h"

#include <algorithm>
#include <map>
#include <set>

#include "rules/score.h"

namespace primo::rules {
namespace {

using symbols::Definition;
using symbols::Experience;
using symbols::Formula;
using symbols::Literal;
using symbols::Relation;

struct Predicate {
  std::string name;
  std::size_t arity = 0;
  auto operator<=>(const Predicate&) const = default;
};

void collect(const Formula& formula, std::set<std::string>& names) {
  if (formula.kind == Formula::Kind::literal) names.insert(formula.literal.predicate);
  for (const auto& part : formula.parts) collect(part, names);
}

/// The definitions that the rules' contexts use, and those that these use.
std::vector<Definition> in_use(const RuleSet& rules) {
  std::set<std::string> names;
  for (const auto& rule : rules.rules) {
    for (const auto& literal : rule.context) names.insert(literal.predicate);
  }
  std::vector<Definition> used;
  for (auto at = rules.derived.rbegin(); at != rules.derived.rend(); ++at) {
    if (!names.contains(at->head.predicate)) continue;
    collect(at->body, names);
    used.push_back(*at);
  }
  std::reverse(used.begin(), used.end());
  return used;
}

Literal over(const Predicate& predicate, const std::vector<std::string>& terms) { return {predicate.name, terms}; }

/// exists of every predicate, closure and counts of binary ones.
std::vector<Definition> extensions(const std::vector<Predicate>& predicates) {
  std::vector<Definition> found;
  const auto exists = [&](const std::string& name, std::vector<std::string> head, std::vector<std::string> variables,
                          const Literal& literal) {
    const Formula inner{.literal = literal};
    found.push_back({.head = {name, std::move(head)},
                     .kind = Definition::Kind::formula,
                     .counted = {},
                     .body = {.kind = Formula::Kind::exists, .variables = std::move(variables), .parts = {inner}}});
  };
  for (const auto& predicate : predicates) {
    const std::string& p = predicate.name;
    if (predicate.arity == 1) exists("c-some-" + p, {}, {"Y"}, over(predicate, {"Y"}));
    if (predicate.arity != 2) continue;
    exists("c-" + p + "-some", {"X"}, {"Y"}, over(predicate, {"X", "Y"}));
    exists("c-some-" + p, {"X"}, {"Y"}, over(predicate, {"Y", "X"}));
    found.push_back({.head = {"c-" + p + "-closure", {"X", "Y"}},
                     .kind = Definition::Kind::closure,
                     .counted = {},
                     .body = {.literal = over(predicate, {"X", "Y"})}});
    found.push_back({.head = {.predicate = "c-" + p + "-number", .arguments = {"X"}, .relation = Relation::equal},
                     .kind = Definition::Kind::count,
                     .counted = {"Y"},
                     .body = {.literal = over(predicate, {"X", "Y"})}});
    found.push_back({.head = {.predicate = "c-number-" + p, .arguments = {"X"}, .relation = Relation::equal},
                     .kind = Definition::Kind::count,
                     .counted = {"Y"},
                     .body = {.literal = over(predicate, {"Y", "X"})}});
  }
  return found;
}

std::vector<Predicate> primitives(const std::vector<Experience>& experiences) {
  std::set<Predicate> found;
  for (const auto& experience : experiences) {
    for (const auto& literal : experience.before) {
      if (literal.relation == Relation::none) found.insert({literal.predicate, literal.arguments.size()});
    }
  }
  return {found.begin(), found.end()};
}

}  // namespace

Result<RuleSet> learn_inventing(const std::vector<Experience>& experiences, const LearnerSettings& settings,
                                const Background& background, const InventionSettings& invention) {
  const auto worth = [&](const RuleSet& rules) {
    const auto concepts = static_cast<double>(in_use(rules).size());
    return assess(rules, experiences, settings.p_min).total(settings.alpha) - invention.alpha * concepts;
  };
  PRIMO_ASSIGN(RuleSet best, learn(experiences, settings, background));
  double reached = worth(best);
  auto predicates = primitives(experiences);
  std::set<std::string> known;
  for (const auto& predicate : predicates) known.insert(predicate.name);
  for (int round = 0; round < invention.rounds; ++round) {
    Background extended = background;
    std::set<std::string> names = known;
    for (const auto& definition : background.derived) names.insert(definition.head.predicate);
    const auto add = [&](const Definition& definition) {
      if (names.insert(definition.head.predicate).second) extended.derived.push_back(definition);
    };
    for (const auto& definition : in_use(best)) {
      add(definition);
      if (round > 0 && definition.head.relation == Relation::none) {
        predicates.push_back({definition.head.predicate, definition.head.arguments.size()});
      }
    }
    const auto candidates = extensions(predicates);
    for (std::size_t i = 0; i < candidates.size() && i < static_cast<std::size_t>(invention.max_concepts); ++i) {
      add(candidates[i]);
    }
    PRIMO_ASSIGN(RuleSet rules, learn(experiences, settings, extended));
    const double value = worth(rules);
    if (!(value > reached + 1e-9)) break;
    reached = value;
    best = std::move(rules);
  }
  // The background's stay, since they were asked for; of the invented ones those in use.
  auto kept = background.derived;
  for (const auto& definition : in_use(best)) {
    if (std::find(kept.begin(), kept.end(), definition) == kept.end()) kept.push_back(definition);
  }
  best.derived = std::move(kept);
  return best;
}

}  // namespace primo::rules
