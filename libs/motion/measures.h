// What a planned path is like beside its cost.
#pragma once

#include "motion/plan.h"
#include "robot/robot.h"

namespace primo::motion {

struct Measures {
  double min_distance =
      0;  ///< m, of any moving link to the obstacles and the table as perceived, at the steps; at most 10
  double min_limit_margin = 0;  ///< rad, to the nearest joint limit
  double path_length = 0;       ///< rad, Σ ‖q_t − q_{t−1}‖
};

/// Zeros when the plan has no trajectory.
Measures measure(const robot::Robot& robot, const PlanRequest& request, const Plan& plan);

}  // namespace primo::motion
