#include <algorithm>
#include <cmath>
#include <utility>

#include "core/check.h"
#include "motion/banded.h"
#include "motion/trajectory_problem.h"

namespace primo::motion {
namespace {

constexpr double kLambdaMin = 1e-9, kLambdaMax = 1e9;  // relative to the control cost's Hessian
constexpr double kLargestStep = 1e3;                   // rad; beyond that a step is an artefact of a singular system

/// A path with its cost and the quadratic model of its stages.
struct Iterate {
  Eigen::MatrixXd q;  // n × T
  double cost = 0, cost_control = 0;
  std::vector<StageModel> models;  // T
};

class Solver {
 public:
  Solver(const TrajectoryProblem& problem, StageCosts& stages, const SolverOptions& options)
      : problem_(problem),
        stages_(stages),
        options_(options),
        n_(problem.joints()),
        T_(problem.steps),
        curvature_(problem.H / std::pow(problem.dt, 4)),
        // The scale makes λ a pure number: costs multiplied by c give the same path.
        scale_(6 * curvature_.mean()),
        band_(n_ * T_, std::min(2 * n_, n_ * T_ - 1)) {}

  Solution solve(Eigen::MatrixXd q);

 private:
  bool evaluate(Iterate& at, double limit);
  Eigen::VectorXd gradient(const Iterate& at) const;
  void add_moving(const StageModel& model, int t);
  bool step(const Iterate& at, const Eigen::VectorXd& gradient, double lambda, Eigen::VectorXd& step);

  const TrajectoryProblem& problem_;
  StageCosts& stages_;
  const SolverOptions& options_;
  const int n_, T_;
  const Eigen::VectorXd curvature_;  // H/τ⁴
  const double scale_;
  BandMatrix band_;
  Solution solution_;
  Eigen::VectorXd q_t_, v_t_;
};

/// Cost and quadratic model; false as soon as the cost is not finite or no longer below `limit`.
bool Solver::evaluate(Iterate& at, double limit) {
  ++solution_.evaluations;
  at.cost_control = control_cost(problem_, at.q);
  at.cost = at.cost_control;
  at.models.resize(T_);
  const Eigen::MatrixXd v = velocities(problem_, at.q);
  for (int t = 0; t < T_; ++t) {
    if (!(at.cost < limit)) return false;
    q_t_ = at.q.col(t);
    v_t_ = v.col(t);
    StageModel& model = at.models[t];
    at.cost += stages_.evaluate(t + 1, q_t_, v_t_, &model);
    if (!model.r_q.allFinite() || (model.moving && !model.r_v.allFinite())) return false;
  }
  return at.cost < limit && std::isfinite(at.cost);
}

/// ½ ∂cost/∂q as one vector over t and joints.
Eigen::VectorXd Solver::gradient(const Iterate& at) const {
  const Eigen::MatrixXd u = controls(problem_, at.q);
  Eigen::MatrixXd g(n_, T_);
  const Eigen::VectorXd weight = problem_.H / (problem_.dt * problem_.dt);
  for (int t = 1; t <= T_; ++t) {  // q_t enters u_{t−1}, u_t and u_{t+1}
    g.col(t - 1) = at.models[t - 1].r_q + weight.cwiseProduct(u.col(t - 1));
    if (t < T_) g.col(t - 1) -= 2 * weight.cwiseProduct(u.col(t));
    if (t + 1 < T_) g.col(t - 1) += weight.cwiseProduct(u.col(t + 1));
  }
  for (int t = 0; t < T_; ++t) {
    if (!at.models[t].moving) continue;
    g.col(t) += at.models[t].r_v / problem_.dt;
    if (t > 0) g.col(t - 1) -= at.models[t].r_v / problem_.dt;
  }
  return Eigen::Map<const Eigen::VectorXd>(g.data(), g.size());
}

/// Adds the part of a step's Hessian that comes from v_t = (q_t − q_{t−1}) / τ.
void Solver::add_moving(const StageModel& model, int t) {
  if (!model.moving) return;
  const double by_tau = 1 / problem_.dt;
  const Eigen::MatrixXd vv = by_tau * by_tau * Eigen::MatrixXd(model.R_vv.selfadjointView<Eigen::Lower>());
  for (int j = 0; j < n_; ++j) {
    for (int i = j; i < n_; ++i)
      band_.at(t * n_ + i, t * n_ + j) += by_tau * (model.R_vq(i, j) + model.R_vq(j, i)) + vv(i, j);
    if (t == 0) continue;
    for (int i = j; i < n_; ++i) band_.at((t - 1) * n_ + i, (t - 1) * n_ + j) += vv(i, j);
    for (int i = 0; i < n_; ++i) band_.at(t * n_ + i, (t - 1) * n_ + j) -= by_tau * model.R_vq(j, i) + vv(i, j);
  }
}

/// Δ = −(R + D + λ s I)⁻¹ g, D the control cost's Hessian; false when the factorisation fails or Δ is out of bounds.
bool Solver::step(const Iterate& at, const Eigen::VectorXd& g, double lambda, Eigen::VectorXd& delta) {
  const int size = n_ * T_;
  for (int t = 0; t < T_; ++t) {
    const double diagonal = 1 + (t + 1 < T_ ? 4 : 0) + (t + 2 < T_ ? 1 : 0);
    for (int j = 0; j < n_; ++j) {
      const int column = t * n_ + j;
      for (int row = column; row <= std::min(size - 1, column + band_.width()); ++row) band_.at(row, column) = 0;
      for (int i = j; i < n_; ++i) band_.at(t * n_ + i, column) = at.models[t].R_qq(i, j);
      band_.at(column, column) += diagonal * curvature_[j] + lambda * scale_;
      if (t + 1 < T_) band_.at(column + n_, column) = (t + 2 < T_ ? -4 : -2) * curvature_[j];
      if (t + 2 < T_) band_.at(column + 2 * n_, column) = curvature_[j];
    }
  }
  for (int t = 0; t < T_; ++t) add_moving(at.models[t], t);
  if (!band_.factorise()) return false;
  delta = -g;
  band_.solve(delta);
  return delta.allFinite() && delta.cwiseAbs().maxCoeff() <= kLargestStep;
}

Solution Solver::solve(Eigen::MatrixXd q) {
  Iterate current, trial;
  current.q = std::move(q);
  const double unlimited = std::numeric_limits<double>::max();
  const bool finite = current.q.allFinite() && evaluate(current, unlimited);
  solution_.cost_initial = finite ? current.cost : 0;
  solution_.lambda = options_.lambda_initial;
  if (!finite) solution_.status = PlanStatus::bad_input;
  Eigen::VectorXd g, delta;
  bool stopped = !finite, fresh = true, factorised = true;
  double nu = 2;
  const auto reject = [&] {
    ++solution_.rejected;
    solution_.lambda = std::max(solution_.lambda, kLambdaMin) * nu;
    nu *= 2;
    if (solution_.lambda <= kLambdaMax) return;
    solution_.lambda = kLambdaMax;
    solution_.status = factorised ? PlanStatus::damping_limit : PlanStatus::factorisation_failed;
    stopped = true;
  };
  while (!stopped && solution_.iterations + solution_.rejected < options_.max_iterations) {
    if (fresh) g = gradient(current);
    fresh = false;
    factorised = step(current, g, solution_.lambda, delta);
    if (!factorised) {
      reject();
      continue;
    }
    const double size = delta.cwiseAbs().maxCoeff();
    // Twice the model's decrease: −(2 gᵀΔ + Δᵀ(A)Δ) with A Δ = −g − λ s Δ.
    const double predicted = -delta.dot(g) + solution_.lambda * scale_ * delta.squaredNorm();
    trial.q = current.q + Eigen::Map<const Eigen::MatrixXd>(delta.data(), n_, T_);
    if (!evaluate(trial, current.cost)) {
      // At a minimum rounding alone can keep the cost from falling.
      if (predicted <= 1e-12 * current.cost || size < 1e-10) {
        ++solution_.rejected;
        solution_.status = PlanStatus::converged_cost;
        break;
      }
      reject();
      continue;
    }
    const double decrease = current.cost - trial.cost, ratio = predicted > 0 ? decrease / predicted : 0;
    solution_.lambda *= std::max(1.0 / 3, 1 - std::pow(2 * std::clamp(ratio, 0.0, 1.0) - 1, 3));
    solution_.lambda = std::clamp(solution_.lambda, kLambdaMin, kLambdaMax);
    nu = 2;
    std::swap(current, trial);
    ++solution_.iterations;
    solution_.last_step = size;
    fresh = true;
    if (size < options_.step_tolerance && solution_.lambda <= options_.lambda_initial) {
      solution_.status = PlanStatus::converged_step;
      stopped = true;
    } else if (decrease <= options_.cost_tolerance * current.cost) {
      solution_.status = PlanStatus::converged_cost;
      stopped = true;
    }
  }
  if (finite) solution_.gradient_norm = gradient(current).cwiseAbs().maxCoeff();
  solution_.cost = finite ? current.cost : 0;
  solution_.cost_control = finite ? current.cost_control : 0;
  solution_.q = std::move(current.q);
  solution_.models = std::move(current.models);
  return std::move(solution_);
}

}  // namespace

Eigen::MatrixXd velocities(const TrajectoryProblem& problem, const Eigen::MatrixXd& q) {
  PRIMO_CHECK(q.rows() == problem.joints() && q.cols() == problem.steps, "a path has one column for each step 1 … T");
  Eigen::MatrixXd v(q.rows(), q.cols());
  v.col(0) = (q.col(0) - problem.q_start) / problem.dt;
  for (Eigen::Index t = 1; t < q.cols(); ++t) v.col(t) = (q.col(t) - q.col(t - 1)) / problem.dt;
  return v;
}

Eigen::MatrixXd controls(const TrajectoryProblem& problem, const Eigen::MatrixXd& q) {
  const Eigen::Index T = problem.steps;
  PRIMO_CHECK(q.rows() == problem.joints() && q.cols() == T, "a path has one column for each step 1 … T");
  Eigen::MatrixXd u(q.rows(), T);
  const double inverse = 1 / (problem.dt * problem.dt);
  for (Eigen::Index t = 0; t < T; ++t) {
    if (t == 0) {
      u.col(0) = inverse * (q.col(0) - problem.q_start - problem.dt * problem.v_start);
    } else if (t == 1) {
      u.col(1) = inverse * (q.col(1) - 2 * q.col(0) + problem.q_start);
    } else {
      u.col(t) = inverse * (q.col(t) - 2 * q.col(t - 1) + q.col(t - 2));
    }
  }
  return u;
}

double control_cost(const TrajectoryProblem& problem, const Eigen::MatrixXd& q) {
  return (controls(problem, q).array().square().colwise() * problem.H.array()).sum();
}

Solution gauss_newton(const TrajectoryProblem& problem, StageCosts& stages, Eigen::MatrixXd q,
                      const SolverOptions& options) {
  return Solver(problem, stages, options).solve(std::move(q));
}

}  // namespace primo::motion
