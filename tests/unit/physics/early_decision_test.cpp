// What the judge decides without a simulation: the verdict is that of the simulation.
#include <gtest/gtest.h>

#include "core/random.h"
#include "grasp_fixture.h"
#include "physics/grasp_trial.h"
#include "physics/judge.h"

namespace primo::physics {
namespace {

using testing::load_robot;
using testing::one_cylinder;

TEST(EarlyDecision, a_final_pose_out_of_reach_gets_the_verdict_that_the_simulation_gives) {
  const robot::Robot robot = load_robot();
  const Judge judge(robot);
  auto whole = robot_model(robot);
  ASSERT_TRUE(whole.ok());
  const auto scenario = one_cylinder();
  const auto& target = *scenario.object("c1");
  auto workspace = HandWorkspace::create(robot, whole->get(), target.shape(), target.mass, 0.002);
  ASSERT_TRUE(workspace.ok());
  int decided = 0;
  for (std::uint64_t i = 0; decided < 8; ++i) {
    ASSERT_LT(i, 100u) << "too few random poses are out of reach";
    Random random(i, "final poses");
    Eigen::VectorXd q = robot.home();
    for (Eigen::Index j = 0; j < q.size(); ++j) q[j] = random.uniform(robot.lower()[j], robot.upper()[j]);
    JudgeRequest request;
    request.scenario = scenario;
    request.q = Eigen::MatrixXd(3, q.size());
    for (int t = 0; t < 3; ++t) request.q.row(t) = q.transpose();
    request.scenario.robot_start = {q.begin(), q.end()};
    request.dt = 0.1;
    request.seed = i;
    const auto early = judge.evaluate(request);
    ASSERT_TRUE(early.ok()) << early.error().message;
    if (early->outcome != Outcome::no_contact || early->steps != 0) continue;
    ++decided;
    const TrialResult simulated = run_trial(robot, *workspace, q, palm_pose(robot, q), target.X_WO(),
                                            early->position_error, request.settings, request.seed);
    EXPECT_GT(simulated.steps, 0);
    EXPECT_EQ(simulated.outcome, early->outcome);
    EXPECT_EQ(simulated.score, early->score);
    EXPECT_EQ(simulated.displacement, early->displacement);
    EXPECT_EQ(simulated.survival, early->survival);
    EXPECT_FALSE(early->success || early->final_pose_success);
    EXPECT_EQ(early->after, early->before) << "nothing was touched, nothing changed";
  }
}

}  // namespace
}  // namespace primo::physics
