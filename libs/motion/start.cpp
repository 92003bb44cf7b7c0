#include "motion/start.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/random.h"

namespace primo::motion {
namespace {

constexpr int kInverseKinematicsIterations = 60;
constexpr std::uint64_t kWristGuesses = 2, kRandomGuesses = 3;

/// q_0 with joints `from` … `to` − 1 drawn within their limits.
Eigen::VectorXd guess(const TrajectoryProblem& problem, int from, int to, std::uint64_t k) {
  Random random(0, "motion.start", {k});
  Eigen::VectorXd q = problem.q_start;
  for (int i = 0; i < problem.q_lower.size(); ++i) {
    const double value = random.uniform(problem.q_lower[i], problem.q_upper[i]);
    if (i >= from && i < to) q[i] = value;
  }
  return q;
}

Start ik_start(const TrajectoryProblem& problem, StageCosts& stages, const std::string& name,
               const std::vector<Eigen::VectorXd>& guesses) {
  Reach best;
  for (const auto& q_guess : guesses) {
    Reach reach = inverse_kinematics(problem, stages, q_guess, kInverseKinematicsIterations);
    if (best.q.size() == 0 || reach.cost < best.cost) best = std::move(reach);
  }
  return {name, minimum_jerk(problem, best.q)};
}

/// From q_0 and from a few other turns of the wrist: how the hand comes at the target decides the basin.
Start ik_start(const TrajectoryProblem& problem, StageCosts& stages) {
  std::vector<Eigen::VectorXd> guesses = {problem.q_start};
  const int wrist = problem.arm_joints;
  for (std::uint64_t k = 1; k <= kWristGuesses; ++k) guesses.push_back(guess(problem, wrist - 3, wrist, k));
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
    starts.push_back(ik_start(problem, stages, "ik_" + std::to_string(k), {guess(problem, 0, problem.joints(), k)}));
  return starts;
}

}  // namespace

const std::vector<StartEntry>& starts() {
  static const std::vector<StartEntry> table = {
      {"rest", "standing still"},
      {"ik",
       "minimum-jerk motion to the best that inverse kinematics by the same costs reaches from three turns of the "
       "wrist"},
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
    if (delta.cwiseAbs().maxCoeff() < 1e-4 || decrease < 1e-6 * cost) break;
  }
  return {q, cost};
}

}  // namespace primo::motion
