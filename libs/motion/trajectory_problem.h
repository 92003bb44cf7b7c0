// The optimal control problem that every planner solves, free of robots: joint-space second-order dynamics and a sum of
// squares.
//   minimise over q_1 … q_T:  Σ_{t=0}^{T−1} u_tᵀ H u_t + Σ_{t=1}^{T} Φ_t(x_t)ᵀ Φ_t(x_t)      (paper, eq. 1)
//   x_t = (q_t, v_t),  v_t = (q_t − q_{t−1}) / τ,  u_t = (v_{t+1} − v_t) / τ,
// which is x⁺ = [I τI; 0 I] x + [τ²I; τI] u.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "motion/plan.h"

namespace primo::motion {

/// The Gauss–Newton model of one step's tasks over x = (q, v): R = JᵀJ and r = Jᵀ Φ, by blocks.
struct StageModel {
  Eigen::MatrixXd R_qq;  ///< n × n, lower triangle
  Eigen::VectorXd r_q;   ///< n
  /// Whether Φ depends on v, the same at every q and v of a step; what follows means nothing otherwise.
  bool moving = false;
  Eigen::MatrixXd R_vq;  ///< n × n
  Eigen::MatrixXd R_vv;  ///< n × n, lower triangle
  Eigen::VectorXd r_v;   ///< n
};

/// The sum of squares of each step. Implementations may keep a workspace: one object serves one solve at a time.
class StageCosts {
 public:
  virtual ~StageCosts() = default;
  /// Φ_t(q, v)ᵀ Φ_t(q, v) for t = 1 … T; also writes the model unless that is null.
  virtual double evaluate(int t, const Eigen::VectorXd& q, const Eigen::VectorXd& v, StageModel* model) = 0;
  /// How many inequalities c_t(q) ≥ 0 there are at every step, for solvers that keep hard constraints.
  virtual int inequalities() const { return 0; }
  /// Writes c_t(q) and, unless J is null, ∂c_t/∂q (a row for each inequality). A row far from its bound is cut off at a
  /// constant, its gradient zero.
  virtual void inequality(int /*t*/, const Eigen::VectorXd& /*q*/, Eigen::VectorXd& /*c*/, Eigen::MatrixXd* /*J*/) {}
};

struct TrajectoryProblem {
  int steps = 1;                               ///< T ≥ 1
  double dt = 0.1;                             ///< τ, s
  Eigen::VectorXd H;                           ///< diagonal of the control cost, positive: τ · rate · W
  Eigen::VectorXd q_start;                     ///< q_0, rad
  Eigen::VectorXd v_start;                     ///< v_0, rad/s
  Eigen::VectorXd q_lower = {}, q_upper = {};  ///< rad, for solvers with hard limits; empty: none
  int arm_joints = 0;                          ///< how many of the joints, the first ones, are the arm's

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
  std::vector<StageModel> models;  ///< T, of the stages at the solution
};

/// v_t for t = 1 … T (n × T), rad/s.
Eigen::MatrixXd velocities(const TrajectoryProblem& problem, const Eigen::MatrixXd& q);

/// u_t for t = 0 … T−1 (n × T), rad/s².
Eigen::MatrixXd controls(const TrajectoryProblem& problem, const Eigen::MatrixXd& q);

/// Σ u_tᵀ H u_t.
double control_cost(const TrajectoryProblem& problem, const Eigen::MatrixXd& q);

/// Levenberg–Marquardt on the banded Gauss–Newton system from the given q (n × T). Every result is finite when the cost
/// at the start is; a start whose cost is not finite gives bad_input. The cost never rises over accepted steps.
Solution gauss_newton(const TrajectoryProblem& problem, StageCosts& stages, Eigen::MatrixXd q,
                      const SolverOptions& options);

/// Approximate inference control from the given path, with the same guarantees. The variants differ in where a sweep
/// linearises tasks anew: on its forward pass, on both passes (what `aico` does), or on both up to five times a step.
Solution aico(const TrajectoryProblem& problem, StageCosts& stages, Eigen::MatrixXd q, const SolverOptions& options);
Solution aico_forward(const TrajectoryProblem& problem, StageCosts& stages, Eigen::MatrixXd q,
                      const SolverOptions& options);
Solution aico_symmetric(const TrajectoryProblem& problem, StageCosts& stages, Eigen::MatrixXd q,
                        const SolverOptions& options);
Solution aico_local(const TrajectoryProblem& problem, StageCosts& stages, Eigen::MatrixXd q,
                    const SolverOptions& options);

/// The same minimum by iterative LQG: a regularised Riccati sweep and a line search a step (Tassa et al., 2012).
Solution ilqg(const TrajectoryProblem& problem, StageCosts& stages, Eigen::MatrixXd q, const SolverOptions& options);

/// The same minimum by the interior-point method Ipopt; calls from several threads take turns. Deterministic.
Solution ipopt(const TrajectoryProblem& problem, StageCosts& stages, Eigen::MatrixXd q, const SolverOptions& options);

/// The same cost with q_lower ≤ q_t ≤ q_upper and every inequality of the stages; the start is clamped into the limits,
/// and the solution violates no inequality by more than 1e-4 unless its status is not convergence. Limits out of order
/// give bad_input. The cost may rise over a start that violates an inequality.
Solution ipopt_constrained(const TrajectoryProblem& problem, StageCosts& stages, Eigen::MatrixXd q,
                           const SolverOptions& options);

/// Feedback gains around a solution by the Riccati recursion on R_t and H: u_t = û_t + K_t (x_t − x̂_t), x = (q, v).
Gains riccati_gains(const TrajectoryProblem& problem, const Eigen::MatrixXd& q, const std::vector<StageModel>& models);

}  // namespace primo::motion
