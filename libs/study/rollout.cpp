#include "study/rollout.h"

#include <utility>

namespace primo::study {

motion::PlanRequest plan_request(const Rollout& rollout) {
  motion::PlanRequest request;
  request.scene = rollout.estimate;
  request.action = rollout.scenario.action;
  request.q_start = rollout.scenario.robot_start;
  request.primitive = rollout.primitive;
  if (const auto& held = rollout.scenario.held) request.held = motion::HeldObject{held->object, held->X_GO()};
  // Plain tracking of the reference is what the judge's execution does without gains; they cost a Riccati pass
  // otherwise.
  request.want_gains = rollout.mode == physics::Mode::execute;
  return request;
}

physics::JudgeRequest judge_request(const Rollout& rollout, const motion::Plan& plan) {
  PRIMO_CHECK(has_trajectory(plan), "a plan without a trajectory cannot be judged: " + plan.reason);
  physics::JudgeRequest request;
  request.scenario = rollout.scenario;
  request.q = plan.trajectory.q;
  request.dt = plan.trajectory.dt;
  request.planner_iterations = plan.iterations + plan.rejected;
  request.K = plan.gains.K;
  request.seed = rollout.judge_seed;
  request.mode = rollout.mode;
  request.settings = rollout.judge;
  return request;
}

bool has_trajectory(const motion::Plan& plan) {
  return plan.status != motion::PlanStatus::bad_input && plan.trajectory.q.size() > 0;
}

RolloutResult rollout_result(const motion::Plan& plan, physics::Verdict verdict) {
  RolloutResult result;
  result.plan_status = plan.status;
  result.plan_reason = plan.reason;
  result.iterations = plan.iterations + plan.rejected;
  result.plan_cost = plan.cost_final;
  result.verdict = std::move(verdict);
  return result;
}

RolloutResult rollout_without_plan(const motion::Plan& plan) {
  physics::Verdict verdict;
  verdict.outcome = physics::Outcome::bad_plan;
  verdict.reason = plan.reason;
  return rollout_result(plan, std::move(verdict));
}

}  // namespace primo::study
