// A path q_1 … q_T with its cost and the quadratic model of that cost: what every solver of trajectory_problem.h
// computes alike.
//   ½ cost(q + Δ) ≈ ½ cost(q) + gᵀΔ + ½ Δᵀ(R + D)Δ,
// g = ½ ∂cost/∂q, R = JᵀJ of the tasks (Gauss–Newton), D the exact Hessian of half the control cost. Entries are
// ordered by step, then by joint: entry (t − 1) n + i belongs to q_t[i].
#pragma once

#include <Eigen/Core>
#include <vector>

#include "motion/banded.h"
#include "motion/trajectory_problem.h"

namespace primo::motion {

struct PathModel {
  Eigen::MatrixXd q;  ///< n × T
  double cost = 0, cost_control = 0;
  std::vector<StageModel> models;  ///< T
};

/// Fills the path's cost and models. False, and not filled to the end, as soon as the cost is not below `limit` or a
/// gradient is not finite.
bool evaluate(const TrajectoryProblem& problem, StageCosts& stages, PathModel& path, double limit);

/// g, n T entries.
Eigen::VectorXd half_gradient(const TrajectoryProblem& problem, const PathModel& path);

/// H/τ⁴ by joints: what one entry of D is made of.
Eigen::VectorXd control_curvature(const TrajectoryProblem& problem);

/// band ← R + D + damping · I. @pre band has size n T and width min(2 n, n T − 1).
void assemble_hessian(const TrajectoryProblem& problem, const std::vector<StageModel>& models, double damping,
                      BandMatrix& band);

/// Evaluates the path to start from and notes its cost in the solution; false when that is not finite.
bool begin(const TrajectoryProblem& problem, StageCosts& stages, PathModel& path, Solution& solution);

/// Moves the path with its cost, models and gradient into the solution; bad_input when its cost is not `finite`.
void finish(const TrajectoryProblem& problem, PathModel&& path, bool finite, Solution& solution);

}  // namespace primo::motion
