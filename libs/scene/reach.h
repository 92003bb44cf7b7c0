// Whether a robot can try a scenario's action at all.
#pragma once

#include "core/result.h"
#include "robot/robot.h"
#include "scene/scenario.h"

namespace primo::scene {

/// What can be said without solving the kinematics: distance of the arm's first joint from its grasp frame.
struct Reach {
  Eigen::Vector3d shoulder_W{0, 0, 0};  ///< where the first arm joint's axis is anchored, m
  double longest = 0;                   ///< m, the arm stretched out: no grasp frame is farther than this
};
Reach reach(const robot::Robot& robot);

/// Refuses a robot_start of the wrong length or out of limits, and action objects farther from the shoulder than 0.95
/// of the stretched arm or nearer than 0.25 of it, and held objects that are not in the hand. Says which object, how
/// far it is and what would be right.
Status check_robot(const Scenario& scenario, const robot::Robot& robot);

}  // namespace primo::scene
