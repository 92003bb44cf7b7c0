#include "motion/planner.h"

#include <cmath>
#include <thread>

#include "fixture.h"
#include "motion/motion_cost.h"
#include "robot/distance.h"

namespace primo::motion {
namespace {

bool all_finite(const Plan& plan) {
  bool finite = plan.trajectory.q.allFinite() && std::isfinite(plan.cost_initial) && std::isfinite(plan.cost_final) &&
                std::isfinite(plan.cost_control) && std::isfinite(plan.gradient_norm) && std::isfinite(plan.lambda);
  for (const auto& task : plan.cost_tasks) finite = finite && std::isfinite(task.cost);
  for (const auto& K : plan.gains.K) finite = finite && K.allFinite();
  return finite;
}

double position_error(const PlanRequest& request, const Plan& plan) {
  const auto& q = plan.trajectory.q;
  const Pose X_WG = schunk().pose(schunk().forward(q.row(q.rows() - 1).transpose()), schunk().grasp_frame());
  return (X_WG.translation() - request.scene.objects[0].X_WO.translation()).norm();
}

TEST(Planner, HandTunedPrimitiveBringsTheHandToTheTarget) {
  int near = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const auto asked = request(seed, hand_tuned());
    const Plan answer = plan(schunk(), asked);
    ASSERT_EQ(answer.trajectory.q.rows(), 65);
    ASSERT_EQ(answer.trajectory.q.cols(), 14);
    EXPECT_EQ(answer.trajectory.dt, 4.0 / 64);
    near += position_error(asked, answer) < 0.06;
  }
  EXPECT_GE(near, 36);
}

TEST(Planner, HighPositionPrecisionMakesThePositionExact) {
  Primitive precise = hand_tuned();
  for (auto& task : precise.tasks) {
    if (task.name == "position") task.rho = 1e6;
  }
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto asked = request(seed, precise);
    EXPECT_LT(position_error(asked, plan(schunk(), asked)), 1e-3) << seed;
  }
}

TEST(Planner, CostsOfControlAndTasksAddUp) {
  const auto asked = request(3, hand_tuned());
  const Plan answer = plan(schunk(), asked);
  double sum = answer.cost_control;
  ASSERT_EQ(answer.cost_tasks.size(), hand_tuned().tasks.size());
  for (std::size_t i = 0; i < answer.cost_tasks.size(); ++i) {
    EXPECT_EQ(answer.cost_tasks[i].task, hand_tuned().tasks[i].name);
    sum += answer.cost_tasks[i].cost;
  }
  EXPECT_NEAR(sum, answer.cost_final, 1e-9 * answer.cost_final);
  EXPECT_LE(answer.cost_final, answer.cost_initial);
}

TEST(Planner, CostIsTheSumOfSquaresWrittenOut) {
  // The cost of a path, from the trajectory alone: control, position and homing by their formulas.
  Primitive simple = hand_tuned();
  std::erase_if(simple.tasks, [](const Task& task) { return task.name != "position" && task.name != "homing"; });
  const auto asked = request(5, simple);
  const Plan answer = plan(schunk(), asked);
  const auto& q = answer.trajectory.q;
  const double tau = answer.trajectory.dt;
  double control = 0, position = 0, homing = 0;
  for (int t = 0; t < 64; ++t) {
    const Eigen::RowVectorXd before = t == 0 ? q.row(0) : q.row(t - 1);
    const Eigen::RowVectorXd u = (q.row(t + 1) - 2 * q.row(t) + before) / (tau * tau);
    control += tau * (u.array().square() * schunk().control_weights().transpose().array()).sum();
  }
  for (int t = 1; t <= 64; ++t) {
    homing += 1e-5 * q.row(t).squaredNorm();
    if (t < 0.8 * 64) continue;
    const auto kinematics = schunk().forward(q.row(t).transpose());
    const Eigen::Vector3d p = schunk().pose(kinematics, schunk().grasp_frame()).translation();
    position += 10 * (p - asked.scene.objects[0].X_WO.translation()).squaredNorm();
  }
  EXPECT_NEAR(answer.cost_control, control, 1e-9 * control);
  EXPECT_NEAR(answer.cost_tasks[0].cost, position, 1e-9 * position + 1e-15);
  EXPECT_NEAR(answer.cost_tasks[1].cost, homing, 1e-9 * homing);
}

TEST(Planner, MoreIterationsNeverCostMore) {
  Primitive primitive = hand_tuned();
  double before = INFINITY;
  for (int limit = 1; limit <= 30; ++limit) {
    primitive.max_iterations = limit;
    const Plan answer = plan(schunk(), request(2, primitive));
    EXPECT_LE(answer.cost_final, before) << limit;
    EXPECT_LE(answer.iterations + answer.rejected, limit);
    before = answer.cost_final;
  }
}

TEST(Planner, RampedTargetClosesTheFingersInTheLatePhase) {
  PlanRequest asked = request(4, hand_tuned());
  asked.scene.objects.resize(1);
  for (auto& task : asked.primitive.tasks) {
    if (task.name == "position") task.rho = 1e4;
    if (task.name == "fingers") task.rho = task.rho_late = 1e3;
  }
  const Plan answer = plan(schunk(), asked);
  const auto proximity = [&](int t) {
    const auto kinematics = schunk().forward(answer.trajectory.q.row(t).transpose());
    double least = 1e9;
    for (const auto& tip : schunk().fingertips()) {
      const auto& link = schunk().link_shapes()[tip.link_shape];
      least = std::min(least, robot::distance(link.shape, schunk().pose(kinematics, link), asked.scene.objects[0].shape,
                                              asked.scene.objects[0].X_WO)
                                  .distance);
    }
    return least;
  };
  EXPECT_GT(proximity(50), 0.03);
  EXPECT_NEAR(proximity(64), 0.0, 0.004);
}

TEST(Planner, RandomPrecisionsNeverGiveWhatIsNotFinite) {
  Primitive primitive = hand_tuned();
  primitive.steps = 8;
  primitive.max_iterations = 30;
  const std::size_t open = primitive.log_rho().size();
  int converged = 0;
  for (std::uint64_t i = 0; i < 2000; ++i) {
    Random random(10, "random_rho", {i});
    std::vector<double> rho(open);
    for (double& value : rho) value = random.uniform(-3, 9);
    Primitive drawn = primitive.with_log_rho(rho);
    drawn.start = i % 4 ? "ik" : "rest";
    auto asked = request(i, drawn);
    asked.want_gains = i % 10 == 0;
    const Plan answer = plan(schunk(), asked);
    ASSERT_TRUE(all_finite(answer)) << i << ": " << answer.reason;
    ASSERT_NE(answer.status, PlanStatus::bad_input) << i << ": " << answer.reason;
    ASSERT_LE(answer.cost_final, answer.cost_initial) << i;
    converged += answer.status == PlanStatus::converged_step || answer.status == PlanStatus::converged_cost;
  }
  RecordProperty("converged_of_2000_in_30_iterations", converged);
}

TEST(Planner, CornersOfThePrecisionRangeArePlannedToo) {
  Primitive primitive = hand_tuned();
  primitive.steps = 6;
  primitive.max_iterations = 30;
  const std::size_t open = primitive.log_rho().size();
  for (unsigned corner = 0; corner < 1u << open; ++corner) {
    std::vector<double> rho(open);
    for (std::size_t i = 0; i < open; ++i) rho[i] = corner >> i & 1 ? 9 : -3;
    const Plan answer = plan(schunk(), request(corner, primitive.with_log_rho(rho)));
    ASSERT_TRUE(all_finite(answer)) << corner;
    ASSERT_NE(answer.status, PlanStatus::bad_input) << corner << ": " << answer.reason;
  }
}

TEST(Planner, GivesTheSameBitsOnEveryThread) {
  std::vector<Plan> alone, together(16);
  for (std::uint64_t i = 0; i < 16; ++i) {
    auto asked = request(i, hand_tuned());
    asked.want_gains = true;
    alone.push_back(plan(schunk(), asked));
  }
  std::vector<std::thread> threads;
  for (int part = 0; part < 4; ++part) {
    threads.emplace_back([&, part] {
      for (std::uint64_t i = part; i < 16; i += 4) {
        auto asked = request(i, hand_tuned());
        asked.want_gains = true;
        together[i] = plan(schunk(), asked);
      }
    });
  }
  for (auto& thread : threads) thread.join();
  for (std::size_t i = 0; i < 16; ++i) {
    EXPECT_EQ(alone[i].trajectory.q, together[i].trajectory.q);
    EXPECT_EQ(alone[i].gains.K[5], together[i].gains.K[5]);
    EXPECT_EQ(alone[i].reason, together[i].reason);
  }
}

TEST(Planner, GainsHaveTheTrajectorysShapeAndOnlyWhenWanted) {
  auto asked = request(1, hand_tuned());
  EXPECT_TRUE(plan(schunk(), asked).gains.K.empty());
  asked.want_gains = true;
  const Plan answer = plan(schunk(), asked);
  ASSERT_EQ(answer.gains.K.size(), 64u);
  ASSERT_EQ(answer.gains.k.size(), 64u);
  EXPECT_EQ(answer.gains.K[0].rows(), 14);
  EXPECT_EQ(answer.gains.K[0].cols(), 28);
  EXPECT_TRUE(all_finite(answer));
}

TEST(Planner, OneStepIsEnough) {
  Primitive primitive = hand_tuned();
  for (const int steps : {1, 2, 3}) {
    primitive.steps = steps;
    auto asked = request(1, primitive);
    asked.want_gains = true;
    const Plan answer = plan(schunk(), asked);
    EXPECT_EQ(answer.trajectory.q.rows(), steps + 1);
    EXPECT_TRUE(all_finite(answer));
    EXPECT_NE(answer.status, PlanStatus::bad_input) << answer.reason;
  }
}

TEST(Planner, StartedFromItsLastPlanStopsAtOnce) {
  auto asked = request(1, hand_tuned());
  asked.primitive.tolerance = 1e-6;
  asked.primitive.max_iterations = 1000;
  const Plan first = plan(schunk(), asked);
  asked.primitive.start = "last";
  asked.primitive.tolerance = 1e-2;
  EXPECT_EQ(plan(schunk(), asked).status, PlanStatus::bad_input);  // there is none
  asked.last = first.trajectory.q;
  const Plan again = plan(schunk(), asked);
  EXPECT_EQ(again.start, "last");
  EXPECT_LE(again.iterations, 1);  // where a finger's proximity begins the cost has a kink: steps are rejected there
  EXPECT_LT((again.trajectory.q - first.trajectory.q).cwiseAbs().maxCoeff(), 2e-2);
  EXPECT_NEAR(again.cost_final, first.cost_final, 1e-4 * first.cost_final);
  asked.primitive.steps = 100;  // stretched
  EXPECT_LT(plan(schunk(), asked).iterations, 15);
}

TEST(Planner, TheBestOfSeveralStartsCostsNoMoreThanAnyOne) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    auto asked = request(seed, hand_tuned());
    asked.primitive.start = "best";
    const Plan best = plan(schunk(), asked);
    for (const std::string start : {"rest", "ik"}) {
      asked.primitive.start = start;
      const Plan one = plan(schunk(), asked);
      EXPECT_EQ(one.start, start);
      EXPECT_LE(best.cost_final, one.cost_final) << seed;
    }
  }
}

void expect_refused(const PlanRequest& asked, const std::string& said) {
  const Plan answer = plan(schunk(), asked);
  EXPECT_EQ(answer.status, PlanStatus::bad_input);
  EXPECT_EQ(answer.trajectory.q.size(), 0);
  EXPECT_NE(answer.reason.find(said), std::string::npos) << answer.reason;
}

TEST(Planner, BadRequestsAreRefusedWithTheReason) {
  const auto good = request(1, hand_tuned());
  auto asked = good;
  asked.q_start[2] = NAN;
  expect_refused(asked, "arm_3");
  asked = good;
  asked.q_start.pop_back();
  expect_refused(asked, "13 entries, expected 14");
  asked = good;
  asked.action = {"grasp", "c9"};
  expect_refused(asked, "no object 'c9' in the scene; its objects are c1, c2");
  asked = good;
  asked.action = {"grasp"};
  expect_refused(asked, "no argument");
  asked = good;
  asked.scene.objects[0].X_WO.translation().x() = NAN;
  expect_refused(asked, "pose of 'c1'");
  asked = good;
  asked.scene.objects[1].shape.size[0] = -1;
  expect_refused(asked, "'c2' has size");
  asked = good;
  asked.primitive.solver = "magic";
  expect_refused(asked, "gauss_newton");
  asked = good;
  asked.primitive.tasks[0].variable = "positon";
  expect_refused(asked, "no task variable 'positon'");
  asked = good;
  asked.primitive.tasks[0].target = {1, 2};
  expect_refused(asked, "target has 2 entries, expected 3");
  asked = good;
  asked.primitive.steps = 0;
  expect_refused(asked, "steps");
}

TEST(Planner, ReasonSaysThatATargetIsOutOfReach) {
  auto asked = request(1, hand_tuned());
  asked.scene.objects[0].X_WO.translation() = Eigen::Vector3d(1.9, 0.2, 0.72);
  asked.primitive.tasks[0].rho = 1e4;
  const Plan answer = plan(schunk(), asked);
  EXPECT_NE(answer.status, PlanStatus::bad_input);
  EXPECT_TRUE(answer.trajectory.q.allFinite());
  EXPECT_NE(answer.reason.find("'position' costs most"), std::string::npos) << answer.reason;
  EXPECT_NE(answer.reason.find("out of reach"), std::string::npos) << answer.reason;
}

TEST(Planner, AnEmptySceneIsRefusedAndATableIsNotNeeded) {
  auto asked = request(1, hand_tuned());
  asked.scene.objects.clear();
  expect_refused(asked, "no object 'c1' in the scene");
}

TEST(Planner, ReasonNamesTheBodiesThatCollide) {
  // The target inside another, larger object: no hand can be at the one and clear of the other.
  auto asked = request(1, hand_tuned());
  asked.scene.objects[1].X_WO = asked.scene.objects[0].X_WO;
  asked.scene.objects[1].shape.size = {0.15, 0.1, 0};
  std::erase_if(asked.primitive.tasks,
                [](const Task& task) { return task.name != "position" && task.name != "collision"; });
  asked.primitive.tasks[0].rho = 1e8;
  asked.primitive.tasks[1].rho = 1e2;
  const Plan answer = plan(schunk(), asked);
  EXPECT_NE(answer.reason.find("'collision' costs most"), std::string::npos) << answer.reason;
  EXPECT_NE(answer.reason.find("c2"), std::string::npos) << answer.reason;
}

}  // namespace
}  // namespace primo::motion
