#include "rules/state_graph.h"

#include <algorithm>
#include <functional>
#include <set>

namespace primo::rules {
namespace {

using symbols::Literal;

constexpr std::size_t kMaxActions = 20000;  // ground actions tried in a state

/// All ways to put different objects for the action's different variables.
void instantiate(const Literal& action, const std::vector<std::string>& objects, std::set<Literal>& found) {
  std::vector<std::string> variables;
  for (const auto& term : action.arguments) {
    if (symbols::is_variable(term) && std::find(variables.begin(), variables.end(), term) == variables.end()) {
      variables.push_back(term);
    }
  }
  Binding binding;
  const std::function<void(std::size_t)> bind = [&](std::size_t v) {
    if (found.size() >= kMaxActions) return;
    if (v == variables.size()) {
      found.insert(ground({action}, binding).front());
      return;
    }
    for (const auto& object : objects) {
      const auto used = [&](const auto& entry) { return entry.second == object; };
      if (std::any_of(binding.begin(), binding.end(), used)) continue;
      binding[variables[v]] = object;
      bind(v + 1);
      binding.erase(variables[v]);
    }
  };
  bind(0);
}

}  // namespace

Status check(const PlanProblem& problem) {
  const auto usage = [](const std::string& message) { return Error{Code::usage, message}; };
  if (problem.horizon < 1) return usage("the horizon must be at least 1 action");
  if (problem.goal.empty()) return usage("the goal is empty; it is a list of literals such as on(a,b)");
  for (const auto& literal : problem.goal) {
    for (const auto& term : literal.arguments) {
      if (std::find(problem.objects.begin(), problem.objects.end(), term) == problem.objects.end()) {
        return usage("the goal " + literal.text() + " mentions " + term + ", which is not among the objects");
      }
    }
  }
  return success();
}

std::vector<Literal> applicable_actions(const Predictor& predictor, const std::vector<std::string>& objects,
                                        const symbols::State& state) {
  std::set<Literal> ground_actions;
  for (const auto& rule : predictor.rules().rules) instantiate(rule.action, objects, ground_actions);
  std::vector<Literal> actions;
  for (const auto& action : ground_actions) {
    if (predictor.covering(objects, state, action)) actions.push_back(action);
  }
  return actions;
}

StateGraph::StateGraph(const RuleSet& rules, const PlanProblem& problem)
    : predictor_(rules), objects_(problem.objects), wanted_(problem.goal), derived_(rules.derived) {
  number(problem.state);
}

int StateGraph::number(const symbols::State& state) {
  const auto [at, fresh] = numbers_.try_emplace(state, size());
  if (!fresh) return at->second;
  states_.push_back(&at->first);
  actions_.emplace_back();
  symbols::State all = state;
  all.merge(symbols::derive(derived_, objects_, state));
  goal_.push_back(holds(wanted_, all));
  return at->second;
}

const std::vector<StateGraph::Action>& StateGraph::actions(int state) {
  if (actions_[static_cast<std::size_t>(state)]) return *actions_[static_cast<std::size_t>(state)];
  std::vector<Action> found;
  for (const auto& literal : applicable_actions(predictor_, objects_, this->state(state))) {
    Action action{literal, {}};
    bool changes = false;
    for (const auto& successor : predictor_.predict(objects_, this->state(state), literal).successors) {
      if (!(successor.p > 0)) continue;
      action.outcomes.push_back({number(successor.state), successor.p});
      changes = changes || action.outcomes.back().state != state;
    }
    if (changes) found.push_back(std::move(action));
  }
  actions_[static_cast<std::size_t>(state)] = std::move(found);
  return *actions_[static_cast<std::size_t>(state)];
}

}  // namespace primo::rules
