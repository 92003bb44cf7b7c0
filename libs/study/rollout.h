// The two steps of a rollout: what a planner is asked, what a judge is asked about its plan, and what is kept of both
// answers. The services and the in-process workers use the same pieces.
#pragma once

#include "study/backend.h"

namespace primo::study {

/// The pose after it has been sent as a position and a unit quaternion.
Pose sent(const Pose& X);

/// A pose next to X (within 1e-7 rad) that can be told from its neighbours after it has been sent any number of times,
/// although each time rounds its last bits: settled(sent(X)) == settled(X). Who keeps or forwards a scene settles its
/// poses, so that a study does not depend on how often it went through a message.
Pose settled(const Pose& X);
void settle(scene::SceneEstimate& estimate);

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
