// Starts of local planners.
#pragma once

#include <Eigen/Core>

#include "motion/trajectory_problem.h"

namespace primo::motion {

/// The start q_0 at every step (n × T).
Eigen::MatrixXd rest_start(const TrajectoryProblem& problem);

/// Minimum-jerk motion from q_0 to q_goal, at rest at both ends: s(x) = 10 x³ − 15 x⁴ + 6 x⁵ (Flash and Hogan, 1985). n
/// × T.
Eigen::MatrixXd minimum_jerk(const TrajectoryProblem& problem, const Eigen::VectorXd& q_goal);

/// Inverse kinematics by the same costs: minimises Φ_T(q)ᵀ Φ_T(q) plus the least control cost of any motion of this
/// duration from rest at q_0 that arrives at q, 3 / D³ · Σ_i H_i/τ (q_i − q_{0,i})², by Levenberg–Marquardt from q_0.
/// Finite; q_0 at worst.
Eigen::VectorXd inverse_kinematics(const TrajectoryProblem& problem, StageCosts& stages, int max_iterations);

}  // namespace primo::motion
