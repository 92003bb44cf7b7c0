// The whole motion in full physics: the arm tracks it with torques among all objects, then the hand closes, lifts and
// holds.
#pragma once

#include "physics/contact_log.h"
#include "physics/grasp_trial.h"
#include "physics/recording.h"
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
/// rows, δ = (q − q*, q̇ − q̇*), K the request's feedback gains or none. Fingers follow the plan by their servos. Then:
/// close, lift the grasp frame by 0.1 m or as far as the arm can, hold (docs/decisions/0203).
/// What happens is also written into `recording`, where there is one.
/// @pre the request is valid (see Judge). Error: the scene cannot be assembled.
Result<Execution> execute(const robot::Robot& robot, const JudgeRequest& request, const std::string& target,
                          double position_error, Recording* recording = nullptr);

}  // namespace primo::physics
