// What of the rules changed from one round to the next.
#include <algorithm>
#include <map>
#include <set>

#include "study/result.h"

namespace primo::study {
namespace {

/// A rule's action, context and outcomes without their probabilities: what its structure is.
std::string structure(const rules::Rule& rule) {
  std::string text = rule.action.text() + ":";
  std::set<symbols::Literal> context(rule.context.begin(), rule.context.end());
  for (const auto& literal : context) text.append(" ").append(literal.text());
  std::set<std::string> outcomes;
  for (const auto& outcome : rule.outcomes) {
    std::string one = " |";
    for (const auto& literal : std::set<symbols::Literal>(outcome.literals.begin(), outcome.literals.end()))
      one.append(" ").append(literal.text());
    outcomes.insert(one);
  }
  for (const auto& outcome : outcomes) text += outcome;
  return text;
}

std::set<symbols::Literal> as_set(const std::vector<symbols::Literal>& literals) {
  return {literals.begin(), literals.end()};
}

bool outside(double p, const Rate& rate) { return p < rate.lower() || p > rate.upper(); }

/// Whether two counts of the same outcome cannot be told apart: each probability lies in the other's interval.
bool probability_changed(const Rate& a, const Rate& b) { return outside(a.value(), b) || outside(b.value(), a); }

}  // namespace

const rules::Rule* rule_of(const rules::RuleSet& rules, const std::string& action) {
  const rules::Rule* found = nullptr;
  for (const auto& rule : rules.rules) {
    if (rule.action.predicate == action && (found == nullptr || rule.trials() > found->trials())) found = &rule;
  }
  return found;
}

bool rules_changed(const rules::RuleSet& before, const rules::RuleSet& after) {
  std::map<std::string, const rules::Rule*> old_rules, new_rules;
  for (const auto& rule : before.rules) old_rules[structure(rule)] = &rule;
  for (const auto& rule : after.rules) new_rules[structure(rule)] = &rule;
  if (old_rules.size() != new_rules.size()) return true;
  for (const auto& [text, rule] : old_rules) {
    const auto other = new_rules.find(text);
    if (other == new_rules.end()) return true;
    for (const auto& outcome : rule->outcomes) {
      const auto same =
          std::find_if(other->second->outcomes.begin(), other->second->outcomes.end(),
                       [&](const rules::RuleOutcome& o) { return as_set(o.literals) == as_set(outcome.literals); });
      if (probability_changed({outcome.count, rule->trials()}, {same->count, other->second->trials()})) return true;
    }
  }
  return false;
}

}  // namespace primo::study
