// Planning with rules: reach a goal of ground literals, with the probability that the rules give to it. What happens as
// noise, and what a rule says nothing of, counts as failure, so that the probabilities are lower bounds.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "rules/prediction.h"

namespace primo::rules {

struct PlanProblem {
  std::vector<std::string> objects;
  symbols::State state;
  std::vector<symbols::Literal> goal;  ///< ground, may be negated
  int horizon = 10;                    ///< actions at most
};

struct PlanSettings {
  int simulations = 2000;    ///< UCT: descents from the start; a tenth of them from each state that may follow
  int samples = 4;           ///< UCT: different outcomes tried for a state and action (sparse sampling)
  double exploration = 0.7;  ///< UCT: the constant of UCB1, for rewards from 0 to 1
  int max_states = 200000;   ///< replanner: states looked at in one search
  std::uint64_t seed = 0;
};

struct PlanStep {
  symbols::Literal action;
  double p = 0;             ///< of the outcome that the plan counts on
  symbols::State expected;  ///< after it
};

struct Plan {
  std::vector<PlanStep> steps;  ///< when each action's expected outcome happens
  /// Predicted probability to reach the goal within the horizon when what really happened is planned from anew (UCT: by
  /// the actions of the search tree): a lower bound under the rules.
  double success = 0;
};

/// All ground actions that some rule covers in the state, sorted. At most `most` are tried.
std::vector<symbols::Literal> applicable_actions(const Predictor& predictor, const std::vector<std::string>& objects,
                                                 const symbols::State& state);

/// Sparse-sampling UCT (Kocsis and Szepesvári 2006; Kearns, Mansour and Ng 2002) over the rules' successors.
/// Errors: usage for a horizon below 1 or a goal with variables; failed when no way to the goal is found.
Result<Plan> plan_uct(const RuleSet& rules, const PlanProblem& problem, const PlanSettings& settings = {});

/// Breadth-first search for the most probable path over all outcomes as if one could choose them, planned again from
/// whatever happens. Errors as above.
Result<Plan> plan_replan(const RuleSet& rules, const PlanProblem& problem, const PlanSettings& settings = {});

/// The largest probability with which any policy reaches the goal within the horizon: value iteration over all states
/// that can be reached. For small problems. Error (failed): more than `max_states` of them.
Result<double> best_success(const RuleSet& rules, const PlanProblem& problem, int max_states = 200000);

}  // namespace primo::rules
