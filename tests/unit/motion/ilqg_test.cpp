#include <gtest/gtest.h>

#include <cmath>

#include "fixture.h"
#include "problems.h"

namespace primo::motion {
namespace {

Eigen::MatrixXd rest(const TrajectoryProblem& problem) { return problem.q_start.replicate(1, problem.steps); }

TEST(Ilqg, SolvesLinearTasksInOneSweepAsADenseSolverDoes) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto problem = make_problem(4, 12, seed);
    auto options = exact();
    options.max_iterations = 1;
    auto stages = make_linear(4, 12, 6, seed);
    const auto solution = ilqg(problem, stages, rest(problem), options);
    EXPECT_EQ(solution.iterations, 1);
    EXPECT_LT((solution.q - dense_solution(problem, stages)).cwiseAbs().maxCoeff(), 1e-8) << seed;
    auto moving = make_moving(4, 12, 6, seed);
    const auto on_velocities = ilqg(problem, moving, rest(problem), options);
    EXPECT_LT((on_velocities.q - dense_solution(problem, moving)).cwiseAbs().maxCoeff(), 1e-7) << seed;
  }
}

TEST(Ilqg, IsAccurateWithPrecisionsOverTwelveDecades) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto problem = make_problem(4, 12, seed);
    auto stages = make_linear(4, 12, 12, seed);
    const auto solution = ilqg(problem, stages, rest(problem), exact());
    EXPECT_LT((solution.q - dense_solution(problem, stages)).cwiseAbs().maxCoeff(), 1e-6) << seed;
  }
}

TEST(Ilqg, TakesTheStepOfGaussNewtonAtEqualDamping) {
  for (const double lambda : {1e-6, 1e-3, 1.0, 1e3}) {
    const auto problem = make_problem(3, 15, 4);
    auto options = exact();
    options.max_iterations = 1;
    options.lambda_initial = lambda;
    auto stages = make_moving(3, 15, 4, 4);
    const auto ours = ilqg(problem, stages, rest(problem), options);
    const auto theirs = gauss_newton(problem, stages, rest(problem), options);
    ASSERT_EQ(theirs.iterations, 1);
    EXPECT_LT((ours.q - theirs.q).cwiseAbs().maxCoeff(), 1e-9) << lambda;
    EXPECT_GT((ours.q - rest(problem)).cwiseAbs().maxCoeff(), 1e-4) << lambda;
  }
}

TEST(Ilqg, DrivesAPointMassAsTheRiccatiRecursionDoes) {
  const int T = 50;
  const double rho = 1e2;
  const TrajectoryProblem problem{T, 0.05, scalar(0.05), scalar(1), scalar(1), {}, {}};
  auto stages = point_mass_stages(T, rho);
  const auto solution = ilqg(problem, stages, rest(problem), exact());
  std::vector<Eigen::RowVector2d> K;
  point_mass_gains(problem.dt, problem.H[0], rho, T, K);
  Eigen::Vector2d x(1, 1);
  for (int t = 0; t < T; ++t) {
    x[1] += problem.dt * K[t].transpose().dot(x);
    x[0] += problem.dt * x[1];
    EXPECT_NEAR(solution.q(0, t), x[0], 1e-9) << t;
  }
}

TEST(Ilqg, StopsAtOnceAtAMinimumOfItsOwnOrOfGaussNewton) {
  const auto problem = make_problem(2, 20, 9);
  CurvedStages stages;
  SolverOptions fine;
  fine.step_tolerance = 1e-9;
  fine.cost_tolerance = 1e-14;
  fine.max_iterations = 500;
  for (const auto solver : {ilqg, gauss_newton}) {
    const auto solution = solver(problem, stages, rest(problem), fine);
    const auto again = ilqg(problem, stages, solution.q, {});
    EXPECT_LE(again.iterations + again.rejected, 1);
    EXPECT_LT((again.q - solution.q).cwiseAbs().maxCoeff(), 1e-4);
    EXPECT_TRUE(again.status == PlanStatus::converged_step || again.status == PlanStatus::converged_cost);
  }
}

TEST(Ilqg, RandomPrecisionsNeverGiveWhatIsNotFinite) {
  Primitive primitive = hand_tuned();
  primitive.solver = "ilqg";
  primitive.steps = 8;
  primitive.max_iterations = 30;
  const std::size_t open = primitive.log_rho().size();
  for (std::uint64_t i = 0; i < 1000; ++i) {
    Random random(10, "random_rho", {i});
    std::vector<double> rho(open);
    for (double& value : rho) value = random.uniform(-3, 9);
    auto asked = request(i, primitive.with_log_rho(rho));
    asked.want_gains = i % 10 == 0;
    const Plan answer = plan(schunk(), asked);
    ASSERT_NE(answer.status, PlanStatus::bad_input) << i << ": " << answer.reason;
    ASSERT_TRUE(answer.trajectory.q.allFinite() && std::isfinite(answer.cost_final)) << i;
    ASSERT_LE(answer.cost_final, answer.cost_initial) << i;
    for (const auto& K : answer.gains.K) ASSERT_TRUE(K.allFinite()) << i;
  }
}

}  // namespace
}  // namespace primo::motion
