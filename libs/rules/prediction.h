// What NID rules say about a state and an action.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/random.h"
#include "core/statistics.h"
#include "rules/grounding.h"
#include "rules/rule.h"

namespace primo::rules {

/// Variable → object.
using Binding = std::map<std::string, std::string>;

/// The one way to bind the rule's variables to distinct objects so that its action is `action` and its context holds in
/// `state` (with what is derived from it); empty when there is none or more than one.
std::optional<Binding> bind_rule(const Rule& rule, const std::vector<std::string>& objects, const symbols::State& state,
                                 const symbols::Literal& action, const std::vector<symbols::Definition>& derived = {});

/// The rule that alone covers (state, action); nullptr when none or several do: then the action's default rule holds.
const Rule* covering(const RuleSet& rules, const std::vector<std::string>& objects, const symbols::State& state,
                     const symbols::Literal& action);

/// The literals with their variables replaced. Variables that the binding lacks stay.
std::vector<symbols::Literal> ground(const std::vector<symbols::Literal>& literals, const Binding& binding);

/// Whether every ground literal holds in the state (negated ones: is absent).
bool holds(const std::vector<symbols::Literal>& ground_literals, const symbols::State& state);

/// The state after an outcome's ground literals: negated ones removed, the others added, all else as before.
symbols::State apply_outcome(const symbols::State& state, const std::vector<symbols::Literal>& ground_literals);

struct Successor {
  symbols::State state;
  double p = 0;
};
struct Prediction {
  const Rule* rule = nullptr;         ///< nullptr: the default rule
  std::vector<Successor> successors;  ///< different states, most probable first
  double noise = 1;                   ///< probability left to states that are not described
};
/// All successors with their probabilities.
Prediction predict(const RuleSet& rules, const std::vector<std::string>& objects, const symbols::State& state,
                   const symbols::Literal& action);

/// s′ drawn from the prediction; nothing: noise happened.
const symbols::State* sample(const Prediction& prediction, Random& random);

/// A rule set made ready for many predictions. The rules must outlive it.
class Predictor {
 public:
  explicit Predictor(const RuleSet& rules);

  Prediction predict(const std::vector<std::string>& objects, const symbols::State& state,
                     const symbols::Literal& action) const;
  /// The rule that alone covers (state, action), and its binding; nullptr when none or several do.
  const Rule* covering(const std::vector<std::string>& objects, const symbols::State& state,
                       const symbols::Literal& action, Binding* binding = nullptr) const;
  const RuleSet& rules() const { return *rules_; }

 private:
  struct Compiled {
    const Rule* rule;
    Pattern pattern;
    std::vector<std::string> variables;
  };
  const RuleSet* rules_;
  Vocabulary vocabulary_;
  std::vector<std::string> constants_;
  std::vector<Compiled> compiled_;
};

/// The outcome an action is for.
struct DesiredOutcome {
  Rule rule;                               ///< the rule it belongs to, projected on it (see project_to_desired)
  std::vector<symbols::Literal> literals;  ///< over the rule's variables
  Rate rate;                               ///< how often it happened in the training data the rule covers
};

/// Of the action's rule with most training examples that changes anything: the most probable outcome with at least one
/// literal. With `goal` (literals over the action's arguments X, Y, …), only outcomes that contain all of them are
/// looked at. Error (failed): no rule of this action changes anything (or reaches the goal).
Result<DesiredOutcome> desired_outcome(const RuleSet& rules, const std::string& action,
                                       const std::vector<symbols::Literal>& goal = {});

}  // namespace primo::rules
