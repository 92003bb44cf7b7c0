#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "fixture.h"
#include "motion/planning_scene.h"
#include "problems.h"
#include "robot/distance.h"

namespace primo::motion {
namespace {

Eigen::MatrixXd rest(const TrajectoryProblem& problem) { return problem.q_start.replicate(1, problem.steps); }

SolverOptions fine() {
  SolverOptions options;
  options.step_tolerance = 1e-10;
  options.cost_tolerance = 1e-15;
  options.max_iterations = 3000;
  return options;
}

bool is_converged(const Solution& solution) {
  return solution.status == PlanStatus::converged_step || solution.status == PlanStatus::converged_cost;
}

TEST(Ipopt, SolvesLinearTasksAsADenseSolverDoes) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto problem = make_problem(4, 12, seed);
    auto stages = make_linear(4, 12, 6, seed);
    const auto solution = ipopt(problem, stages, rest(problem), fine());
    EXPECT_LT((solution.q - dense_solution(problem, stages)).cwiseAbs().maxCoeff(), 1e-6) << seed;
    auto moving = make_moving(4, 12, 6, seed);
    const auto on_velocities = ipopt(problem, moving, rest(problem), fine());
    EXPECT_LT((on_velocities.q - dense_solution(problem, moving)).cwiseAbs().maxCoeff(), 1e-6) << seed;
  }
}

TEST(Ipopt, IsAccurateWithPrecisionsOverTwelveDecades) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto problem = make_problem(4, 12, seed);
    auto stages = make_linear(4, 12, 12, seed);
    const auto solution = ipopt(problem, stages, rest(problem), fine());
    EXPECT_LT((solution.q - dense_solution(problem, stages)).cwiseAbs().maxCoeff(), 1e-6) << seed;
  }
}

TEST(Ipopt, DrivesAPointMassAsTheRiccatiRecursionDoes) {
  const int T = 50;
  const double rho = 1e2;
  const TrajectoryProblem problem{T, 0.05, scalar(0.05), scalar(1), scalar(1), {}, {}};
  auto stages = point_mass_stages(T, rho);
  const auto solution = ipopt(problem, stages, rest(problem), fine());
  std::vector<Eigen::RowVector2d> K;
  point_mass_gains(problem.dt, problem.H[0], rho, T, K);
  const auto gains = riccati_gains(problem, solution.q, solution.models);
  Eigen::Vector2d x(1, 1);
  for (int t = 0; t < T; ++t) {
    EXPECT_LT((gains.K[t] - K[t]).norm(), 1e-8 * K[t].norm() + 1e-10) << t;
    x[1] += problem.dt * K[t].transpose().dot(x);
    x[0] += problem.dt * x[1];
    EXPECT_NEAR(solution.q(0, t), x[0], 1e-7) << t;
  }
}

TEST(Ipopt, AndGaussNewtonFindTheSameMinimumAndLeaveEachOthersAlone) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto problem = make_problem(2, 20, seed);
    CurvedStages stages;
    // From the other's minimum, so that both are in the same basin.
    const auto theirs = gauss_newton(problem, stages, rest(problem), fine());
    const auto ours = ipopt(problem, stages, theirs.q, fine());
    EXPECT_NEAR(ours.cost, theirs.cost, 1e-6 * theirs.cost) << seed;
    EXPECT_LT((ours.q - theirs.q).cwiseAbs().maxCoeff(), 1e-4) << seed;
    const auto own = ipopt(problem, stages, rest(problem), fine());
    const auto back = gauss_newton(problem, stages, own.q, fine());
    EXPECT_NEAR(back.cost, own.cost, 1e-6 * own.cost) << seed;
    EXPECT_LT((back.q - own.q).cwiseAbs().maxCoeff(), 1e-4) << seed;
    const auto again = ipopt(problem, stages, own.q, {});
    EXPECT_TRUE(is_converged(again));
    EXPECT_LE(again.iterations + again.rejected, 1) << seed;
  }
}

TEST(Ipopt, GraspsEndAtMinimaThatGaussNewtonDoesNotImprove) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    // Without variables whose cost has kinks: there no gradient vanishes.
    Primitive smooth = hand_tuned();
    std::erase_if(smooth.tasks, [](const Task& task) { return task.name == "collision" || task.name == "fingers"; });
    smooth.tolerance = 1e-6;
    smooth.max_iterations = 1000;
    auto asked = request(seed, smooth);
    asked.primitive.solver = "ipopt";
    const Plan ours = plan(schunk(), asked);
    asked.primitive.solver = "gauss_newton";
    asked.primitive.start = "last";
    asked.last = ours.trajectory.q;
    const Plan theirs = plan(schunk(), asked);
    EXPECT_NEAR(theirs.cost_final, ours.cost_final, 1e-6 * ours.cost_final) << seed;
  }
}

PlanRequest random_precisions(std::uint64_t i, const std::string& solver) {
  Primitive primitive = hand_tuned();
  primitive.solver = solver;
  primitive.steps = 8;
  primitive.max_iterations = 30;
  Random random(10, "random_rho", {i});
  std::vector<double> rho(primitive.log_rho().size());
  for (double& value : rho) value = random.uniform(-3, 9);
  return request(i, primitive.with_log_rho(rho));
}

TEST(Ipopt, RandomPrecisionsNeverGiveWhatIsNotFinite) {
  for (std::uint64_t i = 0; i < 200; ++i) {
    for (const std::string solver : {"ipopt", "ipopt_constrained"}) {
      auto asked = random_precisions(i, solver);
      asked.want_gains = i % 10 == 0;
      const Plan answer = plan(schunk(), asked);
      ASSERT_NE(answer.status, PlanStatus::bad_input) << i << ": " << answer.reason;
      ASSERT_TRUE(answer.trajectory.q.allFinite() && std::isfinite(answer.cost_final)) << i;
      ASSERT_LE(answer.iterations + answer.rejected, 30) << i;
      ASSERT_TRUE(solver != "ipopt" || answer.cost_final <= answer.cost_initial) << i;
      for (const auto& K : answer.gains.K) ASSERT_TRUE(K.allFinite()) << i;
    }
  }
}

TEST(Ipopt, GivesTheSameBitsAgainAndOnEveryThread) {
  std::vector<Plan> first(6), second(6);
  const auto asked = [](std::uint64_t i) { return random_precisions(i, i % 2 ? "ipopt" : "ipopt_constrained"); };
  for (std::uint64_t i = 0; i < 6; ++i) first[i] = plan(schunk(), asked(i));
  std::vector<std::thread> threads;
  for (std::uint64_t i = 0; i < 6; ++i) threads.emplace_back([&, i] { second[5 - i] = plan(schunk(), asked(5 - i)); });
  for (auto& thread : threads) thread.join();
  for (std::uint64_t i = 0; i < 6; ++i) {
    EXPECT_EQ(first[i].trajectory.q, second[i].trajectory.q);
    EXPECT_EQ(first[i].reason, second[i].reason);
  }
}

TrajectoryProblem planar_problem(const Eigen::Vector2d& q_start) {
  TrajectoryProblem problem;
  problem.steps = 20;
  problem.dt = 0.05;
  problem.H = Eigen::Vector2d::Constant(problem.dt);
  problem.q_start = q_start;
  problem.v_start = Eigen::Vector2d::Zero();
  return problem;
}

TEST(IpoptConstrained, KeepsLimitsThatTheUnconstrainedMinimumBreaks) {
  PlanarStages stages;
  stages.steps = 20;
  stages.rho = 1e3;
  stages.goal = PlanarStages::tip(Eigen::Vector2d(-0.4, 1.3));
  auto problem = planar_problem({0.2, 0.7});
  problem.q_lower = Eigen::Vector2d(-0.1, 0);
  problem.q_upper = Eigen::Vector2d(1, 1.5);
  const auto free = ipopt(problem, stages, rest(problem), fine());
  EXPECT_LT(free.q.row(0).minCoeff(), -0.3);
  const auto bound = ipopt_constrained(problem, stages, rest(problem), fine());
  EXPECT_TRUE(is_converged(bound));
  EXPECT_GE(bound.q.row(0).minCoeff(), -0.1);
  EXPECT_NEAR(bound.q(0, 19), -0.1, 1e-4);  // where the cost pushes it
  EXPECT_LE(bound.q.row(1).maxCoeff(), 1.5);
  EXPECT_GT(bound.cost, free.cost);
  // Without limits in the way it is the same minimum.
  problem.q_lower.setConstant(-4);
  problem.q_upper.setConstant(4);
  const auto wide = ipopt_constrained(problem, stages, rest(problem), fine());
  EXPECT_NEAR(wide.cost, free.cost, 1e-6 * free.cost);
}

TEST(IpoptConstrained, GoesAroundAnObstacleThatTheSoftCostCutsThrough) {
  PlanarStages stages;
  stages.steps = 20;
  stages.rho = 1e3;
  stages.rho_obstacle = 1e-3;
  stages.radius = 0.15;
  stages.goal = PlanarStages::tip(Eigen::Vector2d(-0.4, 1.3));
  stages.obstacle = PlanarStages::tip(Eigen::Vector2d(-0.07, 1.05));
  stages.hard = true;
  const auto problem = planar_problem({0.2, 0.7});
  const auto clearance = [&](const Solution& solution) {
    double least = 1e9;
    for (int t = 0; t < 20; ++t)
      least = std::min(least, (PlanarStages::tip(solution.q.col(t)) - stages.obstacle).norm() - stages.radius);
    return least;
  };
  const auto soft = ipopt(problem, stages, rest(problem), {});
  EXPECT_LT(clearance(soft), -0.02);
  const auto hard = ipopt_constrained(problem, stages, rest(problem), {});
  EXPECT_TRUE(is_converged(hard));
  EXPECT_GE(clearance(hard), -1e-4);
  EXPECT_LT((PlanarStages::tip(hard.q.col(19)) - stages.goal).norm(), 0.05);
}

TEST(IpoptConstrained, SaysThatNoPathKeepsContradictoryConstraints) {
  PlanarStages stages;
  stages.steps = 20;
  stages.radius = 0.3;
  stages.hard = true;
  auto problem = planar_problem({0.2, 0.7});
  problem.q_lower = Eigen::Vector2d(0.15, 0.65);
  problem.q_upper = Eigen::Vector2d(0.25, 0.75);
  stages.obstacle = stages.goal = PlanarStages::tip(problem.q_start);  // every tip within the limits is inside it
  const auto solution = ipopt_constrained(problem, stages, rest(problem), {});
  EXPECT_EQ(solution.status, PlanStatus::infeasible);
  EXPECT_TRUE(solution.q.allFinite());
  problem.q_lower = problem.q_upper = problem.q_start;  // nothing can move
  EXPECT_EQ(ipopt_constrained(problem, stages, rest(problem), {}).q, rest(problem));
  problem.q_lower[0] = 1;  // above the upper limit
  EXPECT_EQ(ipopt_constrained(problem, stages, rest(problem), {}).status, PlanStatus::bad_input);
}

/// The least distance of a moving link to an obstacle or the table, and of the arm to the target, over a plan.
double least_distance(const PlanRequest& asked, const Plan& answer) {
  const auto scene = PlanningScene::create(asked.scene, asked.action).value();
  double least = 1e9;
  for (int t = 1; t < answer.trajectory.q.rows(); ++t) {
    const auto kinematics = schunk().forward(answer.trajectory.q.row(t).transpose());
    for (const auto& link : schunk().link_shapes()) {
      if (!link.moves) continue;
      const auto to = [&](const SceneBody& body) {
        least = std::min(least,
                         robot::distance(link.shape, schunk().pose(kinematics, link), body.shape, body.X_WB).distance);
      };
      for (const auto& body : scene.obstacles) to(body);
      if (!link.hand) to(scene.target);
    }
  }
  return least;
}

TEST(IpoptConstrained, GraspsClearOfEverythingWhereTheSoftPlanTouches) {
  Primitive careless = hand_tuned();
  for (auto& task : careless.tasks) {
    if (task.name == "collision") task.rho = 1e-5;
  }
  careless.max_iterations = 400;
  int touching = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    auto asked = request(seed, careless);
    const Plan soft = plan(schunk(), asked);
    asked.primitive.solver = "ipopt_constrained";
    const Plan hard = plan(schunk(), asked);
    touching += least_distance(asked, soft) < 0;
    EXPECT_TRUE(hard.status == PlanStatus::converged_step || hard.status == PlanStatus::converged_cost)
        << seed << ": " << hard.reason;
    EXPECT_GT(least_distance(asked, hard), 0) << seed;
    for (int t = 1; t < hard.trajectory.q.rows(); ++t) {
      const Eigen::ArrayXd q = hard.trajectory.q.row(t).transpose();
      ASSERT_TRUE((q >= schunk().lower().array()).all() && (q <= schunk().upper().array()).all()) << seed << " " << t;
    }
  }
  EXPECT_GE(touching, 4);
}

}  // namespace
}  // namespace primo::motion
