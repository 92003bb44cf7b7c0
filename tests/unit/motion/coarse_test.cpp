// Paths over few steps: what they share with the fine problem that they stand for.
#include "motion/coarse.h"

#include <gtest/gtest.h>

#include <cmath>

#include "problems.h"

namespace primo::motion {
namespace {

/// Counts how often each fine step is evaluated: Φ_t² = 1 at every step t, but `last` at T; no dependence on q.
class ConstantStages final : public StageCosts {
 public:
  ConstantStages(int n, int steps, double last) : n_(n), steps_(steps), last_(last) {}
  double evaluate(int t, const Eigen::VectorXd&, const Eigen::VectorXd&, StageModel* model) override {
    if (model) {
      model->R_qq = Eigen::MatrixXd::Identity(n_, n_);
      model->r_q = Eigen::VectorXd::Ones(n_);
    }
    return t == steps_ ? last_ : 1.0;
  }

 private:
  int n_, steps_;
  double last_;
};

TEST(CoarseStages, StandForEveryFineStepOnceAndForTheLastOneAlone) {
  for (const int T : {1, 2, 7, 32, 64, 100}) {
    for (const int K : {1, 2, 8, 16}) {
      if (K > T) continue;
      const auto problem = make_problem(2, T, 1);
      ConstantStages stages(2, T, 1000);
      CoarseStages coarse(problem, stages, K);
      double sum = 0;
      for (int k = 1; k <= K; ++k) {
        StageModel model;
        const double cost = coarse.evaluate(k, problem.q_start, problem.v_start, &model);
        // What weights a cost weights its model: here their ratio is known but at the last step.
        if (k < K) {
          EXPECT_NEAR(model.R_qq(0, 0), cost, 1e-12);
        }
        sum += cost;
      }
      // The interval before the first coarse step is half left out: q_0 itself costs nothing.
      const double first = std::lround(static_cast<double>(T) / K);
      const double expected = K == T ? T - 1 : T - 1 - 0.5 * first + 0.5;
      EXPECT_NEAR(sum - 1000, expected, 1e-9) << T << " " << K;
    }
  }
}

TEST(CoarseStages, OfAsManyStepsAreTheFineProblem) {
  const int T = 9;
  const auto problem = make_problem(3, T, 5);
  auto stages = make_linear(3, T, 4, 5);
  CoarseStages coarse(problem, stages, T);
  const Eigen::MatrixXd start = problem.q_start.replicate(1, T);
  const auto solution = gauss_newton(coarse.problem(), coarse, start, exact());
  EXPECT_LT((solution.q - dense_solution(problem, stages)).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((coarse.refine(solution.q) - solution.q).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(CoarseStages, RefineACubicThatEndsWithoutAccelerationExactly) {
  for (const int T : {12, 64, 100}) {
    auto problem = make_problem(2, T, 3);
    const double D = T * problem.dt;
    // q(s) = q_0 + v_0 s + c (s³ − 3 D s²) has q̈(D) = 0.
    const Eigen::Vector2d c(0.3, -0.2);
    const auto at = [&](double s) {
      return Eigen::VectorXd(problem.q_start + s * problem.v_start + (s * s * s - 3 * D * s * s) / (D * D) * c);
    };
    ConstantStages stages(2, T, 1);
    const CoarseStages coarse(problem, stages, 8);
    Eigen::MatrixXd fine(2, T);
    for (int t = 1; t <= T; ++t) fine.col(t - 1) = at(problem.dt * t);
    EXPECT_LT((coarse.refine(coarse.sample(fine)) - fine).cwiseAbs().maxCoeff(),
              1e-10 * (1 + fine.cwiseAbs().maxCoeff()));
  }
}

TEST(CoarseStages, RefinementIsTheSmoothestPathThroughItsPoints) {
  // Minimum of ∫ q̈²: no other path through the same points at the fine steps has less Σ u². The discrete sum differs
  // from the integral by O(τ), hence the slack.
  auto problem = make_problem(1, 64, 7);
  problem.v_start.setZero();
  ConstantStages stages(1, 64, 1);
  const CoarseStages coarse(problem, stages, 8);
  Random random(1, "coarse_test");
  Eigen::MatrixXd points(1, 8);
  for (int k = 0; k < 8; ++k) points(0, k) = random.normal();
  const Eigen::MatrixXd path = coarse.refine(points);
  const double least = control_cost(problem, path);
  for (int trial = 0; trial < 50; ++trial) {
    // A bump between two knots that keeps value and slope at both.
    const int k = static_cast<int>(random.uniform(0, 8));
    const double size = random.uniform(-0.3, 0.3);
    Eigen::MatrixXd other = path;
    for (int i = 1; i < 8; ++i) {
      const double x = i / 8.0;
      other(0, 8 * k + i - 1) += size * 16 * x * x * (1 - x) * (1 - x);
    }
    EXPECT_GT(control_cost(problem, other), 0.98 * least);
  }
}

TEST(CoarseStages, RankStraightLinesByTheSameControlCost) {
  // q̈ constant: u is the same at any step length, so the cost is the same integral.
  auto problem = make_problem(2, 64, 9);
  problem.v_start.setZero();
  ConstantStages stages(2, 64, 1);
  const CoarseStages coarse(problem, stages, 8);
  Eigen::MatrixXd fine(2, 64);
  for (int t = 1; t <= 64; ++t) fine.col(t - 1) = problem.q_start + 0.01 * t * (t + 1) * Eigen::Vector2d(1, -2);
  Eigen::MatrixXd knots(2, 8);
  for (int k = 1; k <= 8; ++k) knots.col(k - 1) = problem.q_start + 0.64 * k * (k + 1) * Eigen::Vector2d(1, -2);
  EXPECT_NEAR(control_cost(coarse.problem(), knots), control_cost(problem, fine), 1e-9 * control_cost(problem, fine));
}

}  // namespace
}  // namespace primo::motion
