// Approximate inference control in all its modes, on problems with known answers and on grasps.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "fixture.h"
#include "motion/planner.h"
#include "motion/quadratic.h"
#include "problems.h"

namespace primo::motion {
namespace {

std::vector<PlannerEntry> modes() {
  std::vector<PlannerEntry> modes;
  for (const auto& entry : planners()) {
    if (entry.name.starts_with("aico")) modes.push_back(entry);
  }
  return modes;
}

class Aico : public ::testing::TestWithParam<PlannerEntry> {
 protected:
  Solution solve(const TrajectoryProblem& problem, StageCosts& stages, const Eigen::MatrixXd& q,
                 const SolverOptions& options) const {
    return GetParam().solve(problem, stages, q, options);
  }
  Solution from_rest(const TrajectoryProblem& problem, StageCosts& stages, const SolverOptions& options) const {
    return solve(problem, stages, problem.q_start.replicate(1, problem.steps), options);
  }
  PlanRequest request(std::uint64_t seed, const Primitive& primitive) const {
    PlanRequest asked = motion::request(seed, primitive);
    asked.primitive.solver = GetParam().name;
    return asked;
  }
};

INSTANTIATE_TEST_SUITE_P(Modes, Aico, ::testing::ValuesIn(modes()), [](const auto& mode) { return mode.param.name; });

SolverOptions one_iteration() {
  SolverOptions options = exact();
  options.max_iterations = 1;
  return options;
}

SolverOptions fine() {
  SolverOptions options;
  options.step_tolerance = 1e-9;
  options.cost_tolerance = 1e-14;
  options.max_iterations = 500;
  return options;
}

double distance(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return (a - b).cwiseAbs().maxCoeff(); }

TEST_P(Aico, SolvesLinearTasksInOneIterationAsADenseSolverDoes) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto problem = make_problem(4, 12, seed);
    auto stages = make_linear(4, 12, 6, seed);
    const auto solution = from_rest(problem, stages, one_iteration());
    EXPECT_EQ(solution.iterations, 1);
    EXPECT_LT(distance(solution.q, dense_solution(problem, stages)), 1e-8) << seed;
  }
}

TEST_P(Aico, SolvesLinearTasksOnVelocitiesInOneIterationAsADenseSolverDoes) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto problem = make_problem(4, 12, seed);
    auto stages = make_moving(4, 12, 6, seed);
    const auto solution = from_rest(problem, stages, one_iteration());
    EXPECT_EQ(solution.iterations, 1);
    EXPECT_LT(distance(solution.q, dense_solution(problem, stages)), 1e-7) << seed;
  }
}

TEST_P(Aico, IsAccurateInOneIterationWithPrecisionsOverTwelveDecades) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const auto problem = make_problem(4, 12, seed);
    auto stages = make_linear(4, 12, 12, seed);
    const auto solution = from_rest(problem, stages, one_iteration());
    EXPECT_EQ(solution.iterations, 1);
    EXPECT_LT(distance(solution.q, dense_solution(problem, stages)), 1e-6) << seed;
  }
}

/// Notes where slices are linearised.
class NotedStages final : public StageCosts {
 public:
  struct Note {
    int t;
    Eigen::VectorXd q, v;
  };
  explicit NotedStages(LinearStages linear) : stages(std::move(linear)) {}
  LinearStages stages;
  std::vector<Note> notes;
  double evaluate(int t, const Eigen::VectorXd& q, const Eigen::VectorXd& v, StageModel* model) override {
    notes.push_back({t, q, v});
    return stages.evaluate(t, q, v, model);
  }
};

TEST_P(Aico, BeliefsOfLinearTasksAreTheLikeliestPath) {
  for (const bool moving : {false, true}) {
    const auto problem = make_problem(4, 12, 8);
    NotedStages stages(moving ? make_moving(4, 12, 4, 8) : make_linear(4, 12, 4, 8));
    auto options = one_iteration();
    options.step_tolerance = 1e-6;  // above rounding, below every displacement
    from_rest(problem, stages, options);
    const Eigen::MatrixXd likeliest = dense_solution(problem, stages.stages);
    const Eigen::MatrixXd v = velocities(problem, likeliest);
    // The start, each slice once where its belief is, the path that came of it.
    ASSERT_EQ(stages.notes.size(), 3u * 12);
    for (std::size_t i = 12; i < 24; ++i) {
      const auto& note = stages.notes[i];
      EXPECT_EQ(note.t, static_cast<int>(i) - 11);
      EXPECT_LT(distance(note.q, likeliest.col(note.t - 1)), 1e-8) << note.t;
      EXPECT_LT(distance(note.v, v.col(note.t - 1)), 1e-7) << note.t;
    }
  }
}

TEST_P(Aico, DrivesAPointMassAsTheRiccatiRecursionDoes) {
  const int T = 50;
  const double rho = 1e2;
  const TrajectoryProblem problem{T, 0.05, scalar(0.05), scalar(1), scalar(1), {}, {}};
  auto stages = point_mass_stages(T, rho);
  const auto solution = from_rest(problem, stages, exact());
  std::vector<Eigen::RowVector2d> K;
  point_mass_gains(problem.dt, problem.H[0], rho, T, K);
  Eigen::Vector2d x(1, 1);
  for (int t = 0; t < T; ++t) {
    x[1] += problem.dt * K[t].transpose().dot(x);
    x[0] += problem.dt * x[1];
    EXPECT_NEAR(solution.q(0, t), x[0], 1e-9) << t;
  }
}

TEST_P(Aico, LeavesALockedJointWhereItIsAndSolvesForTheOthers) {
  auto problem = make_problem(4, 12, 3);
  auto stages = make_linear(4, 12, 4, 3);
  problem.H[3] = 1e12;
  problem.v_start[3] = 0;
  const auto solution = from_rest(problem, stages, one_iteration());
  EXPECT_LT((solution.q.row(3).array() - problem.q_start[3]).abs().maxCoeff(), 1e-6);
  // The same without that joint: what it adds to the tasks is constant.
  TrajectoryProblem others = problem;
  others.H = problem.H.head(3);
  others.q_start = problem.q_start.head(3);
  others.v_start = problem.v_start.head(3);
  LinearStages reduced = stages;
  for (int t = 0; t < 12; ++t) {
    reduced.y[t] -= problem.q_start[3] * stages.J[t].col(3);
    reduced.J[t] = stages.J[t].leftCols(3);
  }
  EXPECT_LT(distance(solution.q.topRows(3), dense_solution(others, reduced)), 1e-6);
}

TEST_P(Aico, NeverRaisesTheCost) {
  const auto problem = make_problem(2, 20, 9);
  CurvedStages stages;
  double before = INFINITY;
  for (int limit = 1; limit < 40; ++limit) {
    SolverOptions options;
    options.max_iterations = limit;
    const auto solution = from_rest(problem, stages, options);
    EXPECT_LE(solution.cost, before) << limit;
    EXPECT_LE(solution.cost, solution.cost_initial);
    EXPECT_LE(solution.iterations + solution.rejected, limit);
    before = solution.cost;
  }
}

TEST_P(Aico, CostIsThatOfThePathReturned) {
  const auto problem = make_problem(2, 20, 9);
  CurvedStages stages;
  const auto solution = from_rest(problem, stages, {});
  double cost = control_cost(problem, solution.q);
  EXPECT_NEAR(solution.cost_control, cost, 1e-12 * cost);
  const Eigen::MatrixXd v = velocities(problem, solution.q);
  for (int t = 1; t <= 20; ++t) {
    StageModel model;
    cost += stages.evaluate(t, solution.q.col(t - 1), v.col(t - 1), &model);
    EXPECT_EQ(solution.models[t - 1].r_q, model.r_q) << t;
  }
  EXPECT_NEAR(solution.cost, cost, 1e-12 * cost);
}

/// Counts the slices linearised.
class CountedStages final : public StageCosts {
 public:
  CurvedStages stages;
  int linearised = 0;
  double evaluate(int t, const Eigen::VectorXd& q, const Eigen::VectorXd& v, StageModel* model) override {
    linearised += model != nullptr;
    return stages.evaluate(t, q, v, model);
  }
};

TEST_P(Aico, StopsAtOnceWhenStartedAtASolutionAndLinearisesNothingAnew) {
  const auto problem = make_problem(2, 20, 9);
  CountedStages stages;
  const auto solution = from_rest(problem, stages, fine());
  EXPECT_LT(solution.gradient_norm, 1e-5);
  stages.linearised = 0;
  const auto again = solve(problem, stages, solution.q, {});
  EXPECT_LE(again.iterations + again.rejected, 1);
  EXPECT_LE(stages.linearised, 2 * 20);  // the start and what the sweep gave
  EXPECT_LT(distance(again.q, solution.q), 1e-4);
  EXPECT_TRUE(again.status == PlanStatus::converged_step || again.status == PlanStatus::converged_cost);
}

TEST_P(Aico, DoesNotMoveFromTheOptimumOfGaussNewton) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto problem = make_problem(2, 20, seed);
    CurvedStages stages;
    const auto optimum = gauss_newton(problem, stages, problem.q_start.replicate(1, 20), fine());
    if (optimum.gradient_norm > 1e-4) continue;
    const auto solution = solve(problem, stages, optimum.q, fine());
    EXPECT_LT(distance(solution.q, optimum.q), 1e-4) << seed;
    EXPECT_NEAR(solution.cost, optimum.cost, 1e-7 * optimum.cost) << seed;
  }
}

TEST_P(Aico, ScalingEveryCostLeavesThePathUnchanged) {
  const auto problem = make_problem(2, 20, 11);
  CurvedStages stages;
  const auto solution = from_rest(problem, stages, {});
  for (const double c : {1.0 / 1024, 4096.0}) {
    auto scaled = problem;
    scaled.H *= c;
    CurvedStages scaled_stages;
    scaled_stages.scale = c;
    const auto other = from_rest(scaled, scaled_stages, {});
    EXPECT_LT(distance(other.q, solution.q), 1e-9);
    EXPECT_NEAR(other.cost, c * solution.cost, 1e-9 * c * solution.cost);
    EXPECT_EQ(other.iterations, solution.iterations);
  }
}

TEST_P(Aico, SaysWhenTheStartHasNoFiniteCost) {
  const auto problem = make_problem(2, 5, 1);
  CurvedStages stages;
  Eigen::MatrixXd q = problem.q_start.replicate(1, 5);
  q(1, 2) = NAN;
  EXPECT_EQ(solve(problem, stages, q, {}).status, PlanStatus::bad_input);
  q(1, 2) = 1e200;
  EXPECT_EQ(solve(problem, stages, q, {}).status, PlanStatus::bad_input);
}

/// Tasks that are not finite beyond |q_0| = 2, where they attract.
class CliffStages final : public StageCosts {
 public:
  double evaluate(int, const Eigen::VectorXd& q, const Eigen::VectorXd&, StageModel* model) override {
    const double phi = std::abs(q[0]) < 2 ? 10 * (q[0] - 3) : NAN;
    if (model) {
      model->R_qq = Eigen::MatrixXd::Zero(q.size(), q.size());
      model->r_q = Eigen::VectorXd::Zero(q.size());
      model->R_qq(0, 0) = 100;
      model->r_q[0] = 10 * phi;
    }
    return phi * phi;
  }
};

TEST_P(Aico, StaysWhereTasksAreFinite) {
  const TrajectoryProblem problem{10, 0.1, scalar(0.1), scalar(0), scalar(0), {}, {}};
  CliffStages stages;
  const auto solution = from_rest(problem, stages, {});
  EXPECT_TRUE(solution.q.allFinite() && std::isfinite(solution.cost));
  EXPECT_LT(solution.cost, solution.cost_initial);
  EXPECT_LT(solution.q.cwiseAbs().maxCoeff(), 2);
}

TEST_P(Aico, ReachesTheCostOfGaussNewtonOnGrasps) {
  int reached = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    auto asked = request(seed, hand_tuned());
    const double cost = plan(schunk(), asked).cost_final;
    asked.primitive.solver = "gauss_newton";
    reached += cost <= 1.01 * plan(schunk(), asked).cost_final;
  }
  EXPECT_GE(reached, 16);
}

TEST_P(Aico, RandomPrecisionsNeverGiveWhatIsNotFinite) {
  Primitive primitive = hand_tuned();
  primitive.steps = 6;
  primitive.max_iterations = 30;
  const std::size_t open = primitive.log_rho().size();
  for (std::uint64_t i = 0; i < 1000; ++i) {
    Random random(11, "random_rho", {i});
    std::vector<double> rho(open);
    for (double& value : rho) value = random.uniform(-3, 9);
    Primitive drawn = primitive.with_log_rho(rho);
    drawn.start = i % 4 ? "ik" : "rest";
    const Plan answer = plan(schunk(), request(i, drawn));
    ASSERT_NE(answer.status, PlanStatus::bad_input) << i << ": " << answer.reason;
    ASSERT_TRUE(answer.trajectory.q.allFinite() && std::isfinite(answer.cost_final)) << i;
    ASSERT_TRUE(std::isfinite(answer.gradient_norm) && std::isfinite(answer.lambda)) << i;
    ASSERT_LE(answer.cost_final, answer.cost_initial) << i;
  }
}

TEST_P(Aico, OneStepIsEnough) {
  for (const int T : {1, 2, 3}) {
    for (const bool moving : {false, true}) {
      const auto problem = make_problem(4, T, 5);
      auto stages = moving ? make_moving(4, T, 4, 5) : make_linear(4, T, 4, 5);
      const auto solution = from_rest(problem, stages, one_iteration());
      EXPECT_LT(distance(solution.q, dense_solution(problem, stages)), 1e-8) << T;
    }
  }
}

TEST(Quadratic, EliminationLeavesTheSchurComplementAndItsMinimiserSolvesTheWhole) {
  for (const int k : {1, 3, 6, 9}) {
    const int m = 9;
    Random random(1, "quadratic", {static_cast<std::uint64_t>(k)});
    Eigen::MatrixXd A(m, m);
    Eigen::VectorXd g(m);
    for (int i = 0; i < m; ++i) {
      g[i] = random.normal();
      for (int j = 0; j < m; ++j) A(i, j) = random.normal();
    }
    A = A * A.transpose() + Eigen::MatrixXd::Identity(m, m);
    Quadratic f(m), rest(m - k);
    f.block(0, 0, m, m) = A;
    f.gradient(0, m) = g.transpose();
    ASSERT_TRUE(f.eliminate(k));
    f.rest(k, rest);
    const Eigen::MatrixXd B = A.bottomLeftCorner(m - k, k) * A.topLeftCorner(k, k).inverse();
    const Eigen::MatrixXd complement = A.bottomRightCorner(m - k, m - k) - B * A.topRightCorner(k, m - k);
    const Eigen::MatrixXd left = rest.block(0, 0, m - k, m - k);
    EXPECT_LT((left - complement).triangularView<Eigen::Lower>().toDenseMatrix().norm(), 1e-12);
    const Eigen::VectorXd left_g = rest.gradient(0, m - k).transpose();
    EXPECT_LT((left_g - (g.tail(m - k) - B * g.head(k))).norm(), 1e-12);
    const Eigen::VectorXd whole = -A.ldlt().solve(g);
    Eigen::VectorXd x = whole;
    x.head(k).setZero();
    minimiser(f.factor(k), x);
    EXPECT_LT((x - whole).norm(), 1e-12);
  }
}

TEST(Quadratic, PinnedVariablesStayZero) {
  Quadratic f(2);
  f.block(0, 0, 2, 2) << 4, 0, 1, 2;
  f.gradient(0, 2) << 3, -6;
  f.pin(0, 1);
  ASSERT_TRUE(f.eliminate(2));
  Eigen::VectorXd x = Eigen::VectorXd::Zero(2);
  minimiser(f.factor(2), x);
  EXPECT_EQ(x[0], 0);
  EXPECT_NEAR(x[1], 3, 1e-15);  // argmin 2 x² − 12 x
}

TEST(Quadratic, RefusesWhatHasNoMinimum) {
  for (const double bad : {0.0, -1.0, double(NAN), double(INFINITY)}) {
    Quadratic f(2);
    f.block(0, 0, 2, 2) << 1, 0, 0.5, bad;
    EXPECT_FALSE(f.eliminate(2)) << bad;
  }
}

}  // namespace
}  // namespace primo::motion
