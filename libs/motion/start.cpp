#include "motion/start.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

namespace primo::motion {

Eigen::MatrixXd rest_start(const TrajectoryProblem& problem) { return problem.q_start.replicate(1, problem.steps); }

Eigen::MatrixXd minimum_jerk(const TrajectoryProblem& problem, const Eigen::VectorXd& q_goal) {
  Eigen::MatrixXd q(problem.joints(), problem.steps);
  for (int t = 1; t <= problem.steps; ++t) {
    const double x = static_cast<double>(t) / problem.steps;
    const double s = x * x * x * (10 + x * (6 * x - 15));
    q.col(t - 1) = problem.q_start + s * (q_goal - problem.q_start);
  }
  return q;
}

Eigen::VectorXd inverse_kinematics(const TrajectoryProblem& problem, StageCosts& stages, int max_iterations) {
  const int n = problem.joints(), T = problem.steps;
  const double duration = T * problem.dt;
  // ∫ q̈² of the cubic from rest to a displacement d with a free final velocity is 3 d² / D³.
  const Eigen::VectorXd effort = 3 / (duration * duration * duration) * problem.H / problem.dt;
  Eigen::VectorXd q = problem.q_start, r(n), trial_r(n);
  Eigen::MatrixXd R(n, n), trial_R(n, n);
  double cost = stages.evaluate(T, q, &R, &r);
  if (!std::isfinite(cost)) return q;
  double lambda = 1e-3, nu = 2;
  for (int iteration = 0; iteration < max_iterations && lambda < 1e12; ++iteration) {
    Eigen::MatrixXd A = R;
    A.diagonal() += effort;
    A.diagonal().array() += lambda;
    const Eigen::VectorXd g = r + effort.cwiseProduct(q - problem.q_start);
    const Eigen::LLT<Eigen::MatrixXd> llt(A);
    Eigen::VectorXd delta = llt.info() == Eigen::Success ? Eigen::VectorXd(-llt.solve(g)) : Eigen::VectorXd();
    double trial_cost = std::numeric_limits<double>::infinity();
    // Steps beyond a radian leave the region where the linearisation of a revolute chain means anything.
    const bool usable = delta.size() > 0 && delta.allFinite();
    if (usable) {
      const double largest = delta.cwiseAbs().maxCoeff();
      if (largest > 1) delta /= largest;
      const Eigen::VectorXd q_trial = q + delta;
      trial_cost =
          stages.evaluate(T, q_trial, &trial_R, &trial_r) + effort.dot((q_trial - problem.q_start).cwiseAbs2());
    }
    if (!(trial_cost < cost) || !trial_r.allFinite()) {
      lambda *= nu;
      nu *= 2;
      continue;
    }
    const double decrease = cost - trial_cost;
    q += delta;
    cost = trial_cost;
    std::swap(R, trial_R);
    std::swap(r, trial_r);
    lambda = std::max(lambda / 3, 1e-9);
    nu = 2;
    if (delta.cwiseAbs().maxCoeff() < 1e-4 || decrease < 1e-6 * cost) break;
  }
  return q;
}

}  // namespace primo::motion
