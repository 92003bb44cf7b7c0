#include "rules/plan.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <queue>

#include "rules/state_graph.h"

namespace primo::rules {
namespace {

constexpr int kMaxBranches = 400000;  // of (state, steps left) in the evaluation of a policy

Error not_found() {
  return {Code::failed,
          "no way to the goal was found within the horizon; more actions, more simulations or other rules are needed"};
}

/// The most probable path to a goal when outcomes could be chosen: Dijkstra over −ln p, at most `left` actions.
class Replanner {
 public:
  Replanner(StateGraph& graph, int max_states) : graph_(graph), max_states_(max_states) {}

  /// The first action of the path, as an index; −1: there is none.
  int choose(int state, int left) {
    const auto [at, fresh] = chosen_.try_emplace({state, left}, -1);
    if (fresh) at->second = search(state, left);
    return at->second;
  }

 private:
  struct Open {
    double cost;
    int depth, state, first;
    bool operator>(const Open& other) const {
      return std::tie(cost, depth, state, first) > std::tie(other.cost, other.depth, other.state, other.first);
    }
  };

  int search(int from, int left) {
    std::priority_queue<Open, std::vector<Open>, std::greater<>> open;
    std::map<std::pair<int, int>, bool> closed;  // (state, depth)
    std::map<int, int> shallowest;               // a path that is longer and no likelier is of no use
    open.push({0, 0, from, -1});
    for (int looked_at = 0; !open.empty() && looked_at < max_states_; ++looked_at) {
      const Open next = open.top();
      open.pop();
      if (graph_.is_goal(next.state)) return next.first;
      const auto [known, fresh] = shallowest.try_emplace(next.state, next.depth);
      if (!fresh && known->second <= next.depth) continue;
      known->second = next.depth;
      if (next.depth == left) continue;
      const auto& actions = graph_.actions(next.state);
      for (std::size_t a = 0; a < actions.size(); ++a) {
        for (const auto& outcome : actions[a].outcomes) {
          const int first = next.depth == 0 ? static_cast<int>(a) : next.first;
          open.push({next.cost - std::log(outcome.p), next.depth + 1, outcome.state, first});
        }
      }
    }
    return -1;
  }

  StateGraph& graph_;
  int max_states_;
  std::map<std::pair<int, int>, int> chosen_;
};

/// UCT with as many trees as steps: nodes are (state, steps left), shared between paths.
class Uct {
 public:
  Uct(StateGraph& graph, const PlanSettings& settings, int horizon)
      : graph_(graph), settings_(settings), horizon_(horizon) {}

  /// Where the tree is thin, some more descents from the state itself; a tenth of those from the root.
  int choose(int state, int left) {
    Node& root = node(state, left);
    const int wanted = left == horizon_ ? settings_.simulations : 1 + settings_.simulations / 10;
    while (root.visits < wanted) descend(state, left);
    int best = -1;
    double value = 0;
    for (std::size_t a = 0; a < root.actions.size(); ++a) {
      const auto& action = root.actions[a];
      if (action.visits > 0 && action.mean() > value) {
        value = action.mean();
        best = static_cast<int>(a);
      }
    }
    return best;
  }

 private:
  struct Tried {
    int visits = 0;
    double sum = 0;
    std::vector<int> drawn;  // outcomes sampled so far, up to settings.samples; noise is −1
    double mean() const { return visits ? sum / visits : 0; }
  };
  struct Node {
    int visits = 0;
    std::vector<Tried> actions;
  };

  Node& node(int state, int left) {
    const auto [at, fresh] = nodes_.try_emplace({state, left});
    if (fresh) at->second.actions.resize(graph_.actions(state).size());
    return at->second;
  }

  double descend(int state, int left) {
    if (graph_.is_goal(state)) return 1;
    if (left == 0) return 0;
    Node& at = node(state, left);
    ++at.visits;
    if (at.actions.empty()) return 0;
    const std::size_t a = upper_confidence(at);
    Tried& tried = at.actions[a];
    const int next = draw(graph_.actions(state)[a], tried, state, left);
    // Below a new node actions are drawn at random.
    const double value = next < 0 ? 0 : tried.visits == 0 ? roll_out(next, left - 1) : descend(next, left - 1);
    ++tried.visits;
    tried.sum += value;
    return value;
  }

  std::size_t upper_confidence(const Node& node) const {
    std::size_t best = 0;
    double highest = -1;
    for (std::size_t a = 0; a < node.actions.size(); ++a) {
      const auto& action = node.actions[a];
      if (action.visits == 0) return a;
      const double bound =
          action.mean() + settings_.exploration * std::sqrt(std::log(node.visits) / static_cast<double>(action.visits));
      if (bound > highest) {
        highest = bound;
        best = a;
      }
    }
    return best;
  }

  /// Sparse sampling: the first visits draw outcomes, the later ones draw among those.
  int draw(const StateGraph::Action& action, Tried& tried, int state, int left) {
    const auto samples = static_cast<std::size_t>(settings_.samples);
    Random random = stream("outcome", state, left);
    if (tried.drawn.size() >= samples && action.outcomes.size() > samples) {
      return tried.drawn[random.below(tried.drawn.size())];
    }
    double u = random.uniform();
    int next = -1;
    for (const auto& outcome : action.outcomes) {
      if (u < outcome.p) {
        next = outcome.state;
        break;
      }
      u -= outcome.p;
    }
    if (tried.drawn.size() < samples) tried.drawn.push_back(next);
    return next;
  }

  double roll_out(int state, int left) {
    Random random = stream("roll-out", state, left);
    for (; left > 0 && !graph_.is_goal(state); --left) {
      const auto& actions = graph_.actions(state);
      if (actions.empty()) return 0;
      double u = random.uniform();
      int next = -1;
      for (const auto& outcome : actions[random.below(actions.size())].outcomes) {
        if (u < outcome.p) {
          next = outcome.state;
          break;
        }
        u -= outcome.p;
      }
      if (next < 0) return 0;
      state = next;
    }
    return graph_.is_goal(state) ? 1 : 0;
  }

  Random stream(const char* purpose, int state, int left) {
    return {settings_.seed, purpose, {static_cast<std::uint64_t>(state), static_cast<std::uint64_t>(left), ++drawn_}};
  }

  StateGraph& graph_;
  PlanSettings settings_;
  int horizon_;
  std::map<std::pair<int, int>, Node> nodes_;
  std::uint64_t drawn_ = 0;
};

using Policy = std::function<int(int state, int left)>;

/// The probability that the policy reaches the goal: exact, each (state, steps left) once. Where there are too many of
/// them the rest counts as failure.
class Evaluation {
 public:
  Evaluation(StateGraph& graph, const Policy& policy) : graph_(graph), policy_(policy) {}

  double operator()(int state, int left) {
    if (graph_.is_goal(state)) return 1;
    if (left == 0) return 0;
    const auto [at, fresh] = values_.try_emplace({state, left}, 0.0);
    if (!fresh || static_cast<int>(values_.size()) > kMaxBranches) return at->second;
    const int choice = policy_(state, left);
    if (choice < 0) return 0;
    // By value: looking further may move the actions.
    const auto outcomes = graph_.actions(state)[static_cast<std::size_t>(choice)].outcomes;
    double value = 0;
    for (const auto& outcome : outcomes) value += outcome.p * (*this)(outcome.state, left - 1);
    return values_[{state, left}] = value;
  }

 private:
  StateGraph& graph_;
  const Policy& policy_;
  std::map<std::pair<int, int>, double> values_;
};

/// The path on which each action has that of its outcomes which is best for the goal.
Result<Plan> follow(StateGraph& graph, const PlanProblem& problem, const Policy& policy) {
  Evaluation value(graph, policy);
  Plan plan;
  plan.success = value(graph.root(), problem.horizon);
  if (!(plan.success > 0)) return not_found();
  int state = graph.root();
  for (int left = problem.horizon; left > 0 && !graph.is_goal(state); --left) {
    const auto action = graph.actions(state)[static_cast<std::size_t>(policy(state, left))];
    const auto* expected = &action.outcomes.front();
    double best = -1;
    for (const auto& outcome : action.outcomes) {
      const double share = outcome.p * value(outcome.state, left - 1);
      // Waiting for the same state again is no step of a plan where there is another way.
      if (outcome.state != state && share > best) {
        best = share;
        expected = &outcome;
      }
    }
    plan.steps.push_back({action.action, expected->p, graph.state(expected->state)});
    state = expected->state;
  }
  return plan;
}

}  // namespace

Result<Plan> plan_uct(const RuleSet& rules, const PlanProblem& problem, const PlanSettings& settings) {
  PRIMO_TRY(check(problem));
  if (settings.simulations < 1 || settings.samples < 1) {
    return Error{Code::usage, "simulations and samples must be at least 1"};
  }
  StateGraph graph(rules, problem);
  Uct uct(graph, settings, problem.horizon);
  return follow(graph, problem, [&](int state, int left) { return uct.choose(state, left); });
}

Result<Plan> plan_replan(const RuleSet& rules, const PlanProblem& problem, const PlanSettings& settings) {
  PRIMO_TRY(check(problem));
  StateGraph graph(rules, problem);
  Replanner replanner(graph, settings.max_states);
  return follow(graph, problem, [&](int state, int left) { return replanner.choose(state, left); });
}

Result<double> best_success(const RuleSet& rules, const PlanProblem& problem, int max_states) {
  PRIMO_TRY(check(problem));
  StateGraph graph(rules, problem);
  std::vector<int> depth{0};
  for (int s = 0; s < graph.size(); ++s) {
    if (graph.size() > max_states) {
      return Error{Code::failed, "more than " + std::to_string(max_states) + " states can be reached"};
    }
    if (depth[static_cast<std::size_t>(s)] < problem.horizon && !graph.is_goal(s)) graph.actions(s);
    depth.resize(static_cast<std::size_t>(graph.size()), depth[static_cast<std::size_t>(s)] + 1);
  }
  const auto states = static_cast<std::size_t>(graph.size());
  std::vector<double> value(states);
  for (std::size_t s = 0; s < states; ++s) value[s] = graph.is_goal(static_cast<int>(s));
  for (int left = 1; left <= problem.horizon; ++left) {
    std::vector<double> next = value;
    for (std::size_t s = 0; s < states; ++s) {
      if (graph.is_goal(static_cast<int>(s)) || depth[s] >= problem.horizon) continue;
      for (const auto& action : graph.actions(static_cast<int>(s))) {
        double sum = 0;
        for (const auto& outcome : action.outcomes) sum += outcome.p * value[static_cast<std::size_t>(outcome.state)];
        next[s] = std::max(next[s], sum);
      }
    }
    value = std::move(next);
  }
  return value[0];
}

}  // namespace primo::rules
