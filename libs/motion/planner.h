// Local motion planners: from a primitive, a perceived scene and a start to the trajectory of least cost and its
// feedback gains. Cost (paper, eq. 1): Σ_{t=0}^{T−1} u_tᵀ H u_t + Σ_{t=1}^{T} Φ_tᵀ Φ_t with u_t = (q_{t+1} − 2 q_t +
// q_{t−1}) / τ², q_{−1} = q_0, H = τ · control_rate · W.
#pragma once

#include <string>
#include <vector>

#include "motion/plan.h"
#include "motion/trajectory_problem.h"
#include "robot/robot.h"

namespace primo::motion {

/// A solver of the optimal control problem, from a path q (n × T). A pure function; never throws, and gives nothing
/// that is not finite unless the status is bad_input.
using Solve = Solution (*)(const TrajectoryProblem& problem, StageCosts& stages, Eigen::MatrixXd q,
                           const SolverOptions& options);

struct PlannerEntry {
  std::string name;  ///< what a primitive's `solver` says
  std::string help;
  Solve solve;
};

/// All planners, by name.
const std::vector<PlannerEntry>& planners();

/// Plans with the solver and the start that the primitive names. A pure function that any number of threads may call;
/// never throws and never returns a value that is not finite. A request that cannot be planned (wrong sizes, unknown
/// target or task variable, a number that is not finite) gives status bad_input with the reason.
Plan plan(const robot::Robot& robot, const PlanRequest& request);

}  // namespace primo::motion
