// The solver on problems with known answers, free of any robot.
#include <gtest/gtest.h>

#include <cmath>

#include "motion/banded.h"
#include "problems.h"

namespace primo::motion {
namespace {

TEST(BandMatrix, SolvesAsADenseFactorisationDoes) {
  for (const int size : {1, 2, 3, 5, 8, 40, 131}) {
    for (const int wanted : {0, 1, 2, 3, 4, 7, 28}) {
      const int width = std::min(wanted, size - 1);
      Random random(1, "band", {static_cast<std::uint64_t>(size), static_cast<std::uint64_t>(width)});
      BandMatrix band(size, width);
      Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(size, size);
      for (int j = 0; j < size; ++j) {
        for (int i = j; i <= std::min(size - 1, j + width); ++i) {
          band.at(i, j) = dense(i, j) = dense(j, i) = i == j ? 20 : random.uniform(-0.5, 0.5);
        }
      }
      const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(size, -1, 2);
      Eigen::VectorXd x = b;
      ASSERT_TRUE(band.factorise());
      band.solve(x);
      EXPECT_LT((dense * x - b).norm(), 1e-12);
    }
  }
}

TEST(BandMatrix, RefusesWhatIsNotPositiveDefinite) {
  for (const double bad : {0.0, -1.0, double(NAN), double(INFINITY), 0.5}) {
    BandMatrix band(2, 1);
    band.at(0, 0) = bad == 0.5 ? 1 : bad;
    band.at(1, 0) = 2;
    band.at(1, 1) = 1;
    EXPECT_FALSE(band.factorise()) << bad;
  }
}

TEST(GaussNewton, SolvesLinearTasksInOneStepAsADenseSolverDoes) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto problem = make_problem(4, 12, seed);
    auto stages = make_linear(4, 12, 6, seed);
    auto options = exact();
    options.max_iterations = 1;
    const auto solution = gauss_newton(problem, stages, problem.q_start.replicate(1, 12), options);
    EXPECT_EQ(solution.iterations, 1);
    EXPECT_LT((solution.q - dense_solution(problem, stages)).cwiseAbs().maxCoeff(), 1e-8) << seed;
  }
}

TEST(GaussNewton, SolvesLinearTasksOnVelocitiesInOneStepAsADenseSolverDoes) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto problem = make_problem(4, 12, seed);
    auto stages = make_moving(4, 12, 6, seed);
    auto options = exact();
    options.max_iterations = 1;
    const auto solution = gauss_newton(problem, stages, problem.q_start.replicate(1, 12), options);
    EXPECT_EQ(solution.iterations, 1);
    EXPECT_LT((solution.q - dense_solution(problem, stages)).cwiseAbs().maxCoeff(), 1e-7) << seed;
  }
}

TEST(GaussNewton, IsAccurateWithPrecisionsOverTwelveDecades) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto problem = make_problem(4, 12, seed);
    auto stages = make_linear(4, 12, 12, seed);
    const auto solution = gauss_newton(problem, stages, problem.q_start.replicate(1, 12), exact());
    EXPECT_LT((solution.q - dense_solution(problem, stages)).cwiseAbs().maxCoeff(), 1e-6) << seed;
  }
}

TEST(GaussNewton, DrivesAPointMassAsTheRiccatiRecursionDoes) {
  const int T = 50;
  const double rho = 1e2;
  const TrajectoryProblem problem{T, 0.05, scalar(0.05), scalar(1), scalar(1), {}, {}, 0};
  auto stages = point_mass_stages(T, rho);
  const auto solution = gauss_newton(problem, stages, problem.q_start.replicate(1, T), exact());
  std::vector<Eigen::RowVector2d> K;
  point_mass_gains(problem.dt, problem.H[0], rho, T, K);
  const auto gains = riccati_gains(problem, solution.q, solution.models);
  Eigen::Vector2d x(1, 1);
  for (int t = 0; t < T; ++t) {
    EXPECT_LT((gains.K[t] - K[t]).norm(), 1e-8 * K[t].norm() + 1e-10) << t;
    const double u = K[t].transpose().dot(x);
    EXPECT_NEAR(gains.k[t][0], u, 1e-7);
    x[1] += problem.dt * u;
    x[0] += problem.dt * x[1];
    EXPECT_NEAR(solution.q(0, t), x[0], 1e-9) << t;
  }
}

TEST(RiccatiGains, OfALongHorizonSolveTheDiscreteAlgebraicRiccatiEquation) {
  const int T = 2000;
  const double tau = 0.05, h = 0.05, rho = 1e2;
  const TrajectoryProblem problem{T, tau, scalar(h), scalar(1), scalar(0), {}, {}, 0};
  StageModel stage;
  stage.R_qq = Eigen::MatrixXd::Constant(1, 1, rho);
  const std::vector<StageModel> models(T, stage);
  const auto gains = riccati_gains(problem, Eigen::MatrixXd::Ones(1, T), models);
  // The stationary P by the structure-preserving doubling algorithm.
  Eigen::Matrix2d A, I = Eigen::Matrix2d::Identity(), P = Eigen::Matrix2d::Zero();
  A << 1, tau, 0, 1;
  P(0, 0) = rho;
  const Eigen::Vector2d B(tau * tau, tau);
  Eigen::Matrix2d Ak = A, G = B * B.transpose() / h;
  for (int k = 0; k < 40; ++k) {
    const Eigen::Matrix2d W = (I + G * P).inverse();
    const Eigen::Matrix2d next = P + Ak.transpose() * P * W * Ak;
    G += Ak * W * G * Ak.transpose();
    Ak = Ak * W * Ak;
    P = next;
  }
  const Eigen::RowVector2d K = -(B.transpose() * P * A) / (h + B.dot(P * B));
  EXPECT_LT((gains.K[0] - K).norm(), 1e-9 * K.norm());
}

void expect_gains_are_slopes(LinearStages stages, int n, int T) {
  auto problem = make_problem(n, T, 4);
  const auto solve = [&](const TrajectoryProblem& changed) {
    const auto solution = gauss_newton(changed, stages, changed.q_start.replicate(1, T), exact());
    return Eigen::VectorXd(controls(changed, solution.q).col(0));
  };
  const auto solution = gauss_newton(problem, stages, problem.q_start.replicate(1, T), exact());
  const auto gains = riccati_gains(problem, solution.q, solution.models);
  EXPECT_LT((gains.k[0] - solve(problem)).norm(), 1e-9);
  for (int i = 0; i < 2 * n; ++i) {
    auto ahead = problem, behind = problem;
    (i < n ? ahead.q_start[i] : ahead.v_start[i - n]) += 1e-3;
    (i < n ? behind.q_start[i] : behind.v_start[i - n]) -= 1e-3;
    const Eigen::VectorXd slope = (solve(ahead) - solve(behind)) / 2e-3;
    EXPECT_LT((gains.K[0].col(i) - slope).norm(), 1e-6 * (1 + slope.norm())) << i;
  }
}

TEST(RiccatiGains, AreTheSlopesOfTheFirstControl) {
  expect_gains_are_slopes(make_linear(3, 10, 4, 4), 3, 10);
  expect_gains_are_slopes(make_moving(3, 10, 4, 4), 3, 10);
}

TEST(GaussNewton, RestToRestTendsToTheCubicAsStepsShrink) {
  double before = 1;
  for (const int T : {20, 40, 80, 160}) {
    const TrajectoryProblem problem{T, 1.0 / T, scalar(1.0 / T), scalar(0), scalar(0), {}, {}, 0};
    LinearStages stages;
    stages.J.assign(T, Eigen::MatrixXd::Zero(1, 1));
    stages.y.assign(T, scalar(0));
    for (const int t : {T - 2, T - 1}) {  // both at the goal: at rest there
      stages.J[t](0, 0) = 1e5;
      stages.y[t][0] = 1e5;
    }
    const auto solution = gauss_newton(problem, stages, Eigen::MatrixXd::Zero(1, T), exact());
    double error = 0;
    for (int t = 1; t <= T; ++t) {
      const double x = static_cast<double>(t) / T;
      error = std::max(error, std::abs(solution.q(0, t - 1) - x * x * (3 - 2 * x)));
    }
    EXPECT_LT(error, 0.62 * before) << T;  // first order in τ
    before = error;
  }
  EXPECT_LT(before, 0.02);
}

TEST(GaussNewton, NeverRaisesTheCost) {
  auto problem = make_problem(2, 20, 9);
  CurvedStages stages;
  double before = INFINITY;
  for (int limit = 1; limit < 40; ++limit) {
    SolverOptions options;
    options.max_iterations = limit;
    const auto solution = gauss_newton(problem, stages, problem.q_start.replicate(1, 20), options);
    EXPECT_LE(solution.cost, before) << limit;
    EXPECT_LE(solution.cost, solution.cost_initial);
    before = solution.cost;
  }
}

TEST(GaussNewton, StopsAtOnceWhenStartedAtASolution) {
  auto problem = make_problem(2, 20, 9);
  CurvedStages stages;
  SolverOptions fine;
  fine.step_tolerance = 1e-9;
  fine.cost_tolerance = 1e-14;
  fine.max_iterations = 500;
  const auto solution = gauss_newton(problem, stages, problem.q_start.replicate(1, 20), fine);
  EXPECT_LT(solution.gradient_norm, 1e-5);
  const auto again = gauss_newton(problem, stages, solution.q, {});
  EXPECT_LE(again.iterations + again.rejected, 1);
  EXPECT_LT((again.q - solution.q).cwiseAbs().maxCoeff(), 1e-4);
  EXPECT_TRUE(again.status == PlanStatus::converged_step || again.status == PlanStatus::converged_cost);
}

TEST(GaussNewton, ScalingEveryCostLeavesThePathUnchanged) {
  const auto problem = make_problem(2, 20, 11);
  CurvedStages stages;
  const auto solution = gauss_newton(problem, stages, problem.q_start.replicate(1, 20), {});
  for (const double c : {1.0 / 1024, 4096.0}) {
    auto scaled = problem;
    scaled.H *= c;
    CurvedStages scaled_stages;
    scaled_stages.scale = c;
    const auto other = gauss_newton(scaled, scaled_stages, problem.q_start.replicate(1, 20), {});
    EXPECT_LT((other.q - solution.q).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_NEAR(other.cost, c * solution.cost, 1e-9 * c * solution.cost);
    EXPECT_EQ(other.iterations, solution.iterations);
  }
}

TEST(GaussNewton, SaysWhenTheStartHasNoFiniteCost) {
  const auto problem = make_problem(2, 5, 1);
  CurvedStages stages;
  Eigen::MatrixXd q = problem.q_start.replicate(1, 5);
  q(1, 2) = NAN;
  EXPECT_EQ(gauss_newton(problem, stages, q, {}).status, PlanStatus::bad_input);
  q(1, 2) = 1e200;
  EXPECT_EQ(gauss_newton(problem, stages, q, {}).status, PlanStatus::bad_input);
}

}  // namespace
}  // namespace primo::motion
