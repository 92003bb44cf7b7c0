// Iterative LQG: a Riccati sweep backward over the Gauss–Newton models of the stages, then a line search forward along
// the controls it gives (Todorov and Li, 2005; regularised and searched as in Tassa, Erez and Todorov, 2012). Per step,
// with half the cost to go ½ δxᵀ M δx + mᵀ δx at t + 1, its own stage included, and M_qq damped by μ = λ · s:
//   Q_u = H û + Bᵀ m,   Q_uu = H + Bᵀ M B = L Lᵀ,   Q_ux = Bᵀ M A,
//   δu = −Q_uu⁻¹ (Q_u + Q_ux δx),   V = Aᵀ M A − Q_uxᵀ Q_uu⁻¹ Q_ux,   v = Aᵀ m − Q_uxᵀ Q_uu⁻¹ Q_u.
// μ penalises deviations of the states, not of the controls, and stays in V: the sweep minimises the quadratic model
// plus μ Σ ‖δq_t‖² exactly, the step of gauss_newton at the same λ. The dynamics are linear, so the path rolled out
// with α times the open-loop step is q̂ + α δq; the true cost there decides.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "motion/path_model.h"
#include "motion/trajectory_problem.h"

namespace primo::motion {
namespace {

constexpr double kLambdaMin = 1e-9, kLambdaMax = 1e9;  // relative to the control cost's Hessian
constexpr double kLargestStep = 1e3;                   // rad; beyond that a step is an artefact of a singular system
constexpr int kHalvings =
    2;  // of α, before the sweep is damped more: two reach lower costs than none in little more time

/// The square root of Q_uu and what it makes of Q_u and Q_ux = [Q_uq Q_uv].
struct StagePolicy {
  Eigen::LLT<Eigen::MatrixXd> llt;  // of Q_uu
  Eigen::VectorXd w;                // L⁻¹ Q_u
  Eigen::MatrixXd W_q, W_v;         // L⁻¹ Q_uq, L⁻¹ Q_uv
};

/// Half the cost to go over x = (q, v) by blocks, full and symmetric, or on its lower triangle between stages.
struct CostToGo {
  Eigen::MatrixXd qq, vq, vv;
  Eigen::VectorXd q, v;

  explicit CostToGo(int n) : qq(Eigen::MatrixXd::Zero(n, n)), vq(qq), vv(qq), q(Eigen::VectorXd::Zero(n)), v(q) {}

  void add(const StageModel& stage) {
    qq.triangularView<Eigen::Lower>() += stage.R_qq;
    q += stage.r_q;
    if (!stage.moving) return;
    vq += stage.R_vq;
    vv.triangularView<Eigen::Lower>() += stage.R_vv;
    v += stage.r_v;
  }
};

class Sweep {
 public:
  explicit Sweep(const TrajectoryProblem& problem)
      : problem_(problem), n_(problem.joints()), policies_(problem.steps), M_(n_), P_(n_, n_), N_(n_, n_), S_(n_, n_) {}

  /// False when a Q_uu cannot be factorised.
  bool backward(const PathModel& path, double mu);
  /// δq for α = 1 (n × T).
  void forward(Eigen::MatrixXd& delta) const;

 private:
  bool policy(const Eigen::VectorXd& u, StagePolicy& policy);
  void step_back(const StagePolicy& policy);

  const TrajectoryProblem& problem_;
  const int n_;
  std::vector<StagePolicy> policies_;  // of u_0 … u_{T−1}
  CostToGo M_;
  Eigen::MatrixXd P_, N_, S_;  // BᵀM = [P N], Q_uu
};

void mirror(Eigen::MatrixXd& lower) { lower.triangularView<Eigen::StrictlyUpper>() = lower.transpose(); }

bool Sweep::policy(const Eigen::VectorXd& u, StagePolicy& policy) {
  const double tau = problem_.dt;
  P_ = tau * tau * M_.qq + tau * M_.vq;
  N_ = tau * tau * M_.vq.transpose() + tau * M_.vv;
  S_ = tau * tau * P_ + tau * N_;
  S_.diagonal() += problem_.H;
  policy.llt.compute(S_);
  if (policy.llt.info() != Eigen::Success) return false;
  const auto L = policy.llt.matrixL();
  policy.w = problem_.H.cwiseProduct(u) + tau * tau * M_.q + tau * M_.v;
  L.solveInPlace(policy.w);
  policy.W_q = P_;
  L.solveInPlace(policy.W_q);
  policy.W_v = N_ + tau * P_;
  L.solveInPlace(policy.W_v);
  return policy.w.allFinite() && policy.W_q.allFinite() && policy.W_v.allFinite();
}

/// From M, m at t + 1 to V, v at t.
void Sweep::step_back(const StagePolicy& policy) {
  const double tau = problem_.dt;
  M_.vv += tau * (M_.vq + M_.vq.transpose()) + tau * tau * M_.qq;
  M_.vq += tau * M_.qq;
  M_.v += tau * M_.q;
  M_.qq.noalias() -= policy.W_q.transpose() * policy.W_q;
  M_.vq.noalias() -= policy.W_v.transpose() * policy.W_q;
  M_.vv.noalias() -= policy.W_v.transpose() * policy.W_v;
  M_.q.noalias() -= policy.W_q.transpose() * policy.w;
  M_.v.noalias() -= policy.W_v.transpose() * policy.w;
}

bool Sweep::backward(const PathModel& path, double mu) {
  const Eigen::MatrixXd u = controls(problem_, path.q);
  M_ = CostToGo(n_);
  for (int t = problem_.steps - 1; t >= 0; --t) {
    M_.add(path.models[t]);
    M_.qq.diagonal().array() += mu;
    mirror(M_.qq);
    mirror(M_.vv);
    if (!policy(u.col(t), policies_[t])) return false;
    step_back(policies_[t]);
  }
  return true;
}

void Sweep::forward(Eigen::MatrixXd& delta) const {
  const double tau = problem_.dt;
  Eigen::VectorXd q = Eigen::VectorXd::Zero(n_), v = q, u(n_);
  for (int t = 0; t < problem_.steps; ++t) {
    const StagePolicy& policy = policies_[t];
    u = -policy.w;
    u.noalias() -= policy.W_q * q;
    u.noalias() -= policy.W_v * v;
    policy.llt.matrixU().solveInPlace(u);
    v += tau * u;
    q += tau * v;
    delta.col(t) = q;
  }
}

/// λ by Nielsen's rule: faster and faster up while steps fail, down with a step that the model foretold.
struct Damping {
  double lambda, factor = 2;
  void raise() {
    lambda = std::max(lambda, kLambdaMin) * factor;
    factor *= 2;
  }
  void lower(double ratio) {
    lambda *= std::max(1.0 / 3, 1 - std::pow(2 * std::clamp(ratio, 0.0, 1.0) - 1, 3));
    lambda = std::clamp(lambda, kLambdaMin, kLambdaMax);
    factor = 2;
  }
};

class Solver {
 public:
  Solver(const TrajectoryProblem& problem, StageCosts& stages, const SolverOptions& options)
      : problem_(problem),
        stages_(stages),
        options_(options),
        scale_(6 * control_curvature(problem).mean()),
        sweep_(problem),
        delta_(problem.joints(), problem.steps) {}

  Solution solve(Eigen::MatrixXd q);

 private:
  bool may_go_on() const { return solution_.iterations + solution_.rejected < options_.max_iterations; }
  bool direction();
  double line_search();
  bool converged(double decrease, double alpha);
  void reject();

  const TrajectoryProblem& problem_;
  StageCosts& stages_;
  const SolverOptions& options_;
  const double scale_;  // makes λ a pure number: costs multiplied by c give the same path
  Sweep sweep_;
  PathModel current_, trial_;
  Eigen::MatrixXd delta_;  // δq at α = 1
  double predicted_ = 0;   // the cost's decrease by the model at α = 1
  double size_ = 0;        // largest entry of δq
  Damping damping_{};
  bool stopped_ = false;
  Solution solution_;
};

/// δq at the present damping; false when there is none within bounds.
bool Solver::direction() {
  if (!sweep_.backward(current_, damping_.lambda * scale_)) return false;
  sweep_.forward(delta_);
  size_ = delta_.cwiseAbs().maxCoeff();
  if (!delta_.allFinite() || !(size_ <= kLargestStep)) return false;
  const Eigen::VectorXd g = half_gradient(problem_, current_);
  // −(2 gᵀδ + δᵀ(R + D)δ), where (R + D) δ = −g − μ δ.
  predicted_ = -Eigen::Map<const Eigen::VectorXd>(delta_.data(), delta_.size()).dot(g) +
               damping_.lambda * scale_ * delta_.squaredNorm();
  return true;
}

/// The first of α = 1, ½, … that lowers the cost, with its path in trial_; 0 when there is none.
double Solver::line_search() {
  double alpha = 1;
  for (int halving = 0; halving <= kHalvings && may_go_on(); ++halving, alpha /= 2) {
    trial_.q = current_.q + alpha * delta_;
    ++solution_.evaluations;
    if (evaluate(problem_, stages_, trial_, current_.cost)) return alpha;
    // At a minimum rounding alone can keep the cost from falling.
    if (predicted_ <= 1e-12 * current_.cost || size_ < 1e-10) {
      solution_.status = PlanStatus::converged_cost;
      stopped_ = true;
    }
    ++solution_.rejected;
    if (stopped_) break;
  }
  return 0;
}

bool Solver::converged(double decrease, double alpha) {
  const bool free = damping_.lambda <= options_.lambda_initial && alpha == 1;
  if (free && size_ < options_.step_tolerance) {
    solution_.status = PlanStatus::converged_step;
    return true;
  }
  if (decrease > options_.cost_tolerance * current_.cost) return false;
  solution_.status = PlanStatus::converged_cost;
  return true;
}

void Solver::reject() {
  damping_.raise();
  if (damping_.lambda <= kLambdaMax) return;
  damping_.lambda = kLambdaMax;
  stopped_ = true;
}

Solution Solver::solve(Eigen::MatrixXd q) {
  current_.q = std::move(q);
  damping_.lambda = options_.lambda_initial;
  const bool finite = begin(problem_, stages_, current_, solution_);
  stopped_ = !finite;
  while (!stopped_ && may_go_on()) {
    if (!direction()) {
      ++solution_.rejected;
      reject();
      if (stopped_) solution_.status = PlanStatus::factorisation_failed;
      continue;
    }
    const double alpha = line_search();
    if (stopped_) break;
    if (alpha == 0) {
      reject();
      if (stopped_) solution_.status = PlanStatus::damping_limit;
      continue;
    }
    const double decrease = current_.cost - trial_.cost;
    damping_.lower(alpha == 1 && predicted_ > 0 ? decrease / predicted_ : 0.5);
    std::swap(current_, trial_);
    ++solution_.iterations;
    solution_.last_step = alpha * size_;
    stopped_ = converged(decrease, alpha);
  }
  solution_.lambda = damping_.lambda;
  finish(problem_, std::move(current_), finite, solution_);
  return std::move(solution_);
}

}  // namespace

Solution ilqg(const TrajectoryProblem& problem, StageCosts& stages, Eigen::MatrixXd q, const SolverOptions& options) {
  return Solver(problem, stages, options).solve(std::move(q));
}

}  // namespace primo::motion
