#include "rules/prediction.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"
#include "rules/grounding.h"

namespace primo::rules {
namespace {

using symbols::is_variable;
using symbols::Literal;
using symbols::State;

/// A rule's terms as the integers that Pattern binds.
class Terms {
 public:
  explicit Terms(std::vector<std::string>& constants) : constants_(constants) {}

  std::int16_t index(const std::string& term) {
    const bool variable = is_variable(term);
    auto& names = variable ? variables_ : constants_;
    const auto at = std::find(names.begin(), names.end(), term) - names.begin();
    if (at == static_cast<std::ptrdiff_t>(names.size())) names.push_back(term);
    return variable ? static_cast<std::int16_t>(at) : constant(static_cast<int>(at));
  }
  const std::vector<std::string>& variables() const { return variables_; }

 private:
  std::vector<std::string>& constants_;
  std::vector<std::string> variables_;
};

bool same_action(const Literal& a, const Literal& b) {
  return a.predicate == b.predicate && a.arguments.size() == b.arguments.size();
}

/// The objects with those that only occur in literals, sorted after them.
std::vector<std::string> all_objects(const std::vector<std::string>& objects, const State& state,
                                     const Literal& action) {
  std::vector<std::string> all = objects;
  const auto add = [&](const Literal& literal) {
    for (const auto& argument : literal.arguments) {
      if (std::find(all.begin(), all.end(), argument) == all.end()) all.push_back(argument);
    }
  };
  add(action);
  for (const auto& literal : state) add(literal);
  return all;
}

}  // namespace

Predictor::Predictor(const RuleSet& rules) : rules_(&rules) {
  for (const auto& rule : rules.rules) {
    Terms terms(constants_);
    std::vector<std::int16_t> action;
    for (const auto& argument : rule.action.arguments) action.push_back(terms.index(argument));
    std::vector<LiftedLiteral> context;
    for (const auto& literal : rule.context) {
      PRIMO_CHECK(literal.arguments.size() <= symbols::kMaxArity, "too many arguments: " + literal.text());
      LiftedLiteral lifted{.relation = literal.relation, .negated = literal.negated, .value = literal.value};
      lifted.atom.fill(-1);
      lifted.atom[0] = vocabulary_.intern(literal.predicate, literal.arguments.size());
      for (std::size_t i = 0; i < literal.arguments.size(); ++i) lifted.atom[i + 1] = terms.index(literal.arguments[i]);
      context.push_back(lifted);
    }
    compiled_.push_back(
        {&rule, Pattern(action, static_cast<int>(terms.variables().size()), context), terms.variables()});
  }
}

const Rule* Predictor::covering(const std::vector<std::string>& objects, const State& state, const Literal& action,
                                Binding* binding) const {
  const Compiled* found = nullptr;
  std::vector<std::int16_t> bound;
  std::optional<Scene> scene;
  std::vector<std::string> all;
  for (const auto& compiled : compiled_) {
    if (!same_action(compiled.rule->action, action)) continue;
    if (!scene) {
      all = all_objects(objects, state, action);
      Vocabulary vocabulary = vocabulary_;
      const State derived = symbols::derive(rules_->derived, objects, state);
      scene = make_scene(vocabulary, all, state, action, state, constants_, derived);
    }
    std::vector<std::int16_t> trial;
    if (compiled.pattern.count_bindings(*scene, trial) != 1) continue;
    if (found) return nullptr;
    found = &compiled;
    bound = std::move(trial);
  }
  if (!found) return nullptr;
  for (std::size_t v = 0; binding && v < bound.size(); ++v) {
    (*binding)[found->variables[v]] = all[static_cast<std::size_t>(bound[v])];
  }
  return found->rule;
}

std::optional<Binding> bind_rule(const Rule& rule, const std::vector<std::string>& objects, const State& state,
                                 const Literal& action, const std::vector<symbols::Definition>& derived) {
  RuleSet alone;
  alone.rules = {rule};
  alone.derived = derived;
  Binding binding;
  if (!Predictor(alone).covering(objects, state, action, &binding)) return std::nullopt;
  return binding;
}

const Rule* covering(const RuleSet& rules, const std::vector<std::string>& objects, const State& state,
                     const Literal& action) {
  return Predictor(rules).covering(objects, state, action);
}

std::vector<Literal> ground(const std::vector<Literal>& literals, const Binding& binding) {
  std::vector<Literal> grounded = literals;
  for (auto& literal : grounded) {
    for (auto& argument : literal.arguments) {
      if (const auto at = binding.find(argument); at != binding.end()) argument = at->second;
    }
  }
  return grounded;
}

bool holds(const std::vector<Literal>& ground_literals, const State& state) {
  return std::all_of(ground_literals.begin(), ground_literals.end(),
                     [&](const Literal& literal) { return symbols::holds(literal, state); });
}

State apply_outcome(const State& state, const std::vector<Literal>& ground_literals) {
  State after = state;
  for (const auto& literal : ground_literals) {
    if (literal.negated) symbols::make_true(literal, after);
  }
  for (const auto& literal : ground_literals) {
    if (!literal.negated) symbols::make_true(literal, after);
  }
  return after;
}

Prediction Predictor::predict(const std::vector<std::string>& objects, const State& state,
                              const Literal& action) const {
  Prediction prediction;
  Binding binding;
  prediction.rule = covering(objects, state, action, &binding);
  std::map<State, double> successors;
  if (prediction.rule) {
    for (const auto& outcome : prediction.rule->outcomes) {
      successors[apply_outcome(state, ground(outcome.literals, binding))] += outcome.p;
    }
    prediction.noise = prediction.rule->noise;
  } else if (const auto at = rules_->defaults.find(action.predicate); at != rules_->defaults.end()) {
    if (at->second.no_change > 0) successors[state] = at->second.no_change;
    prediction.noise = at->second.noise;
  }
  for (auto& [successor, p] : successors) prediction.successors.push_back({successor, p});
  std::stable_sort(prediction.successors.begin(), prediction.successors.end(),
                   [](const Successor& a, const Successor& b) { return a.p > b.p; });
  return prediction;
}

Prediction predict(const RuleSet& rules, const std::vector<std::string>& objects, const State& state,
                   const Literal& action) {
  return Predictor(rules).predict(objects, state, action);
}

const State* sample(const Prediction& prediction, Random& random) {
  double u = random.uniform();
  for (const auto& successor : prediction.successors) {
    if (u < successor.p) return &successor.state;
    u -= successor.p;
  }
  return nullptr;
}

Result<DesiredOutcome> desired_outcome(const RuleSet& rules, const std::string& action,
                                       const std::vector<Literal>& goal) {
  const Rule* best = nullptr;
  Rule best_kept;
  bool known = false;
  for (const auto& rule : rules.rules) {
    if (rule.action.predicate != action) continue;
    known = true;
    // Outcomes without the goal cannot be desired: drop them here, keep their examples in the count.
    Rule kept = rule;
    kept.examples = rule.trials();
    Binding names;  // the goal speaks of X, Y, …; the rule may name its arguments otherwise
    const char* const kNames[] = {"X", "Y", "Z", "U", "V", "W"};
    for (std::size_t i = 0; i < rule.action.arguments.size() && i < std::size(kNames); ++i) {
      names[kNames[i]] = rule.action.arguments[i];
    }
    const auto wanted = ground(goal, names);
    std::erase_if(kept.outcomes, [&](const RuleOutcome& outcome) {
      return !std::all_of(wanted.begin(), wanted.end(), [&](const Literal& literal) {
        return std::find(outcome.literals.begin(), outcome.literals.end(), literal) != outcome.literals.end();
      });
    });
    if (desired_index(kept) < 0) continue;
    if (best && kept.examples <= best_kept.examples) continue;
    best = &rule;
    best_kept = std::move(kept);
  }
  if (!best) {
    std::string reached;
    for (const auto& literal : goal) reached += (reached.empty() ? "" : ", ") + literal.text();
    if (!known) return Error{Code::failed, "no rule for the action " + action + "; more experiences of it are needed"};
    return Error{Code::failed, "no rule for " + action + " has an outcome that " +
                                   (goal.empty() ? "changes anything" : "contains " + reached) +
                                   "; experiences in which it happens are needed"};
  }
  DesiredOutcome desired;
  desired.rule = project_to_desired(best_kept);
  desired.literals = desired.rule.outcomes.front().literals;
  desired.rate = {desired.rule.outcomes.front().count, desired.rule.trials()};
  return desired;
}

}  // namespace primo::rules
