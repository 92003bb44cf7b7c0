// The trajectory problem as Ipopt's nonlinear program over q_1 … q_T:
//   minimise s · cost(q)  subject to  q_lower ≤ q_t ≤ q_upper,  c_t(q_t) ≥ 0 for a working set of the stages'
//   inequalities,
// with the Gauss–Newton Hessian 2 s (R + D + λ I) of path_model.h as a sparse lower triangle; λ falls after full steps
// and rises after shortened ones, as in gauss_newton. The constraints' curvature is left out as the tasks' is. s makes
// the cost a displacement squared: costs multiplied by c give the same program.
#pragma once

#include <coin/IpTNLP.hpp>
#include <utility>
#include <vector>

#include "motion/path_model.h"
#include "motion/trajectory_problem.h"

namespace primo::motion {

/// What holds besides the cost.
struct HardConstraints {
  bool limits = false;
  std::vector<std::vector<int>> rows;  ///< by t − 1: the inequalities of the working set; empty: none
};

/// The best path seen: first the one that violates least beyond the tolerance, then the cheapest.
struct BestPath {
  Eigen::MatrixXd q;
  double cost = 0;
  double violation = 0;  ///< of all inequalities, not only the working set's
};

/// What a run has used of its allowance, over all programs of one solve.
struct Usage {
  int iterations = 0;  ///< accepted steps
  int trials = 0;      ///< steps tried, accepted or not
  int evaluations = 0;
  double last_step = 0;  ///< rad
  double lambda = 0;     ///< damping relative to the control cost's Hessian
};

constexpr double kFeasible = 1e-4;  // m, the violation that counts as none

/// The largest amount by which the inequalities at q are missed, with them by t − 1; nothing where there are none.
double violation(const TrajectoryProblem& problem, StageCosts& stages, const Eigen::MatrixXd& q,
                 std::vector<Eigen::VectorXd>& c);

/// s, 1/cost.
double cost_scale(const TrajectoryProblem& problem);

/// How many logarithms the barrier has: finite limits of q_1 … q_T and inequalities of the working set.
int barrier_terms(const TrajectoryProblem& problem, const HardConstraints& constraints);

class IpoptProgram final : public Ipopt::TNLP {
 public:
  /// Everything given must outlive it; `best` and `usage` are brought forward. The path's cost must be finite there.
  IpoptProgram(const TrajectoryProblem& problem, StageCosts& stages, const SolverOptions& options,
               HardConstraints constraints, PathModel start, BestPath& best, Usage& usage);

  /// Why the callback stopped Ipopt, if it did.
  bool stopped() const { return stopped_; }
  PlanStatus status() const { return status_; }

 private:
  using Index = Ipopt::Index;
  using Number = Ipopt::Number;

  bool get_nlp_info(Index& n, Index& m, Index& jacobian, Index& hessian, IndexStyleEnum& style) override;
  bool get_bounds_info(Index n, Number* x_l, Number* x_u, Index m, Number* g_l, Number* g_u) override;
  bool get_starting_point(Index n, bool init_x, Number* x, bool init_z, Number* z_L, Number* z_U, Index m,
                          bool init_lambda, Number* lambda) override;
  bool eval_f(Index n, const Number* x, bool new_x, Number& value) override;
  bool eval_grad_f(Index n, const Number* x, bool new_x, Number* gradient) override;
  bool eval_g(Index n, const Number* x, bool new_x, Index m, Number* g) override;
  bool eval_jac_g(Index n, const Number* x, bool new_x, Index m, Index count, Index* rows, Index* columns,
                  Number* values) override;
  bool eval_h(Index n, const Number* x, bool new_x, Number factor, Index m, const Number* lambda, bool new_lambda,
              Index count, Index* rows, Index* columns, Number* values) override;
  bool intermediate_callback(Ipopt::AlgorithmMode mode, Index iteration, Number value, Number inf_pr, Number inf_du,
                             Number mu, Number d_norm, Number regularization, Number alpha_du, Number alpha_pr,
                             Index trials, const Ipopt::IpoptData* data,
                             Ipopt::IpoptCalculatedQuantities* quantities) override;
  void finalize_solution(Ipopt::SolverReturn, Index, const Number*, const Number*, const Number*, Index, const Number*,
                         const Number*, Number, const Ipopt::IpoptData*, Ipopt::IpoptCalculatedQuantities*) override {}

  void find_structure(const PathModel& start);
  bool move_to(const Number* x);
  void compare_with_best();
  bool converged(double cost, double inf_pr, double regularization, double alpha) const;
  void adapt_damping();
  bool stop(PlanStatus status);

  const TrajectoryProblem& problem_;
  StageCosts& stages_;
  const SolverOptions& options_;
  const HardConstraints constraints_;
  const int n_, T_, size_;
  const bool bounded_;                        // whether anything holds besides the cost
  const double scale_;                        // s, 1/cost
  std::vector<std::pair<int, int>> entries_;  // of the Hessian's lower triangle
  int rows_ = 0;                              // of the working set
  PathModel path_;                            // where Ipopt is
  bool usable_ = true;                        // whether its cost is finite
  std::vector<Eigen::VectorXd> c_;            // by t − 1, at path_; empty without inequalities
  bool started_ = false;                      // whether Ipopt has chosen where it starts
  BandMatrix band_;
  BestPath& best_;
  Usage& usage_;
  double damping_scale_ = 0;  // makes λ a pure number
  int trials_before_ = 0;
  double cost_before_ = 0;  // at the last iterate
  bool stopped_ = false;
  PlanStatus status_ = PlanStatus::iteration_limit;
};

}  // namespace primo::motion
