// What the study's algorithms need done, without saying how: by services over DDS, or in this process.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/statistics.h"
#include "motion/plan.h"
#include "motion/primitive.h"
#include "optim/optimizer.h"
#include "physics/verdict.h"
#include "rules/rule.h"
#include "scene/estimate.h"
#include "scene/scenario.h"

namespace primo::study {

/// One primitive tried once in one scenario: planned in the perceived scene, judged in the true one. Its result is a
/// pure function of its content.
struct Rollout {
  scene::Scenario scenario;
  scene::SceneEstimate estimate;
  motion::Primitive primitive;
  std::uint64_t judge_seed = 0;
  physics::Mode mode = physics::Mode::final_pose;
  physics::JudgeSettings judge;
};

struct RolloutResult {
  motion::PlanStatus plan_status = motion::PlanStatus::bad_input;
  std::string plan_reason;
  int iterations = 0;  ///< accepted + rejected
  double plan_cost = 0;
  physics::Verdict verdict;
};

/// Evaluates rollouts. Results come in any order, each index once, from the calling thread; returns when all have come.
/// Error: stopped (unavailable) or a rollout that no worker can do.
class Evaluator {
 public:
  virtual ~Evaluator() = default;
  virtual Status evaluate(std::span<const Rollout> rollouts,
                          const std::function<void(std::size_t index, RolloutResult result)>& on_result) = 0;
};

/// What to optimize: P on K training scenarios against a desired outcome.
struct OptimizeGoal {
  std::string study;  ///< study id
  std::string part;   ///< of the study
  int round = 0;
  std::string directory;                   ///< of the study, where the journal is
  motion::Primitive primitive;             ///< ρ of P; the open entries are optimized
  std::vector<scene::Scenario> scenarios;  ///< training set S_1…K; under the robust protocol the pool, then `held_out`
  std::vector<scene::SceneEstimate> estimates;
  int drawn = 0;     ///< how many scenarios of the pool each generation draws, the same for all its candidates; 0: all
  int held_out = 0;  ///< the last so many scenarios are kept for the final choice; 0: it is made on the training set
  std::vector<symbols::Literal>
      desired;  ///< ground or lifted over the action's arguments (X, Y, …): the rule's desired outcome
  optim::OptimizerSettings optimizer;
  std::vector<std::string>
      algorithms;  ///< run one after the other with the same budget, e.g. cma, monte_carlo; the best wins
  int restarts = 1;
  physics::JudgeSettings judge;
  std::uint64_t seed = 0;
  std::string settings;  ///< OptimizationSettings (optimization.h) as YAML; empty: the defaults
};

struct OptimizeResult {
  std::string study;
  int round = 0;
  motion::Primitive primitive;  ///< P*
  double gamma = 0;             ///< γ(P*) in the scenarios of the choice, with seeds that the optimizer has not seen
  Rate success;                 ///< over these scenarios and seeds: strict, and the desired outcome holds
  int evaluations = 0;          ///< of γ, over all algorithms and restarts
};

/// Everything the conductor asks of others.
class Workers : public Evaluator {
 public:
  /// Camera, then perception, for each scenario; in order.
  virtual Result<std::vector<scene::SceneEstimate>> observe(std::span<const scene::Scenario> scenarios) = 0;
  /// Rules of all these experiences, each with a unique id; `batch` names them and ends in a digest of them, so that
  /// another set has another name.
  virtual Result<rules::RuleSet> learn(const std::string& batch,
                                       const std::vector<symbols::Experience>& experiences) = 0;
  virtual Result<OptimizeResult> optimize(const OptimizeGoal& goal) = 0;
};

}  // namespace primo::study
