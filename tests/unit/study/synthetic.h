// Rollouts with a known γ, for tests of the algorithms above them.
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "study/backend.h"

namespace primo::study::test {

/// A primitive with `n` open precisions.
inline motion::Primitive primitive(std::size_t n) {
  motion::Primitive p;
  p.name = "test";
  p.action = "grasp";
  for (std::size_t i = 0; i < n; ++i) {
    motion::Task task;
    task.name = "task_" + std::to_string(i);
    task.variable = "homing";
    task.rho = 1;
    p.tasks.push_back(task);
  }
  return p;
}

inline scene::Scenario scenario(const std::string& name, double x = 0.8) {
  scene::Scenario s;
  s.name = name;
  scene::Object cylinder;
  cylinder.name = "c1";
  cylinder.position.x() = x;
  s.objects = {cylinder};
  s.cameras = {scene::Camera{}};
  s.action = {"grasp", "c1"};
  return s;
}

inline scene::SceneEstimate estimate(const scene::Scenario& s) {
  scene::SceneEstimate e;
  e.scene = s.name;
  scene::ObjectEstimate object;
  object.name = "c1";
  object.X_WO = pose(s.objects[0].position);
  e.objects = {object};
  return e;
}

/// A grasp that succeeded, with nothing lost: what g(x̄) is greatest on.
inline RolloutResult perfect_grasp() {
  RolloutResult result;
  result.plan_status = motion::PlanStatus::converged_step;
  physics::Verdict& v = result.verdict;
  v.success = v.final_pose_success = v.path_clean = true;
  v.outcome = physics::Outcome::held;
  v.score = 1;
  v.survival = 1;
  v.clearance = 0.05;
  v.target_clearance = 0;
  v.limit_margin = 0.1;
  v.objects = {"c1", "table"};
  v.before = {{"cylinder", {"c1"}}, {"on", {"c1", "table"}}, {"table", {"table"}}};
  v.after = {{"cylinder", {"c1"}}, {"inhand", {"c1"}}, {"table", {"table"}}};
  return result;
}

inline std::vector<symbols::Literal> grasped() { return {{"inhand", {"X"}}, {"on", {"X", "Y"}, true}}; }

/// Succeeds when log10 ρ is within `radius` of an optimum that shifts a little with the scenario; graded outside.
inline RolloutResult bowl(const Rollout& rollout, double optimum = 3.0, double radius = 2.0) {
  RolloutResult result = perfect_grasp();
  double square = 0;
  for (const double x : rollout.primitive.log_rho()) square += (x - optimum) * (x - optimum);
  const double shift = (rollout.scenario.objects[0].position.x() - 0.8) * 10;
  const double distance = std::sqrt(square) + std::abs(shift);
  result.verdict.success = distance < radius;
  result.verdict.final_pose_success = distance < 1.5 * radius;
  result.verdict.score = 1 / (1 + distance);
  if (!result.verdict.success) {
    result.verdict.outcome = physics::Outcome::fell_in_jiggle;
    result.verdict.after = result.verdict.before;
  }
  return result;
}

/// Evaluates with a function, and counts.
class FunctionEvaluator : public Evaluator {
 public:
  explicit FunctionEvaluator(std::function<RolloutResult(const Rollout&)> function) : function_(std::move(function)) {}
  Status evaluate(std::span<const Rollout> rollouts,
                  const std::function<void(std::size_t, RolloutResult)>& on_result) override {
    for (std::size_t n = 0; n < rollouts.size(); ++n) {
      const std::size_t i = reverse ? rollouts.size() - 1 - n : n;
      if (fail_after >= 0 && calls >= fail_after) return Error{Code::unavailable, "stopped"};
      ++calls;
      if (on_rollout) on_rollout(rollouts[i]);
      on_result(i, function_(rollouts[i]));
    }
    return success();
  }
  std::function<void(const Rollout&)> on_rollout;
  bool reverse = false;  ///< answers come last first
  int fail_after = -1;   ///< rollouts before it stops
  int calls = 0;

 private:
  std::function<RolloutResult(const Rollout&)> function_;
};

}  // namespace primo::study::test
