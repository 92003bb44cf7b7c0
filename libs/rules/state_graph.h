// The states that a rule set reaches, numbered; successors are computed once.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "rules/plan.h"

namespace primo::rules {

class StateGraph {
 public:
  struct Outcome {
    int state = 0;
    double p = 0;
  };
  struct Action {
    symbols::Literal action;
    std::vector<Outcome> outcomes;  ///< most probable first; the rest to 1 is noise
  };

  StateGraph(const RuleSet& rules, const PlanProblem& problem);

  int root() const { return 0; }
  int size() const { return static_cast<int>(states_.size()); }
  bool is_goal(int state) const { return goal_[static_cast<std::size_t>(state)]; }
  const symbols::State& state(int state) const { return *states_[static_cast<std::size_t>(state)]; }
  /// What can be done there: the actions that a rule covers and that change anything.
  const std::vector<Action>& actions(int state);

 private:
  int number(const symbols::State& state);

  Predictor predictor_;
  std::vector<std::string> objects_;
  std::vector<symbols::Literal> wanted_;
  std::vector<symbols::Definition> derived_;
  std::map<symbols::State, int> numbers_;
  std::vector<const symbols::State*> states_;
  std::vector<bool> goal_;
  std::vector<std::optional<std::vector<Action>>> actions_;
};

/// Error (usage): the horizon is below 1, the goal is empty or has variables or unknown objects.
Status check(const PlanProblem& problem);

}  // namespace primo::rules
