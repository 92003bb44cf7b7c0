// Local motion planners: from a primitive, a perceived scene and a start to the trajectory of least cost and its
// feedback gains. Cost (paper, eq. 1): Σ_{t=0}^{T−1} u_tᵀ H u_t + Σ_{t=1}^{T} Φ_tᵀ Φ_t with u_t = (q_{t+1} − 2 q_t +
// q_{t−1}) / τ², q_{−1} = q_0, H = τ · control_rate · W.
#pragma once

#include <string>
#include <vector>

#include "motion/plan.h"
#include "robot/robot.h"

namespace primo::motion {

/// Stateless: one planner serves any number of threads, and plan() is a pure function of its arguments.
class Planner {
 public:
  virtual ~Planner() = default;
  /// Never throws and never returns a value that is not finite. A request that cannot be planned (wrong sizes, unknown
  /// target or task variable, a number that is not finite) gives status bad_input with the reason.
  virtual Plan plan(const robot::Robot& robot, const PlanRequest& request) const = 0;
};

struct PlannerEntry {
  std::string name;  ///< what a primitive's `solver` says
  std::string help;
  const Planner* planner;
};

/// All planners, by name.
const std::vector<PlannerEntry>& planners();

/// Plans with the solver that the primitive names; an unknown one gives bad_input.
Plan plan(const robot::Robot& robot, const PlanRequest& request);

}  // namespace primo::motion
