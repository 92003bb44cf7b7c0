#include "motion/start.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/random.h"
#include "motion/coarse.h"

namespace primo::motion {
namespace {

constexpr int kInverseKinematicsIterations = 60;
constexpr std::uint64_t kRandomGuesses = 3;

// How the hand comes at the target decides the basin. Turns of the arm's last three joints to guess from, as fractions
// of their limits: those of 84 that together led to the least costs over 400 random scenes (0106).
constexpr std::array<std::array<double, 3>, 3> kWristTurns = {
    {{0.17, 0.83, 0.50}, {0.90, 0.68, 0.59}, {0.83, 0.83, 0.17}}};

// Of the coarse paths that tell basins apart, and of the one between them and a long path.
constexpr int kCoarseSteps = 8, kMiddleSteps = 16, kLongPath = 3 * kMiddleSteps;
constexpr int kCoarseIterations = 6;
constexpr double kCoarseStepTolerance = 3e-2;  // rad
constexpr double kCoarseCostTolerance = 2e-2;
constexpr double kCoarseLambda = 1e-3;  // long steps meet more kinks: less of each

/// A random configuration within the limits, or q_0 where there are none.
Eigen::VectorXd random_guess(const TrajectoryProblem& problem, std::uint64_t k) {
  Random random(0, "motion.start", {k});
  Eigen::VectorXd q = problem.q_start;
  for (int i = 0; i < problem.q_lower.size(); ++i) q[i] = random.uniform(problem.q_lower[i], problem.q_upper[i]);
  return q;
}

Solution solve_coarse(CoarseStages& coarse, Eigen::MatrixXd q) {
  SolverOptions options;
  options.max_iterations = kCoarseIterations;
  options.step_tolerance = kCoarseStepTolerance;
  options.cost_tolerance = kCoarseCostTolerance;
  options.lambda_initial = kCoarseLambda;
  return gauss_newton(coarse.problem(), coarse, std::move(q), options);
}

/// The best of the minimum-jerk motions to what inverse kinematics reaches from the guesses, each solved over a few
/// coarse steps, and refined.
Start ik_start(const TrajectoryProblem& problem, StageCosts& stages, const std::string& name,
               const std::vector<Eigen::VectorXd>& guesses) {
  CoarseStages coarse(problem, stages, std::min(problem.steps, kCoarseSteps));
  std::optional<Solution> best;
  Eigen::VectorXd q_goal = guesses.front();
  for (const auto& q_guess : guesses) {
    const Reach reach = inverse_kinematics(problem, stages, q_guess, kInverseKinematicsIterations);
    Solution solution = solve_coarse(coarse, minimum_jerk(coarse.problem(), reach.q));
    if (solution.status == PlanStatus::bad_input || (best && !(solution.cost < best->cost))) continue;
    best = std::move(solution);
    q_goal = reach.q;
  }
  if (!best) return {name, minimum_jerk(problem, q_goal)};
  Eigen::MatrixXd path = coarse.refine(best->q);
  if (problem.steps < kLongPath) return {name, std::move(path)};
  CoarseStages middle(problem, stages, kMiddleSteps);
  return {name, middle.refine(solve_coarse(middle, middle.sample(path)).q)};
}

/// From q_0 and from a few other turns of the wrist.
Start ik_start(const TrajectoryProblem& problem, StageCosts& stages) {
  std::vector<Eigen::VectorXd> guesses = {problem.q_start};
  const Eigen::Index first = problem.arm_joints - 3;
  if (first >= 0 && problem.q_lower.size() == problem.joints()) {
    for (const auto& turn : kWristTurns) {
      const auto lower = problem.q_lower.segment<3>(first), upper = problem.q_upper.segment<3>(first);
      Eigen::VectorXd q = problem.q_start;
      q.segment<3>(first) = lower + Eigen::Map<const Eigen::Array3d>(turn.data()).matrix().cwiseProduct(upper - lower);
      guesses.push_back(std::move(q));
    }
  }
  return ik_start(problem, stages, "ik", guesses);
}

Result<Start> last_start(const TrajectoryProblem& problem, const Eigen::MatrixXd& last) {
  if (last.rows() < 2 || last.cols() != problem.joints() || !last.allFinite()) {
    return Error{Code::data, "start: 'last' needs the last plan, finite, of at least 2 rows of " +
                                 std::to_string(problem.joints()) + " joints; this one has " +
                                 std::to_string(last.rows()) + " rows of " + std::to_string(last.cols())};
  }
  Start start{"last", Eigen::MatrixXd(problem.joints(), problem.steps)};
  const Eigen::VectorXd shift = problem.q_start - last.row(0).transpose();
  for (int t = 1; t <= problem.steps; ++t) {
    const double at = static_cast<double>(t) / problem.steps * static_cast<double>(last.rows() - 1);
    const auto row = std::min(static_cast<Eigen::Index>(at), last.rows() - 2);
    const double share = at - static_cast<double>(row);
    start.q.col(t - 1) = ((1 - share) * last.row(row) + share * last.row(row + 1)).transpose() + shift;
  }
  return start;
}

std::vector<Start> several_starts(const TrajectoryProblem& problem, StageCosts& stages) {
  std::vector<Start> starts = {ik_start(problem, stages),
                               ik_start(problem, stages, "ik_rest", {problem.q_start}),
                               {"rest", rest_start(problem)}};
  for (std::uint64_t k = 1; k <= kRandomGuesses; ++k)
    starts.push_back(ik_start(problem, stages, "ik_" + std::to_string(k), {random_guess(problem, k)}));
  return starts;
}

}  // namespace

const std::vector<StartEntry>& starts() {
  static const std::vector<StartEntry> table = {
      {"rest", "standing still"},
      {"ik",
       "minimum-jerk motions to what inverse kinematics by the same costs reaches from four turns of the wrist, each "
       "solved over eight coarse steps; the best of them, refined"},
      {"last", "the last plan, stretched to the steps and shifted to the start"},
      {"best",
       "the best outcome of ik, rest and inverse kinematics from the start and from three random configurations"},
  };
  return table;
}

Result<std::vector<Start>> make_starts(const TrajectoryProblem& problem, StageCosts& stages, const std::string& name,
                                       const Eigen::MatrixXd& last) {
  if (name == "rest") return std::vector<Start>{{name, rest_start(problem)}};
  if (name == "ik") return std::vector<Start>{ik_start(problem, stages)};
  if (name == "best") return several_starts(problem, stages);
  if (name == "last") {
    PRIMO_ASSIGN(auto start, last_start(problem, last));
    return std::vector<Start>{std::move(start)};
  }
  return Error{Code::data, "start: no '" + name + "'"};
}

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

Reach inverse_kinematics(const TrajectoryProblem& problem, StageCosts& stages, const Eigen::VectorXd& q_guess,
                         int max_iterations) {
  const int n = problem.joints(), T = problem.steps;
  const double duration = T * problem.dt;
  // ∫ q̈² of the cubic from rest to a displacement d with a free final velocity is 3 d² / D³.
  const Eigen::VectorXd effort = 3 / (duration * duration * duration) * problem.H / problem.dt;
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(n);
  Eigen::VectorXd q = q_guess;
  StageModel model, trial;
  double cost = stages.evaluate(T, q, still, &model);
  if (!std::isfinite(cost)) return {q, std::numeric_limits<double>::infinity()};
  cost += effort.dot((q - problem.q_start).cwiseAbs2());
  double lambda = 1e-3, nu = 2;
  for (int iteration = 0; iteration < max_iterations && lambda < 1e12; ++iteration) {
    Eigen::MatrixXd A = model.R_qq;
    A.diagonal() += effort;
    A.diagonal().array() += lambda;
    const Eigen::VectorXd g = model.r_q + effort.cwiseProduct(q - problem.q_start);
    const Eigen::LLT<Eigen::MatrixXd> llt(A);
    Eigen::VectorXd delta = llt.info() == Eigen::Success ? Eigen::VectorXd(-llt.solve(g)) : Eigen::VectorXd();
    double trial_cost = std::numeric_limits<double>::infinity();
    // Steps beyond a radian leave the region where the linearisation of a revolute chain means anything.
    const bool usable = delta.size() > 0 && delta.allFinite();
    if (usable) {
      const double largest = delta.cwiseAbs().maxCoeff();
      if (largest > 1) delta /= largest;
      const Eigen::VectorXd q_trial = q + delta;
      trial_cost = stages.evaluate(T, q_trial, still, &trial) + effort.dot((q_trial - problem.q_start).cwiseAbs2());
    }
    if (!(trial_cost < cost) || !trial.r_q.allFinite()) {
      lambda *= nu;
      nu *= 2;
      continue;
    }
    const double decrease = cost - trial_cost;
    q += delta;
    cost = trial_cost;
    std::swap(model, trial);
    lambda = std::max(lambda / 3, 1e-9);
    nu = 2;
    if (delta.cwiseAbs().maxCoeff() < 3e-3 || decrease < 3e-5 * cost) break;
  }
  return {q, cost};
}

}  // namespace primo::motion
