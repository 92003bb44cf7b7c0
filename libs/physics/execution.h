// The whole motion in full physics: the arm tracks it with torques among all objects; what comes after depends on the
// action: a grasp closes, lifts and holds; a place opens the hand, retreats and waits for rest.
#pragma once

#include "physics/contact_log.h"
#include "physics/grasp_trial.h"
#include "physics/recording.h"
#include "physics/simulation.h"
#include "physics/verdict.h"
#include "robot/robot.h"
#include "symbols/snapshot.h"

namespace primo::physics {

struct Execution {
  TrialResult trial;             ///< X_PO: of the target at the end; survival: fraction of lifting and holding
  symbols::WorldSnapshot world;  ///< at the end
  double tracking_error = 0;     ///< rad, largest of an arm joint along the motion
  ContactLog contacts;           ///< also of a simulation that diverged, until then
};

/// The arm's torque is M(q)(q̈* + K δ) + bias + kp (q* − q) + kd (q̇* − q̇), limited; q* is the cubic through the plan's
/// rows, δ = (q − q*, q̇ − q̇*), K the request's feedback gains or none. Fingers follow the plan by their servos; those
/// of a hand that holds something press on it throughout.
/// What happens is also written into `recording`, where there is one.
/// @pre the request is valid (see Judge). Error: the scene cannot be assembled.
Result<Execution> execute(const robot::Robot& robot, const JudgeRequest& request, const std::string& target,
                          double position_error, Recording* recording = nullptr);

/// How an execution ended.
Execution finish(const Simulation& simulation, Execution execution, Outcome outcome, const std::string& reason,
                 double score);

/// After the motion of a grasp: closes, lifts the grasp frame by 0.1 m or as far as the arm can, holds
/// (docs/decisions/0203).
Execution close_and_lift(const robot::Robot& robot, Simulation& simulation, Execution execution,
                         const JudgeRequest& request, const std::string& target, double position_error);

/// Before the motion of a place: closes the fingers on the object where the scenario has it. False: diverged.
bool grip_held(Simulation& simulation, const JudgeRequest& request);
/// After the motion of a place, whose trial has X_PO as it was before the motion: opens, retreats along the approach,
/// waits for rest.
Execution open_and_retreat(const robot::Robot& robot, Simulation& simulation, Execution execution,
                           const JudgeRequest& request);

}  // namespace primo::physics
