#include "rules/learner.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

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

Literal to_literal(const Vocabulary& vocabulary, const LiftedLiteral& lifted) {
  Literal literal{vocabulary.name(lifted.atom[0]), {}, lifted.negated};
  for (std::size_t i = 1; i < lifted.atom.size() && lifted.atom[i] != -1; ++i) {
    literal.arguments.push_back(variable_name(lifted.atom[i]));
  }
  return literal;
}

/// As people read them: what holds before what does not, relations before properties, by variable.
std::vector<Literal> to_literals(const Vocabulary& vocabulary, std::vector<LiftedLiteral> lifted) {
  const auto arity = [](const LiftedLiteral& literal) {
    return std::find(literal.atom.begin() + 1, literal.atom.end(), -1) - literal.atom.begin();
  };
  std::sort(lifted.begin(), lifted.end(), [&](const LiftedLiteral& a, const LiftedLiteral& b) {
    if (a.negated != b.negated) return b.negated;
    if (arity(a) != arity(b)) return arity(a) > arity(b);
    const auto order =
        std::lexicographical_compare_three_way(a.atom.begin() + 1, a.atom.end(), b.atom.begin() + 1, b.atom.end());
    return order != 0 ? order < 0 : a.atom[0] < b.atom[0];
  });
  std::vector<Literal> literals;
  for (const auto& literal : lifted) literals.push_back(to_literal(vocabulary, literal));
  return literals;
}

Rule to_rule(const Vocabulary& vocabulary, const std::string& action, const RuleKey& key, const FittedRule& fitted) {
  Rule rule;
  rule.action.predicate = action;
  for (const auto term : key.action) rule.action.arguments.push_back(variable_name(term));
  rule.context = to_literals(vocabulary, key.context);
  const auto& induced = *fitted.induced;
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < induced.outcomes.size(); ++i) order.push_back(i);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return induced.fit.p[a] > induced.fit.p[b]; });
  for (const auto i : order) {
    rule.outcomes.push_back({induced.fit.p[i], to_literals(vocabulary, induced.outcomes[i]), induced.counts[i]});
  }
  rule.noise = induced.fit.noise;
  rule.noise_count = induced.noise_count;
  rule.examples = fitted.covered.count();
  return rule;
}

Status check(const LearnerSettings& settings) {
  const auto config = [](const std::string& message) { return Error{Code::config, message}; };
  if (!(settings.alpha >= 0) || !std::isfinite(settings.alpha)) return config("alpha must be finite and not negative");
  if (!(settings.p_min > 0) || !(settings.p_min <= 0.1)) return config("p_min must be above 0 and at most 0.1");
  if (settings.max_references < 0 || settings.max_references > 6) return config("max_references must be from 0 to 6");
  if (settings.max_steps < 1 || settings.max_evaluations < 1) {
    return config("max_steps and max_evaluations must be at least 1");
  }
  return success();
}

constexpr std::size_t kMaxObjects = 1000;
constexpr std::size_t kMaxPredicates = 10000;

/// Well-formed experiences, each id once.
Result<std::vector<const Experience*>> distinct(const std::vector<Experience>& experiences) {
  std::map<std::string, const Experience*> by_id;
  std::vector<const Experience*> kept;
  for (std::size_t i = 0; i < experiences.size(); ++i) {
    const auto& experience = experiences[i];
    const std::string where = "experience " + (experience.id.empty() ? std::to_string(i + 1) : experience.id);
    if (const auto status = symbols::validate(experience); !status.ok()) return status.error().at(where);
    if (experience.objects.size() > kMaxObjects) {
      return Error{Code::data, where + ": " + std::to_string(experience.objects.size()) + " objects; at most " +
                                   std::to_string(kMaxObjects) + " are supported"};
    }
    if (!experience.id.empty()) {
      const auto [at, fresh] = by_id.try_emplace(experience.id, &experience);
      if (!fresh) {
        if (symbols::to_json_line(*at->second) == symbols::to_json_line(experience)) continue;
        return Error{Code::data, where + " stands twice with different contents; ids must be unique"};
      }
    }
    kept.push_back(&experience);
  }
  return kept;
}

/// All predicates in the order of their names, so that their indices do not depend on the order of the experiences.
Result<Vocabulary> make_vocabulary(const std::vector<const Experience*>& experiences) {
  std::set<std::pair<std::string, std::size_t>> predicates;
  for (const auto* experience : experiences) {
    for (const auto* state : {&experience->before, &experience->after}) {
      for (const auto& literal : *state) predicates.emplace(literal.predicate, literal.arguments.size());
    }
  }
  if (predicates.size() > kMaxPredicates) {
    return Error{Code::data, std::to_string(predicates.size()) + " predicates; at most " +
                                 std::to_string(kMaxPredicates) + " are supported"};
  }
  Vocabulary vocabulary;
  for (const auto& [name, arity] : predicates) vocabulary.intern(name, arity);
  return vocabulary;
}

}  // namespace

Result<RuleSet> learn(const std::vector<Experience>& experiences, const LearnerSettings& settings) {
  PRIMO_TRY(check(settings));
  PRIMO_ASSIGN(const auto kept, distinct(experiences));
  PRIMO_ASSIGN(Vocabulary vocabulary, make_vocabulary(kept));
  std::map<std::string, std::vector<Scene>> scenes;
  for (const auto* experience : kept) {
    scenes[experience->action.predicate].push_back(
        make_scene(vocabulary, experience->objects, experience->before, experience->action, experience->after));
  }
  RuleSet rules;
  for (auto& [action, examples] : scenes) {
    Bits covered(examples.size());
    ActionExamples problem(std::move(examples), settings);
    for (const auto& key : search_rules(problem)) {
      const auto& fitted = problem.fit(key);
      rules.rules.push_back(to_rule(vocabulary, action, key, fitted));
      covered |= fitted.covered;
    }
    rules.defaults[action] = problem.default_rule(covered, nullptr);
  }
  return rules;
}

double score(const RuleSet& rules, const std::vector<Experience>& experiences, const LearnerSettings& settings) {
  double sum = 0;
  for (const auto& experience : experiences) {
    const auto prediction = predict(rules, experience.objects, experience.before, experience.action);
    double p = settings.p_min * prediction.noise;
    for (const auto& successor : prediction.successors) {
      if (successor.state == experience.after) p += successor.p;
    }
    // A rule set may rule a state out altogether; its score is then as low as numbers go, and finite.
    sum += std::log(std::max(p, 1e-300));
  }
  std::size_t literals = 0;
  for (const auto& rule : rules.rules) {
    literals += rule.context.size();
    for (const auto& outcome : rule.outcomes) literals += outcome.literals.size();
  }
  return sum - settings.alpha * static_cast<double>(literals);
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
