// What holds for every solver of the table of planners.
#include <gtest/gtest.h>

#include "motion/planner.h"
#include "problems.h"

namespace primo::motion {
namespace {

class EverySolver : public testing::TestWithParam<PlannerEntry> {
 protected:
  static Solution solve(const TrajectoryProblem& problem, StageCosts& stages, const SolverOptions& options) {
    return GetParam().solve(problem, stages, problem.q_start.replicate(1, problem.steps), options);
  }
};

SolverOptions fine() {
  SolverOptions options;
  options.step_tolerance = 1e-9;
  options.cost_tolerance = 1e-14;
  options.max_iterations = 2000;
  return options;
}

TEST_P(EverySolver, FindsTheMinimumOfLinearTasksThatADenseSolverFinds) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const auto problem = make_problem(4, 12, seed);
    auto stages = make_linear(4, 12, 6, seed);
    const auto solution = solve(problem, stages, fine());
    EXPECT_LT((solution.q - dense_solution(problem, stages)).cwiseAbs().maxCoeff(), 1e-4) << seed;
  }
}

TEST_P(EverySolver, NeverRaisesTheCostAndKeepsToItsAllowance) {
  const auto problem = make_problem(2, 20, 9);
  CurvedStages stages;
  double before = INFINITY;
  for (int limit = 0; limit < 40; ++limit) {
    SolverOptions options;
    options.max_iterations = limit;
    const auto solution = solve(problem, stages, options);
    EXPECT_LE(solution.cost, before) << limit;
    EXPECT_LE(solution.cost, solution.cost_initial);
    EXPECT_LE(solution.iterations + solution.rejected, limit);
    before = solution.cost;
  }
}

TEST_P(EverySolver, ReportsTheCostOfThePathItReturns) {
  const auto problem = make_problem(2, 20, 9);
  CurvedStages stages;
  const auto solution = solve(problem, stages, {});
  double tasks = 0;
  const auto v = velocities(problem, solution.q);
  for (int t = 1; t <= 20; ++t) {
    StageModel model;
    tasks += stages.evaluate(t, solution.q.col(t - 1), v.col(t - 1), &model);
    EXPECT_EQ(model.R_qq, solution.models[t - 1].R_qq) << t;
  }
  EXPECT_NEAR(solution.cost_control, control_cost(problem, solution.q), 1e-12 * solution.cost);
  EXPECT_NEAR(solution.cost, solution.cost_control + tasks, 1e-12 * solution.cost);
}

TEST_P(EverySolver, SaysWhenTheStartHasNoFiniteCost) {
  const auto problem = make_problem(2, 5, 1);
  CurvedStages stages;
  Eigen::MatrixXd q = problem.q_start.replicate(1, 5);
  for (const double bad : {double(NAN), double(INFINITY), 1e200}) {
    q(1, 2) = bad;
    EXPECT_EQ(GetParam().solve(problem, stages, q, {}).status, PlanStatus::bad_input) << bad;
  }
}

TEST_P(EverySolver, PlansASingleStep) {
  const auto problem = make_problem(3, 1, 5);
  auto stages = make_linear(3, 1, 2, 5);
  const auto solution = solve(problem, stages, fine());
  EXPECT_LT((solution.q - dense_solution(problem, stages)).cwiseAbs().maxCoeff(), 1e-6);
}

TEST_P(EverySolver, LeavesALockedJointWhereItIs) {
  auto problem = make_problem(3, 10, 6);
  problem.H[1] = 1e12;
  problem.v_start[1] = 0;
  auto stages = make_linear(3, 10, 2, 6);
  const auto solution = solve(problem, stages, fine());
  ASSERT_TRUE(solution.q.allFinite());
  EXPECT_LT((solution.q.row(1).array() - problem.q_start[1]).abs().maxCoeff(), 1e-6);
}

TEST_P(EverySolver, ScalingEveryCostLeavesThePathUnchanged) {
  const auto problem = make_problem(2, 20, 11);
  CurvedStages stages;
  const auto solution = solve(problem, stages, fine());
  for (const double c : {1.0 / 1024, 4096.0}) {
    auto scaled = problem;
    scaled.H *= c;
    CurvedStages scaled_stages;
    scaled_stages.scale = c;
    const auto other = solve(scaled, scaled_stages, fine());
    EXPECT_LT((other.q - solution.q).cwiseAbs().maxCoeff(), 1e-5) << c;
    EXPECT_NEAR(other.cost, c * solution.cost, 1e-8 * c * solution.cost) << c;
  }
}

TrajectoryProblem planar_problem(int T, const Eigen::Vector2d& q_start) {
  TrajectoryProblem problem;
  problem.steps = T;
  problem.dt = 1.0 / T;
  problem.H = Eigen::Vector2d::Constant(problem.dt);
  problem.q_start = q_start;
  problem.v_start = Eigen::Vector2d::Zero();
  return problem;
}

TEST_P(EverySolver, ReachesWhereInverseKinematicsSaysAsPrecisionGrows) {
  const Eigen::Vector2d q_goal(-0.4, 1.3);
  PlanarStages stages;
  stages.steps = 20;
  stages.goal = PlanarStages::tip(q_goal);
  ASSERT_LT((PlanarStages::inverse(stages.goal) - q_goal).norm(), 1e-12);
  const auto problem = planar_problem(20, {0.2, 0.7});
  double before = 1;
  for (const double rho : {1e3, 1e5, 1e7}) {
    stages.rho = rho;
    const auto solution = solve(problem, stages, fine());
    const double error = (solution.q.col(19) - q_goal).norm();
    EXPECT_LT(error, 0.05 * before) << rho;
    before = error;
  }
  EXPECT_LT(before, 1e-5);
}

TEST_P(EverySolver, PlansTheMirrorImageOfAMirroredScene) {
  PlanarStages stages;
  stages.steps = 20;
  stages.rho = 1e3;
  stages.rho_obstacle = 10;
  stages.goal = PlanarStages::tip(Eigen::Vector2d(-0.4, 1.3));
  stages.obstacle = PlanarStages::tip(Eigen::Vector2d(-0.05, 1.05));
  PlanarStages mirrored = stages;
  mirrored.goal.y() *= -1;
  mirrored.obstacle.y() *= -1;
  const auto solution = solve(planar_problem(20, {0.2, 0.7}), stages, {});
  const auto image = solve(planar_problem(20, {-0.2, -0.7}), mirrored, {});
  EXPECT_LT((solution.q + image.q).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_LT(solution.cost, 0.5 * solution.cost_initial);
}

INSTANTIATE_TEST_SUITE_P(Planners, EverySolver, testing::ValuesIn(planners()),
                         [](const auto& planner) { return planner.param.name; });

}  // namespace
}  // namespace primo::motion
