#include "rules/learner.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "rules/prediction.h"
#include "rules/search.h"

namespace primo::rules {
namespace {

using symbols::Experience;
using symbols::Literal;

std::string variable_name(int index) {
  static const char* const kNames[] = {"X", "Y", "Z", "U", "V", "W"};
  if (index < 6) return kNames[index];
  std::string name("X");
  return name.append(std::to_string(index));
}

std::string term_name(const ExperienceStore& store, std::int16_t term) {
  return is_constant(term) ? store.background().constants[constant_index(term)] : variable_name(term);
}

Literal to_literal(const ExperienceStore& store, const LiftedLiteral& lifted) {
  Literal literal{store.vocabulary().name(lifted.atom[0]), {}, lifted.negated, lifted.relation, lifted.value};
  for (const auto term : terms(lifted.atom)) literal.arguments.push_back(term_name(store, term));
  return literal;
}

/// As people read them: what holds before what does not, relations before properties, by variable.
std::vector<Literal> to_literals(const ExperienceStore& store, std::vector<LiftedLiteral> lifted) {
  const auto arity = [](const LiftedLiteral& literal) {
    return std::find(literal.atom.begin() + 1, literal.atom.end(), -1) - literal.atom.begin();
  };
  std::sort(lifted.begin(), lifted.end(), [&](const LiftedLiteral& a, const LiftedLiteral& b) {
    if (a.negated != b.negated) return b.negated;
    if (arity(a) != arity(b)) return arity(a) > arity(b);
    const auto order =
        std::lexicographical_compare_three_way(a.atom.begin() + 1, a.atom.end(), b.atom.begin() + 1, b.atom.end());
    if (order != 0) return order < 0;
    return std::tie(a.atom[0], a.relation, a.value) < std::tie(b.atom[0], b.relation, b.value);
  });
  std::vector<Literal> literals;
  for (const auto& literal : lifted) literals.push_back(to_literal(store, literal));
  return literals;
}

Rule to_rule(const ExperienceStore& store, const std::string& action, const RuleKey& key, const FittedRule& fitted) {
  Rule rule;
  rule.action.predicate = action;
  for (const auto term : key.action) rule.action.arguments.push_back(term_name(store, term));
  rule.context = to_literals(store, key.context);
  const auto& induced = *fitted.induced;
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < induced.outcomes.size(); ++i) order.push_back(i);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return induced.fit.p[a] > induced.fit.p[b]; });
  for (const auto i : order) {
    rule.outcomes.push_back({induced.fit.p[i], to_literals(store, induced.outcomes[i]), induced.counts[i]});
  }
  rule.noise = induced.fit.noise;
  rule.noise_count = induced.noise_count;
  rule.examples = fitted.covered.count();
  return rule;
}

}  // namespace

Status check(const LearnerSettings& settings) {
  const auto config = [](const std::string& message) { return Error{Code::config, message}; };
  if (!(settings.alpha >= 0) || !std::isfinite(settings.alpha)) return config("alpha must be finite and not negative");
  if (!(settings.p_min > 0) || !(settings.p_min <= 0.1)) return config("p_min must be above 0 and at most 0.1");
  if (settings.max_references < 0 || settings.max_references > 6) return config("max_references must be from 0 to 6");
  for (const auto& [name, nats] : {std::pair("caution", settings.caution),
                                   {"requirement", settings.requirement},
                                   {"negation", settings.negation},
                                   {"term", settings.term},
                                   {"guess", settings.guess}}) {
    if (!(nats >= 0) || !std::isfinite(nats))
      return config(std::string(name).append(" must be finite and not negative"));
  }
  if (settings.max_steps < 1 || settings.max_candidates < 1 || settings.look_ahead < 0) {
    return config("max_steps and max_candidates must be at least 1, look_ahead at least 0");
  }
  return success();
}

Result<RuleSet> learn(const std::vector<Experience>& experiences, const LearnerSettings& settings,
                      const Background& background) {
  PRIMO_TRY(check(settings));
  PRIMO_TRY(symbols::check_order(background.derived));
  ExperienceStore store(background);
  for (std::size_t i = 0; i < experiences.size(); ++i) {
    const auto& id = experiences[i].id;
    PRIMO_TRY(store.add(experiences[i], "experience " + (id.empty() ? std::to_string(i + 1) : id)));
  }
  return learn(store, settings);
}

Result<RuleSet> learn(ExperienceStore& store, const LearnerSettings& settings) {
  PRIMO_TRY(check(settings));
  store.sort();
  RuleSet rules;
  for (const auto& [action, scenes] : store.scenes()) {
    ActionExamples examples(scenes, store.changing(), settings);
    add_rules(store, action, examples, Search(examples).climb({}).rules, rules);
  }
  rules.derived = store.background().derived;
  return rules;
}

double add_rules(const ExperienceStore& store, const std::string& action, ActionExamples& examples,
                 const std::vector<RuleKey>& keys, RuleSet& rules) {
  Bits covered(examples.scenes().size());
  double score = 0;
  for (const auto& key : keys) {
    const auto& fitted = examples.fit(key);
    if (!fitted.usable()) continue;
    rules.rules.push_back(to_rule(store, action, key, fitted));
    covered |= fitted.covered;
    score += fitted.induced->score - examples.settings().alpha * static_cast<double>(key.context.size());
  }
  double rest = 0;
  rules.defaults[action] = examples.default_rule(covered, &rest);
  return score + rest;
}

std::vector<Literal> untested_context(const Rule& rule, const std::vector<Experience>& experiences) {
  std::optional<std::set<Literal>> common;
  for (const auto& experience : experiences) {
    const auto binding = bind_rule(rule, experience.objects, experience.before, experience.action);
    if (!binding) continue;
    Binding variables;  // object → variable
    for (const auto& [variable, object] : *binding) variables[object] = variable;
    std::set<Literal> held;
    for (const auto& literal : experience.before) {
      const auto bound = [&](const std::string& argument) { return variables.contains(argument); };
      if (!std::all_of(literal.arguments.begin(), literal.arguments.end(), bound)) continue;
      held.insert(ground({literal}, variables).front());
    }
    if (!common) {
      common = std::move(held);
    } else {
      std::erase_if(*common, [&](const Literal& literal) { return !held.contains(literal); });
    }
  }
  if (!common) return {};
  for (const auto& literal : rule.context) common->erase(literal);
  return {common->begin(), common->end()};
}

}  // namespace primo::rules
