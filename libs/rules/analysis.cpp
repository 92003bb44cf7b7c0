#include "rules/analysis.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "rules/prediction.h"

namespace primo::rules {
namespace {

using symbols::Experience;
using symbols::Literal;

double xlogx(double x) { return x > 0 ? x * std::log(x) : 0; }

/// k of n, each at its most likely rate: ln likelihood.
double bernoulli(std::int64_t k, std::int64_t n) {
  const auto a = static_cast<double>(k), b = static_cast<double>(n - k);
  return xlogx(a) + xlogx(b) - xlogx(a + b);
}

std::string name_of(const Experience& experience, std::size_t place) {
  return experience.id.empty() ? "#" + std::to_string(place + 1) : experience.id;
}

/// The experience's literals over the rule's variables, before the action.
std::set<Literal> lifted_state(const Experience& experience, const symbols::State& derived, const Binding& binding) {
  Binding variables;
  for (const auto& [variable, object] : binding) variables[object] = variable;
  std::set<Literal> lifted;
  for (const auto* state : {&experience.before, &derived}) {
    for (const auto& literal : *state) {
      const auto bound = [&](const std::string& argument) { return variables.contains(argument); };
      if (std::all_of(literal.arguments.begin(), literal.arguments.end(), bound)) {
        lifted.insert(ground({literal}, variables).front());
      }
    }
  }
  return lifted;
}

/// How often each literal held, among unexplained and among all covered experiences.
struct Tally {
  std::int64_t unexplained = 0, covered = 0;
  std::map<Literal, std::pair<std::int64_t, std::int64_t>> literals;

  void add(const std::set<Literal>& held, bool explained) {
    ++covered;
    unexplained += !explained;
    for (const auto& literal : held) {
      auto& [bad, all] = literals[literal];
      bad += !explained;
      ++all;
    }
  }

  std::optional<Split> best() const {
    std::optional<Split> best;
    for (const auto& [literal, counts] : literals) {
      const auto& [bad, all] = counts;
      const double gain =
          bernoulli(bad, all) + bernoulli(unexplained - bad, covered - all) - bernoulli(unexplained, covered);
      if (gain > 1e-9 && (!best || gain > best->gain)) best = Split{literal, gain};
    }
    return best;
  }
};

using Head = std::pair<Literal, std::set<Literal>>;

Head head(const Rule& rule) { return {rule.action, {rule.context.begin(), rule.context.end()}}; }

bool same_effects(const Rule& a, const Rule& b, double tolerance) {
  const auto effects = [](const Rule& rule) {
    std::map<std::set<Literal>, double> outcomes;
    for (const auto& outcome : rule.outcomes) {
      outcomes[{outcome.literals.begin(), outcome.literals.end()}] += outcome.p;
    }
    return outcomes;
  };
  const auto x = effects(a), y = effects(b);
  return x.size() == y.size() && std::abs(a.noise - b.noise) <= tolerance &&
         std::equal(x.begin(), x.end(), y.begin(), [&](const auto& p, const auto& q) {
           return p.first == q.first && std::abs(p.second - q.second) <= tolerance;
         });
}

}  // namespace

double entropy(const Rule& rule) {
  double sum = -xlogx(rule.noise);
  for (const auto& outcome : rule.outcomes) sum -= xlogx(outcome.p);
  return sum;
}

Diagnosis diagnose(const RuleSet& rules, const std::vector<Experience>& experiences) {
  const Predictor predictor(rules);
  Diagnosis diagnosis;
  for (std::size_t r = 0; r < rules.rules.size(); ++r) {
    diagnosis.rules.push_back({.rule = r,
                               .entropy = entropy(rules.rules[r]),
                               .noise = rules.rules[r].noise,
                               .covered = 0,
                               .unexplained = {},
                               .split = {}});
  }
  std::vector<Tally> tallies(rules.rules.size());
  std::map<std::string, DefaultDiagnosis> defaults;
  for (std::size_t i = 0; i < experiences.size(); ++i) {
    const Experience& experience = experiences[i];
    Binding binding;
    const Rule* rule = predictor.covering(experience.objects, experience.before, experience.action, &binding);
    if (!rule) {
      auto& entry = defaults[experience.action.predicate];
      entry.action = experience.action.predicate;
      ++entry.covered;
      if (experience.after != experience.before) entry.unexplained.push_back(name_of(experience, i));
      continue;
    }
    const auto index = static_cast<std::size_t>(rule - rules.rules.data());
    const bool explained = std::any_of(rule->outcomes.begin(), rule->outcomes.end(), [&](const RuleOutcome& outcome) {
      return apply_outcome(experience.before, ground(outcome.literals, binding)) == experience.after;
    });
    const auto derived = symbols::derive(rules.derived, experience.objects, experience.before);
    tallies[index].add(lifted_state(experience, derived, binding), explained);
    ++diagnosis.rules[index].covered;
    if (!explained) diagnosis.rules[index].unexplained.push_back(name_of(experience, i));
  }
  for (std::size_t r = 0; r < tallies.size(); ++r) diagnosis.rules[r].split = tallies[r].best();
  for (auto& [action, entry] : defaults) diagnosis.defaults.push_back(std::move(entry));
  return diagnosis;
}

Difference difference(const RuleSet& from, const RuleSet& to, double tolerance) {
  std::map<Head, const Rule*> old;
  for (const auto& rule : from.rules) old.emplace(head(rule), &rule);
  Difference result;
  for (const auto& rule : to.rules) {
    const auto at = old.find(head(rule));
    if (at == old.end()) {
      result.added.push_back(rule);
      continue;
    }
    if (!same_effects(*at->second, rule, tolerance)) result.changed.push_back(rule);
    old.erase(at);
  }
  for (const auto& rule : from.rules) {
    const auto at = old.find(head(rule));
    if (at != old.end() && at->second == &rule) result.removed.push_back(rule);
  }
  return result;
}

}  // namespace primo::rules
