// How an object that the hand holds comes down on its support: until when the two must stay apart, and how low its
// weight pulls it meanwhile.
#pragma once

#include <Eigen/Core>

#include "physics/verdict.h"
#include "robot/robot.h"

namespace primo::physics {

/// A motion that carries an object to its support, cut where the two may begin to touch.
struct SetDown {
  Eigen::MatrixXd approach;  ///< rad, the rows before, as loaded() has them: clear of the support
  Eigen::MatrixXd contact;   ///< rad, the rows after it, as planned; begins where the approach ends
};

/// Contact may begin where the object's foot, the point on which it is to stand, still moves sideways by no more than
/// contact_travel(): a support caught at its top goes along at most as far. Time plays no part. Row t of q is q_t, rad.
/// @pre the scenario is a place.
SetDown set_down(const robot::Robot& robot, const scene::Scenario& scenario, const JudgeSettings& settings,
                 const Eigen::MatrixXd& q);

/// m: pushed so far at its top, the support leans by the settings' place_tilt. On a table, which cannot lean, the held
/// object does: dragged so far at its foot.
double contact_travel(const scene::Scenario& scenario, const JudgeSettings& settings);

/// q (rows, rad) as the held object's weight bends it: drives make up for the robot's own weight and not for what it
/// holds, so each joint of the arm gives by the torque of m g at the object's centre over its kp. Fingers do not move.
Eigen::MatrixXd loaded(const robot::Robot& robot, const scene::Scenario& scenario, const Eigen::MatrixXd& q);

}  // namespace primo::physics
