// The optimal control problem that every planner solves, free of robots: joint-space second-order dynamics and a sum of
// squares.
//   minimise over q_1 … q_T:  Σ_{t=0}^{T−1} u_tᵀ H u_t + Σ_{t=1}^{T} Φ_t(q_t)ᵀ Φ_t(q_t)      (paper, eq. 1)
//   u_t = (q_{t+1} − 2 q_t + q_{t−1}) / τ²,  q_{−1} = q_0 − τ v_0,
// which is x⁺ = [I τI; 0 I] x + [τ²I; τI] u for x = (q, q̇).
#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "motion/plan.h"

namespace primo::motion {

/// The sum of squares of each step. Implementations may keep a workspace: one object serves one solve at a time.
class StageCosts {
 public:
  virtual ~StageCosts() = default;
  /// Φ_t(q)ᵀ Φ_t(q) for t = 1 … T. Unless they are null, also writes R = JᵀJ (n × n, lower triangle) and r = Jᵀ Φ (n).
  virtual double evaluate(int t, const Eigen::VectorXd& q, Eigen::MatrixXd* R, Eigen::VectorXd* r) = 0;
};

struct TrajectoryProblem {
  int steps = 1;            ///< T ≥ 1
  double dt = 0.1;          ///< τ, s
  Eigen::VectorXd H;        ///< diagonal of the control cost, positive: τ · rate · W
  Eigen::VectorXd q_start;  ///< q_0, rad
  Eigen::VectorXd v_start;  ///< q̇_0, rad/s

  int joints() const { return static_cast<int>(q_start.size()); }
};

struct SolverOptions {
  int max_iterations = 100;      ///< accepted and rejected steps together
  double step_tolerance = 1e-2;  ///< rad, on the largest entry of a step
  double cost_tolerance = 1e-4;  ///< on the relative decrease of the cost
  double lambda_initial = 1e-5;  ///< damping relative to the control cost's Hessian
};

struct Solution {
  PlanStatus status = PlanStatus::iteration_limit;
  Eigen::MatrixXd q;  ///< n × T: column t−1 is q_t
  int iterations = 0, rejected = 0, evaluations = 0;
  double cost_initial = 0, cost = 0, cost_control = 0;
  double gradient_norm = 0;  ///< ‖½ ∂cost/∂q‖∞ where the solver stopped
  double lambda = 0;
  double last_step = 0;            ///< rad, largest entry of the last accepted step
  std::vector<Eigen::MatrixXd> R;  ///< T Gauss–Newton Hessians JᵀJ at the solution, lower triangles
};

/// u_t for t = 0 … T−1 (n × T), rad/s².
Eigen::MatrixXd controls(const TrajectoryProblem& problem, const Eigen::MatrixXd& q);

/// Σ u_tᵀ H u_t.
double control_cost(const TrajectoryProblem& problem, const Eigen::MatrixXd& q);

/// Levenberg–Marquardt on the banded Gauss–Newton system from the given q (n × T). Every result is finite when the cost
/// at the start is; a start whose cost is not finite gives bad_input. The cost never rises over accepted steps.
Solution gauss_newton(const TrajectoryProblem& problem, StageCosts& stages, Eigen::MatrixXd q,
                      const SolverOptions& options);

/// Feedback gains around a solution by the Riccati recursion on R_t and H: u_t = û_t + K_t (x_t − x̂_t), x = (q, q̇).
Gains riccati_gains(const TrajectoryProblem& problem, const Eigen::MatrixXd& q, const std::vector<Eigen::MatrixXd>& R);

}  // namespace primo::motion
