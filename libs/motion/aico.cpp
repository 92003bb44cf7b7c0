// Approximate Inference Control: M. Toussaint, Robot Trajectory Optimization using Approximate Inference, ICML 2009.
// A path's cost is minus twice the logarithm of its probability, so the likeliest path is the best one. Gaussian
// messages run along the chain of steps, forward (what is past) and backward (what is to come); their product with the
// step's own tasks is the belief, at whose mean b_t the tasks are linearised anew while the sweep is still under way.
//
// A message is the least cost of its side of the chain as a quadratic function of the pair (q_t, q_{t−1}), which is
// x_t = (q_t, (q_t − q_{t−1}) / τ) in other coordinates:
//   forward   F_{t+1}(q_{t+1}, q_t) = min over q_{t−1} of F_t(q_t, q_{t−1}) + Φ̂_t + u_tᵀ H u_t,      F_1 = u_0ᵀ H u_0,
//   backward  P_t(q_t, q_{t−1})     = min over q_{t+1} of u_tᵀ H u_t + Φ̂_{t+1} + P_{t+1}(q_{t+1}, q_t),      P_T = 0,
//   belief    b_t                   = argmin F_t + Φ̂_t + P_t.
// In pairs the known x_0 is two constants and not an infinite precision, so both directions are in information form and
// messages invert nothing but n × n pivots ≥ H/τ⁴. All are functions of the displacement from the current path; Φ̂_t is
// the linearised task cost with the damping λ |q_t − current|². The backward messages' minimisers, taken one after
// another from x_0 on, make the likeliest path, whose dynamics are exact.
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "motion/path_model.h"
#include "motion/quadratic.h"
#include "motion/trajectory_problem.h"

namespace primo::motion {
namespace {

constexpr double kLambdaMin = 1e-9, kLambdaMax = 1e9;  // relative to the control cost's Hessian
constexpr double kLargestStep = 1e3;                   // rad; beyond that a step is an artefact of a singular system

/// Where a sweep linearises tasks anew.
struct Mode {
  int forward = 1, backward = 0;  // relinearisations of a slice at most
};

/// A slice's tasks, linearised at x̂ = (q, v).
struct Slice {
  Eigen::VectorXd q, v;
  StageModel model;
  Eigen::VectorXd g_q, g_v;  // ½ ∂Φ̂/∂x at the current path
};

class Aico {
 public:
  Aico(const TrajectoryProblem& problem, StageCosts& stages, const SolverOptions& options, Mode mode);
  Solution solve(Eigen::MatrixXd q);

 private:
  void move_to(const PathModel& path);
  void restore(const std::vector<StageModel>& models);
  bool sweep(const PathModel& path, Eigen::MatrixXd& delta);
  bool forward();
  bool backward(int relinearisations);
  void rollout(Eigen::MatrixXd& delta);
  bool belief(int t);
  bool relinearise(int t, int most);
  bool linearise(int t);
  void add_control(int t, Quadratic& f, int next, int now, int before) const;
  void add_tasks(int t, Quadratic& f, int now, int before) const;
  void add_backward(int t, Quadratic& f) const;
  bool accept(double size, bool flat);
  bool reject(bool swept, bool minimum);
  double predicted(const PathModel& path, const Eigen::MatrixXd& delta) const;

  const TrajectoryProblem& problem_;
  StageCosts& stages_;
  const SolverOptions& options_;
  const Mode mode_;
  const int n_, T_;
  const Eigen::VectorXd curvature_;    // H/τ⁴
  const double scale_;                 // makes λ a pure number: costs multiplied by c give the same path
  double damping_ = 0;                 // λ · scale
  Eigen::MatrixXd q_, v_;              // the current path, n × T
  Eigen::MatrixXd control_gradient_;   // H u_t / τ², n × T
  std::vector<Slice> slices_;          // by t − 1
  std::vector<Quadratic> F_, P_;       // over (q_{t−1}, q_t) and over (q_t, q_{t−1}), by t − 1
  std::vector<Eigen::MatrixXd> laws_;  // factors whose minimiser is q_{t+1} given (q_t, q_{t−1}), by t
  bool moved_ = false;                 // whether the forward pass linearised anywhere anew
  long relinearised_ = 0;              // slices, in all
  Solution solution_;
  Quadratic pair_, triple_;  // workspace, as all that follows
  Eigen::VectorXd b_, x_, dq_, dv_;
};

Aico::Aico(const TrajectoryProblem& problem, StageCosts& stages, const SolverOptions& options, Mode mode)
    : problem_(problem),
      stages_(stages),
      options_(options),
      mode_(mode),
      n_(problem.joints()),
      T_(problem.steps),
      curvature_(control_curvature(problem)),
      scale_(6 * curvature_.mean()),
      slices_(T_),
      F_(T_, Quadratic(2 * n_)),
      P_(T_, Quadratic(2 * n_)),
      laws_(T_, Eigen::MatrixXd(3 * n_ + 1, n_)),
      pair_(2 * n_),
      triple_(3 * n_),
      b_(2 * n_),
      x_(3 * n_) {}

/// Adds u_tᵀ H u_t, given where f has q_{t+1}, q_t and q_{t−1} (< 0: it has not).
void Aico::add_control(int t, Quadratic& f, int next, int now, int before) const {
  const int at[] = {next, now, before};
  const double weight[] = {1, -2, 1};  // of u_t τ²
  for (int i = 0; i < 3; ++i) {
    if (at[i] < 0) continue;
    f.gradient(at[i], n_) += weight[i] * control_gradient_.col(t).transpose();
    for (int j = 0; j < 3; ++j) {
      if (at[j] >= 0 && at[i] >= at[j]) f.block(at[i], at[j], n_, n_).diagonal() += weight[i] * weight[j] * curvature_;
    }
  }
}

/// Adds Φ̂_t and the damping, given where f has q_t and q_{t−1}.
void Aico::add_tasks(int t, Quadratic& f, int now, int before) const {
  const Slice& slice = slices_[t - 1];
  auto own = f.block(now, now, n_, n_);
  own += slice.model.R_qq;
  own.diagonal().array() += damping_;
  f.gradient(now, n_) += slice.g_q.transpose();
  if (!slice.model.moving) return;
  const double by_tau = 1 / problem_.dt;  // v_t = (q_t − q_{t−1}) / τ
  const auto& R_vq = slice.model.R_vq;
  auto old = f.block(before, before, n_, n_);
  auto cross = f.block(std::max(now, before), std::min(now, before), n_, n_);
  for (int j = 0; j < n_; ++j) {
    for (int i = 0; i < n_; ++i) {
      const double vv = by_tau * by_tau * slice.model.R_vv(std::max(i, j), std::min(i, j));
      own(i, j) += by_tau * (R_vq(i, j) + R_vq(j, i)) + vv;
      old(i, j) += vv;
      cross(i, j) -= by_tau * (now > before ? R_vq(j, i) : R_vq(i, j)) + vv;
    }
  }
  f.gradient(now, n_) += by_tau * slice.g_v.transpose();
  f.gradient(before, n_) -= by_tau * slice.g_v.transpose();
}

/// Adds P_t to a function of (q_{t−1}, q_t).
void Aico::add_backward(int t, Quadratic& f) const {
  const Quadratic& P = P_[t - 1];
  f.block(0, 0, n_, n_) += P.block(n_, n_, n_, n_);
  f.block(n_, n_, n_, n_) += P.block(0, 0, n_, n_);
  f.block(n_, 0, n_, n_) += P.block(n_, 0, n_, n_).transpose();
  f.gradient(0, n_) += P.gradient(n_, n_);
  f.gradient(n_, n_) += P.gradient(0, n_);
}

/// The belief's mean into b_ = (q_{t−1}, q_t), as a displacement; false when there is none.
bool Aico::belief(int t) {
  pair_.extend(F_[t - 1]);
  add_backward(t, pair_);
  add_tasks(t, pair_, n_, 0);
  if (t == 1) pair_.pin(0, n_);  // q_0 is known
  if (!pair_.eliminate(2 * n_)) return false;
  minimiser(pair_.factor(2 * n_), b_);
  return b_.allFinite() && b_.cwiseAbs().maxCoeff() <= kLargestStep;
}

/// Linearises step t's tasks at displacements (dq_, dv_) from the current path.
bool Aico::linearise(int t) {
  Slice& slice = slices_[t - 1];
  StageModel& model = slice.model;
  slice.q = q_.col(t - 1) + dq_;
  slice.v = v_.col(t - 1) + dv_;
  ++relinearised_;
  if (!std::isfinite(stages_.evaluate(t, slice.q, slice.v, &model))) return false;
  // The gradient at the current path, seen from there.
  slice.g_q = model.r_q;
  slice.g_q.noalias() -= model.R_qq.selfadjointView<Eigen::Lower>() * dq_;
  if (!model.moving) return true;
  slice.g_q.noalias() -= model.R_vq.transpose() * dv_;
  slice.g_v = model.r_v;
  slice.g_v.noalias() -= model.R_vq * dq_;
  slice.g_v.noalias() -= model.R_vv.selfadjointView<Eigen::Lower>() * dv_;
  return true;
}

/// Linearises step t at its belief's mean where that is away from x̂, at most so many times; false when there is no
/// belief or no finite linearisation.
bool Aico::relinearise(int t, int most) {
  const Slice& slice = slices_[t - 1];
  for (int i = 0; i < most; ++i) {
    if (!belief(t)) return false;
    dq_ = b_.tail(n_);
    dv_ = (b_.tail(n_) - b_.head(n_)) / problem_.dt;
    double away = (q_.col(t - 1) + dq_ - slice.q).cwiseAbs().maxCoeff();
    if (slice.model.moving) away = std::max(away, (v_.col(t - 1) + dv_ - slice.v).cwiseAbs().maxCoeff());
    if (away <= options_.step_tolerance) return true;
    moved_ = true;
    if (!linearise(t)) return false;
  }
  return true;
}

/// Makes this the current path.
void Aico::move_to(const PathModel& path) {
  q_ = path.q;
  v_ = velocities(problem_, path.q);
  control_gradient_ = (problem_.H / (problem_.dt * problem_.dt)).asDiagonal() * controls(problem_, path.q);
}

/// All tasks linearised at the current path itself.
void Aico::restore(const std::vector<StageModel>& models) {
  for (int t = 0; t < T_; ++t) {
    Slice& slice = slices_[t];
    slice.model = models[t];
    slice.q = q_.col(t);
    slice.v = v_.col(t);
    slice.g_q = slice.model.r_q;
    if (slice.model.moving) slice.g_v = slice.model.r_v;
  }
}

bool Aico::forward() {
  moved_ = false;
  for (int t = 1; t <= T_; ++t) {
    if (t == 1) {
      F_[0].clear();
      add_control(0, F_[0], n_, 0, -1);
      F_[0].pin(0, n_);
    } else {
      triple_.extend(F_[t - 2]);
      add_tasks(t - 1, triple_, n_, 0);
      add_control(t - 1, triple_, 2 * n_, n_, 0);
      if (t == 2) triple_.pin(0, n_);  // q_0 is known
      if (!triple_.eliminate(n_)) return false;
      triple_.rest(n_, F_[t - 1]);
    }
    if (!relinearise(t, mode_.forward)) return false;
  }
  return true;
}

bool Aico::backward(int relinearisations) {
  P_[T_ - 1].clear();
  for (int t = T_; t >= 1; --t) {
    if (relinearisations > 0 && !relinearise(t, relinearisations)) return false;
    triple_.extend(P_[t - 1]);
    add_tasks(t, triple_, 0, n_);
    add_control(t - 1, triple_, 0, n_, 2 * n_);
    if (!triple_.eliminate(n_)) return false;
    laws_[t - 1] = triple_.factor(n_);
    if (t > 1) triple_.rest(n_, P_[t - 2]);
  }
  return true;
}

/// The likeliest path under the present linearisations.
void Aico::rollout(Eigen::MatrixXd& delta) {
  delta.resize(n_, T_);
  x_.setZero();  // (q_{t+1}, q_t, q_{t−1}); x_0 is not displaced
  for (int t = 0; t < T_; ++t) {
    minimiser(laws_[t], x_);
    delta.col(t) = x_.head(n_);
    x_.tail(n_) = x_.segment(n_, n_);
    x_.segment(n_, n_) = delta.col(t);
  }
}

/// The displacements of the likeliest path when tasks are linearised at beliefs; false when there is none. A sweep
/// depends on nothing but the path, its models and λ: so a rejected one leaves nothing to undo.
bool Aico::sweep(const PathModel& path, Eigen::MatrixXd& delta) {
  restore(path.models);
  if (!backward(0) || !forward()) return false;
  // Without a new linearisation the backward messages are still those of the present ones.
  if (moved_ && !backward(mode_.backward)) return false;
  rollout(delta);
  return delta.allFinite() && delta.cwiseAbs().maxCoeff() <= kLargestStep;
}

Solution Aico::solve(Eigen::MatrixXd q) {
  PathModel current, trial;
  current.q = std::move(q);
  const bool finite = begin(problem_, stages_, current, solution_);
  solution_.lambda = options_.lambda_initial;
  if (finite) move_to(current);
  Eigen::MatrixXd delta;
  bool stopped = !finite;
  while (!stopped && solution_.iterations + solution_.rejected < options_.max_iterations) {
    damping_ = solution_.lambda * scale_;
    const bool swept = sweep(current, delta);
    const double size = swept ? delta.cwiseAbs().maxCoeff() : 0;
    bool lower = false;
    if (swept) {
      trial.q = current.q + delta;
      ++solution_.evaluations;
      lower = evaluate(problem_, stages_, trial, current.cost);
    }
    if (lower) {
      const double decrease = current.cost - trial.cost;
      std::swap(current, trial);
      move_to(current);
      stopped = accept(size, decrease <= options_.cost_tolerance * current.cost);
    } else {
      // At a minimum rounding alone can keep the cost from falling.
      const bool minimum = swept && (size < 1e-10 || predicted(current, delta) <= 1e-12 * current.cost);
      stopped = reject(swept, minimum);
    }
  }
  solution_.evaluations += static_cast<int>((relinearised_ + T_ - 1) / T_);
  finish(problem_, std::move(current), finite, solution_);
  return std::move(solution_);
}

/// Counts an accepted step of this size; true when it was the last.
bool Aico::accept(double size, bool flat) {
  ++solution_.iterations;
  solution_.last_step = size;
  const bool small = size < options_.step_tolerance && solution_.lambda <= options_.lambda_initial;
  solution_.lambda = std::max(solution_.lambda / 5, kLambdaMin);
  if (small || flat) solution_.status = small ? PlanStatus::converged_step : PlanStatus::converged_cost;
  return small || flat;
}

/// Counts a rejected step; true when there is none left to try.
bool Aico::reject(bool swept, bool minimum) {
  ++solution_.rejected;
  if (minimum) {
    solution_.status = PlanStatus::converged_cost;
    return true;
  }
  solution_.lambda = 10 * std::max(solution_.lambda, kLambdaMin);
  if (solution_.lambda <= kLambdaMax) return false;
  solution_.lambda = kLambdaMax;
  solution_.status = swept ? PlanStatus::damping_limit : PlanStatus::factorisation_failed;
  return true;
}

/// How much the cost falls to first order, with the damping's share that a Gauss–Newton step adds.
double Aico::predicted(const PathModel& path, const Eigen::MatrixXd& delta) const {
  const Eigen::Map<const Eigen::VectorXd> step(delta.data(), delta.size());
  return std::abs(half_gradient(problem_, path).dot(step)) + damping_ * step.squaredNorm();
}

}  // namespace

Solution aico_forward(const TrajectoryProblem& problem, StageCosts& stages, Eigen::MatrixXd q,
                      const SolverOptions& options) {
  return Aico(problem, stages, options, {1, 0}).solve(std::move(q));
}

Solution aico_symmetric(const TrajectoryProblem& problem, StageCosts& stages, Eigen::MatrixXd q,
                        const SolverOptions& options) {
  return Aico(problem, stages, options, {1, 1}).solve(std::move(q));
}

Solution aico_local(const TrajectoryProblem& problem, StageCosts& stages, Eigen::MatrixXd q,
                    const SolverOptions& options) {
  return Aico(problem, stages, options, {5, 5}).solve(std::move(q));
}

Solution aico(const TrajectoryProblem& problem, StageCosts& stages, Eigen::MatrixXd q, const SolverOptions& options) {
  return aico_symmetric(problem, stages, std::move(q), options);
}

}  // namespace primo::motion
