#include <Eigen/Cholesky>

#include "motion/trajectory_problem.h"

namespace primo::motion {

Gains riccati_gains(const TrajectoryProblem& problem, const Eigen::MatrixXd& q, const std::vector<StageModel>& models) {
  const int n = problem.joints(), T = problem.steps;
  const double tau = problem.dt;
  Gains gains;
  gains.K.resize(T);
  gains.k.resize(T);
  const Eigen::MatrixXd u = controls(problem, q);
  // M is the Hessian of the cost to go at t+1, its own stage included; x = (q, q̇), A = [I τI; 0 I], B = [τ²I; τI].
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(2 * n, 2 * n);
  for (int t = T - 1; t >= 0; --t) {
    const StageModel& stage = models[t];
    M.topLeftCorner(n, n) += Eigen::MatrixXd(stage.R_qq.selfadjointView<Eigen::Lower>());
    if (stage.moving) {
      M.bottomLeftCorner(n, n) += stage.R_vq;
      M.topRightCorner(n, n) += stage.R_vq.transpose();
      M.bottomRightCorner(n, n) += Eigen::MatrixXd(stage.R_vv.selfadjointView<Eigen::Lower>());
    }
    const Eigen::MatrixXd BtM = tau * tau * M.topRows(n) + tau * M.bottomRows(n);
    Eigen::MatrixXd S = tau * tau * BtM.leftCols(n) + tau * BtM.rightCols(n);
    S.diagonal() += problem.H;
    Eigen::MatrixXd BtMA = BtM;
    BtMA.rightCols(n) += tau * BtM.leftCols(n);
    gains.K[t] = -S.selfadjointView<Eigen::Lower>().llt().solve(BtMA);
    gains.k[t] = u.col(t);
    // V = Aᵀ M A + (BᵀMA)ᵀ K, made symmetric so that rounding does not grow.
    Eigen::MatrixXd V = M;
    V.rightCols(n) += tau * M.leftCols(n);
    V.bottomRows(n) += tau * V.topRows(n);
    V += BtMA.transpose() * gains.K[t];
    M = 0.5 * (V + V.transpose());
  }
  return gains;
}

}  // namespace primo::motion
