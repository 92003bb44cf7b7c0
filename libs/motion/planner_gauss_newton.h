// The fast engine: Levenberg–Marquardt on the banded Gauss–Newton system over q_1 … q_T, then one Riccati pass for the
// gains.
#pragma once

#include "motion/planner.h"

namespace primo::motion {

class GaussNewtonPlanner final : public Planner {
 public:
  Plan plan(const robot::Robot& robot, const PlanRequest& request) const override;
};

}  // namespace primo::motion
