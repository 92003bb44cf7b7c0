// Starts of local planners.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/result.h"
#include "motion/trajectory_problem.h"

namespace primo::motion {

struct Start {
  std::string name;
  Eigen::MatrixXd q;  ///< n × T
};

struct StartEntry {
  std::string name;  ///< what a primitive's `start` says
  std::string help;
};

/// All kinds of starts.
const std::vector<StartEntry>& starts();

/// The paths to start from under that name, at least one; of several the planner keeps the best outcome. Deterministic.
/// `last` has rows q_0 … q_T' of the last plan: it is stretched to this problem's steps and shifted to begin at
/// q_start. Error data: an unknown name, or start `last` without a last plan of these joints.
Result<std::vector<Start>> make_starts(const TrajectoryProblem& problem, StageCosts& stages, const std::string& name,
                                       const Eigen::MatrixXd& last);

/// The start q_0 at every step (n × T).
Eigen::MatrixXd rest_start(const TrajectoryProblem& problem);

/// Minimum-jerk motion from q_0 to q_goal, at rest at both ends: s(x) = 10 x³ − 15 x⁴ + 6 x⁵ (Flash and Hogan, 1985). n
/// × T.
Eigen::MatrixXd minimum_jerk(const TrajectoryProblem& problem, const Eigen::VectorXd& q_goal);

struct Reach {
  Eigen::VectorXd q;  ///< rad
  double cost = 0;    ///< infinite where it is not finite at the guess
};

/// Inverse kinematics by the same costs: minimises Φ_T(q)ᵀ Φ_T(q) plus the least control cost of any motion of this
/// duration from rest at q_0 that arrives at q, 3 / D³ · Σ_i H_i/τ (q_i − q_{0,i})², by Levenberg–Marquardt from
/// `q_guess`. Finite; the guess at worst.
Reach inverse_kinematics(const TrajectoryProblem& problem, StageCosts& stages, const Eigen::VectorXd& q_guess,
                         int max_iterations);

}  // namespace primo::motion
