// The two steps of a rollout: what a planner is asked, what a judge is asked about its plan, and what is kept of both
// answers. The services and the in-process workers use the same pieces.
#pragma once

#include "study/backend.h"

namespace primo::study {

/// What the planner is asked. q_start is the scenario's robot_start; a loaded study has it filled in.
motion::PlanRequest plan_request(const Rollout& rollout);

/// What the judge is asked about this plan. @pre the plan has a trajectory.
physics::JudgeRequest judge_request(const Rollout& rollout, const motion::Plan& plan);

/// Whether there is a trajectory to judge.
bool has_trajectory(const motion::Plan& plan);

/// What is kept. Without a trajectory the verdict is bad_plan, with the planner's reason.
RolloutResult rollout_result(const motion::Plan& plan, physics::Verdict verdict);
RolloutResult rollout_without_plan(const motion::Plan& plan);

}  // namespace primo::study
