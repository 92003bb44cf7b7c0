// Hands whose links close loops (equalities <connect> and <weld>, as four-bar grippers have them): where the joints of
// a loop are for every position of the listed joint that leads it.
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/result.h"
#include "robot/couplings.h"
#include "robot/robot.h"

namespace primo::robot {

/// What is known of the robot file's joints, by index of q. The range of one that leads a loop is narrowed to the part
/// about its home in which the loop closes.
struct ListedJoints {
  int arm = 0;        ///< how many of them are the arm's
  int tool_body = 0;  ///< of the model: what the last arm joint moves
  const std::vector<std::string>& names;
  const Eigen::VectorXd& home;
  Eigen::VectorXd &lower, &upper;
};

/// Gives the joints in loops, as far as their drives (by MJCF joint) are not known, a curve over the listed joint that
/// leads them: where the hand comes to rest with that joint held, without gravity and contact, under its springs, its
/// limits and all equalities (settling.h). A loop that none leads stays where it comes to rest. Returns
/// the active loops; none of them costs nothing.
/// Error (Code::config), put after `where`: a loop through the arm or the world; one that more than one listed joint
/// leads; one that stays open by more than 1 mm (1 mrad) at the hand's home, or does not come to rest; a joint that
/// neither loop, spring nor limit holds.
Result<std::vector<Loop>> close_loops(const mjModel& model, const std::string& where, const ListedJoints& listed,
                                      std::vector<Drive>& drives);

}  // namespace primo::robot
