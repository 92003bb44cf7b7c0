// Objects in the hand, by the robot's geometry alone.
#pragma once

#include "core/result.h"
#include "robot/robot.h"
#include "scene/scenario.h"

namespace primo::scene {

/// Where the hand has what it holds: X_WO = X_WG(robot_start) X_GO. @pre the scenario is valid, holds something and
/// robot_start has as many joints as the robot.
Pose held_pose(const Scenario& scenario, const robot::Robot& robot);
/// The same where the robot is at q. @pre something is held
Pose held_pose(const Scenario& scenario, const robot::Robot& robot, const Eigen::VectorXd& q);

/// q with the fingers as at robot_start: those that hold something stay as they are. Where robot_start does not say,
/// q's.
Eigen::VectorXd with_held_fingers(const Scenario& scenario, const robot::Robot& robot, Eigen::VectorXd q);

inline constexpr double kHeldGap = 0.005;    ///< m, at most this far from two parts of the hand that oppose each other
inline constexpr double kHeldDepth = 0.006;  ///< m, and no deeper in any part

/// Whether a held object really is in the hand: the pose among the scenario's objects is held_pose() within 1 mm and
/// 0.01 rad, and it lies between two parts of the hand whose surfaces face each other across it. Nothing held is good.
/// Error (config): what is wrong, in mm, and what would be right. @pre as held_pose().
Status check_held(const Scenario& scenario, const robot::Robot& robot);

}  // namespace primo::scene
