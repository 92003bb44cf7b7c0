#include <algorithm>
#include <cmath>
#include <utility>

#include "motion/banded.h"
#include "motion/path_model.h"
#include "motion/trajectory_problem.h"

namespace primo::motion {
namespace {

constexpr double kLambdaMin = 1e-9, kLambdaMax = 1e9;  // relative to the control cost's Hessian
constexpr double kLargestStep = 1e3;                   // rad; beyond that a step is an artefact of a singular system
constexpr double kLambdaSmall = 1e-3;  // with more damping a small step says little about the distance to the minimum
constexpr int kBacktracks = 3;
constexpr double kContraction = 0.4;
constexpr double kSmallestShare = 1e-3;  // rad; shorter steps are not tried

class Solver {
 public:
  Solver(const TrajectoryProblem& problem, StageCosts& stages, const SolverOptions& options)
      : problem_(problem),
        stages_(stages),
        options_(options),
        n_(problem.joints()),
        T_(problem.steps),
        // The scale makes λ a pure number: costs multiplied by c give the same path.
        scale_(6 * control_curvature(problem).mean()),
        band_(n_ * T_, std::min(2 * n_, n_ * T_ - 1)) {}

  Solution solve(Eigen::MatrixXd q);

 private:
  double search(const PathModel& at, const Eigen::VectorXd& delta, double size, PathModel& trial);
  bool step(const PathModel& at, const Eigen::VectorXd& gradient, double lambda, Eigen::VectorXd& step);

  const TrajectoryProblem& problem_;
  StageCosts& stages_;
  const SolverOptions& options_;
  const int n_, T_;
  const double scale_;
  BandMatrix band_;
  double share_ = 1;  // of the last step taken
  Solution solution_;
};

/// Δ = −(R + D + λ s I)⁻¹ g, D the control cost's Hessian; false when the factorisation fails or Δ is out of bounds.
bool Solver::step(const PathModel& at, const Eigen::VectorXd& g, double lambda, Eigen::VectorXd& delta) {
  assemble_hessian(problem_, at.models, lambda * scale_, band_);
  if (!band_.factorise()) return false;
  delta = -g;
  band_.solve(delta);
  return delta.allFinite() && delta.cwiseAbs().maxCoeff() <= kLargestStep;
}

/// Takes Δ, or the largest of a few shares of it, that lowers the cost; gives that share, 0 when none does. Proximities
/// begin with a kink: just beyond one, a part of the step is worth more than a new factorisation with more damping. A
/// step after a share begins one share larger: kinks come in rows.
double Solver::search(const PathModel& at, const Eigen::VectorXd& delta, double size, PathModel& trial) {
  double share = std::min(1.0, share_ / kContraction);
  for (int k = 0; k <= kBacktracks && (k == 0 || share * size > kSmallestShare); ++k, share *= kContraction) {
    trial.q = at.q + share * Eigen::Map<const Eigen::MatrixXd>(delta.data(), n_, T_);
    ++solution_.evaluations;
    if (evaluate(problem_, stages_, trial, at.cost)) return share_ = share;
  }
  return 0;
}

Solution Solver::solve(Eigen::MatrixXd q) {
  PathModel current, trial;
  current.q = std::move(q);
  const bool finite = begin(problem_, stages_, current, solution_);
  solution_.lambda = options_.lambda_initial;
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
    if (fresh) g = half_gradient(problem_, current);
    fresh = false;
    factorised = step(current, g, solution_.lambda, delta);
    if (!factorised) {
      reject();
      continue;
    }
    double size = delta.cwiseAbs().maxCoeff();
    // Twice the model's decrease: −(2 gᵀΔ + Δᵀ(A)Δ) with A Δ = −g − λ s Δ.
    const double predicted = -delta.dot(g) + solution_.lambda * scale_ * delta.squaredNorm();
    const double share = search(current, delta, size, trial);
    if (share == 0) {
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
    size *= share;
    solution_.lambda *= std::max(1.0 / 3, 1 - std::pow(2 * std::clamp(ratio, 0.0, 1.0) - 1, 3));
    solution_.lambda = std::clamp(solution_.lambda, kLambdaMin, kLambdaMax);
    nu = 2;
    std::swap(current, trial);
    ++solution_.iterations;
    solution_.last_step = size;
    fresh = true;
    if (size < options_.step_tolerance && solution_.lambda <= kLambdaSmall) {
      solution_.status = PlanStatus::converged_step;
      stopped = true;
    } else if (decrease <= options_.cost_tolerance * current.cost) {
      solution_.status = PlanStatus::converged_cost;
      stopped = true;
    }
  }
  finish(problem_, std::move(current), finite, solution_);
  return std::move(solution_);
}

}  // namespace

Solution gauss_newton(const TrajectoryProblem& problem, StageCosts& stages, Eigen::MatrixXd q,
                      const SolverOptions& options) {
  return Solver(problem, stages, options).solve(std::move(q));
}

}  // namespace primo::motion
