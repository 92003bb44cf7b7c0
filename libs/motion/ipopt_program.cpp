#include "motion/ipopt_program.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace primo::motion {
namespace {

constexpr double kLambdaMin = 1e-9, kLambdaMax = 1e9;
constexpr double kUnbounded = 1e19, kNoBound = 1e20;  // Ipopt takes what is beyond ±1e19 as no bound

}  // namespace

/// The inverse of the least control cost of moving every joint by a radian from rest: ∫ q̈² of the cubic to a
/// displacement d with a free final velocity is 3 d² / D³.
double cost_scale(const TrajectoryProblem& problem) {
  const double duration = problem.steps * problem.dt;
  return duration * duration * duration * problem.dt / (3 * problem.H.mean());
}

int barrier_terms(const TrajectoryProblem& problem, const HardConstraints& constraints) {
  int terms = 0;
  for (const auto& rows : constraints.rows) terms += static_cast<int>(rows.size());
  if (!constraints.limits) return terms;
  const auto finite = (problem.q_lower.array() > -kUnbounded).count() + (problem.q_upper.array() < kUnbounded).count();
  return terms + problem.steps * static_cast<int>(finite);
}

double violation(const TrajectoryProblem& problem, StageCosts& stages, const Eigen::MatrixXd& q,
                 std::vector<Eigen::VectorXd>& c) {
  double worst = 0;
  Eigen::VectorXd q_t;
  c.resize(problem.steps);
  for (int t = 1; t <= problem.steps; ++t) {
    Eigen::VectorXd& at = c[t - 1];
    at.resize(stages.inequalities());
    q_t = q.col(t - 1);
    if (at.size() > 0) stages.inequality(t, q_t, at, nullptr);
    if (at.size() > 0) worst = std::max(worst, -at.minCoeff());
  }
  return worst;
}

IpoptProgram::IpoptProgram(const TrajectoryProblem& problem, StageCosts& stages, const SolverOptions& options,
                           HardConstraints constraints, PathModel start, BestPath& best, Usage& usage)
    : problem_(problem),
      stages_(stages),
      options_(options),
      constraints_(std::move(constraints)),
      n_(problem.joints()),
      T_(problem.steps),
      size_(n_ * T_),
      bounded_(barrier_terms(problem, constraints_) > 0),
      scale_(cost_scale(problem)),
      path_(std::move(start)),
      band_(size_, std::min(2 * n_, size_ - 1)),
      best_(best),
      usage_(usage),
      cost_before_(path_.cost) {
  damping_scale_ = 6 * control_curvature(problem).mean();
  trials_before_ = usage_.trials;
  find_structure(path_);
  for (const auto& rows : constraints_.rows) rows_ += static_cast<int>(rows.size());
  if (!constraints_.rows.empty()) violation(problem_, stages_, path_.q, c_);
}

/// Which entries the Hessian has: full blocks of a step's tasks, the control cost's couplings by joint, and full
/// couplings where a task depends on v.
void IpoptProgram::find_structure(const PathModel& start) {
  for (int t = 0; t < T_; ++t) {
    const bool coupled = t + 1 < T_ && start.models[t + 1].moving;
    for (int j = 0; j < n_; ++j) {
      const int column = t * n_ + j;
      for (int i = j; i < n_; ++i) entries_.emplace_back(t * n_ + i, column);
      for (int i = 0; i < n_ && t + 1 < T_; ++i) {
        if (coupled || i == j) entries_.emplace_back((t + 1) * n_ + i, column);
      }
      if (t + 2 < T_) entries_.emplace_back(column + 2 * n_, column);
    }
  }
}

bool IpoptProgram::get_nlp_info(Index& n, Index& m, Index& jacobian, Index& hessian, IndexStyleEnum& style) {
  n = size_;
  m = rows_;
  jacobian = rows_ * n_;
  hessian = static_cast<Index>(entries_.size());
  style = C_STYLE;
  return true;
}

bool IpoptProgram::get_bounds_info(Index, Number* x_l, Number* x_u, Index m, Number* g_l, Number* g_u) {
  std::fill(x_l, x_l + size_, -kNoBound);
  std::fill(x_u, x_u + size_, kNoBound);
  for (int k = 0; k < size_ && constraints_.limits; ++k) {
    x_l[k] = std::max(problem_.q_lower[k % n_], -kNoBound);
    x_u[k] = std::min(problem_.q_upper[k % n_], kNoBound);
  }
  std::fill(g_l, g_l + m, 0.0);
  std::fill(g_u, g_u + m, kNoBound);
  return true;
}

bool IpoptProgram::get_starting_point(Index, bool init_x, Number* x, bool init_z, Number*, Number*, Index,
                                      bool init_lambda, Number*) {
  if (init_x) std::copy_n(path_.q.data(), size_, x);
  return !init_z && !init_lambda;
}

/// Evaluates the path x unless it is where Ipopt is already. False when its cost is not finite or the allowance of
/// steps is used up: Ipopt then shortens its step until it gives up.
bool IpoptProgram::move_to(const Number* x) {
  if (std::memcmp(x, path_.q.data(), sizeof(Number) * static_cast<std::size_t>(size_)) == 0) return usable_;
  if (started_) {
    if (stopped_ || usage_.trials >= options_.max_iterations) {
      stop(PlanStatus::iteration_limit);
      return false;
    }
    ++usage_.trials;
  }
  std::copy_n(x, size_, path_.q.data());
  ++usage_.evaluations;
  usable_ = path_.q.allFinite() && evaluate(problem_, stages_, path_, std::numeric_limits<double>::max());
  if (usable_) compare_with_best();
  return usable_;
}

void IpoptProgram::compare_with_best() {
  const double missed = constraints_.rows.empty() ? 0 : violation(problem_, stages_, path_.q, c_);
  const double ours = std::max(missed, kFeasible), theirs = std::max(best_.violation, kFeasible);
  if (ours > theirs || (ours == theirs && path_.cost >= best_.cost)) return;
  best_.q = path_.q;
  best_.cost = path_.cost;
  best_.violation = missed;
}

bool IpoptProgram::eval_f(Index, const Number* x, bool, Number& value) {
  if (!move_to(x)) return false;
  value = scale_ * path_.cost;
  return true;
}

bool IpoptProgram::eval_grad_f(Index, const Number* x, bool, Number* gradient) {
  if (!move_to(x)) return false;
  Eigen::Map<Eigen::VectorXd>(gradient, size_) = 2 * scale_ * half_gradient(problem_, path_);
  return true;
}

bool IpoptProgram::eval_g(Index, const Number* x, bool, Index, Number* g) {
  if (!move_to(x)) return false;
  for (std::size_t t = 0; t < constraints_.rows.size(); ++t)
    for (const int row : constraints_.rows[t]) *g++ = c_[t][row];
  return true;
}

bool IpoptProgram::eval_jac_g(Index, const Number* x, bool, Index, Index, Index* rows, Index* columns, Number* values) {
  if (values && !move_to(x)) return false;
  Eigen::VectorXd c(stages_.inequalities());
  Eigen::MatrixXd J(stages_.inequalities(), n_);
  Index number = 0;
  for (std::size_t t = 0; t < constraints_.rows.size(); ++t) {
    if (constraints_.rows[t].empty()) continue;
    if (values) stages_.inequality(static_cast<int>(t) + 1, path_.q.col(static_cast<Eigen::Index>(t)), c, &J);
    for (const int row : constraints_.rows[t]) {
      for (int i = 0; i < n_; ++i) {
        if (values) {
          *values++ = J(row, i);
        } else {
          *rows++ = number;
          *columns++ = static_cast<int>(t) * n_ + i;
        }
      }
      ++number;
    }
  }
  return true;
}

bool IpoptProgram::eval_h(Index, const Number* x, bool, Number factor, Index, const Number*, bool, Index, Index* rows,
                          Index* columns, Number* values) {
  if (!values) {
    for (const auto& [row, column] : entries_) {
      *rows++ = row;
      *columns++ = column;
    }
    return true;
  }
  if (!move_to(x)) return false;
  assemble_hessian(problem_, path_.models, usage_.lambda * damping_scale_, band_);
  for (const auto& [row, column] : entries_) *values++ = 2 * factor * scale_ * band_.at(row, column);
  return true;
}

/// Undamped steps are shortened three times on average, and each of them costs a factorisation.
void IpoptProgram::adapt_damping() {
  const int rejected = usage_.trials - trials_before_ - 1;
  usage_.lambda = rejected > 0 ? std::max(usage_.lambda, kLambdaMin) * std::pow(2, rejected) : usage_.lambda / 3;
  usage_.lambda = std::min(usage_.lambda, kLambdaMax);
  trials_before_ = usage_.trials;
}

bool IpoptProgram::stop(PlanStatus status) {
  if (!stopped_) status_ = status;
  stopped_ = true;
  return false;
}

/// By the same criteria as gauss_newton, once the constraints hold. The barrier is already so low that the last digits
/// of its minimum do not matter; waiting for them could take forever, as the cost of collisions has kinks.
bool IpoptProgram::converged(double cost, double inf_pr, double regularization, double alpha) const {
  if (bounded_ && inf_pr > kFeasible) return false;
  const bool full = regularization == 0 && alpha == 1 && usage_.lambda <= options_.lambda_initial;
  return (full && usage_.last_step < options_.step_tolerance) ||
         std::abs(cost_before_ - cost) <= std::max(options_.cost_tolerance, 1e-15) * cost;
}

bool IpoptProgram::intermediate_callback(Ipopt::AlgorithmMode mode, Index iteration, Number value, Number inf_pr,
                                         Number, Number, Number d_norm, Number regularization, Number, Number alpha,
                                         Index, const Ipopt::IpoptData*, Ipopt::IpoptCalculatedQuantities*) {
  started_ = true;
  if (stopped_) return false;
  const double cost = value / scale_;
  if (iteration > 0) {
    ++usage_.iterations;
    adapt_damping();
    usage_.last_step = alpha * d_norm;
    if (mode == Ipopt::RegularMode && converged(cost, inf_pr, regularization, alpha)) {
      return stop(usage_.last_step < options_.step_tolerance ? PlanStatus::converged_step : PlanStatus::converged_cost);
    }
  }
  cost_before_ = cost;
  return usage_.trials < options_.max_iterations || stop(PlanStatus::iteration_limit);
}

}  // namespace primo::motion
