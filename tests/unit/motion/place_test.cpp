#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "fixture.h"
#include "robot/distance.h"

namespace primo::motion {
namespace {

const Primitive& place_primitive() {
  static const Primitive primitive =
      read_primitive(std::filesystem::path(PRIMO_SOURCE_DIR) / "configs/primitives/place_hand_tuned.yaml").value();
  return primitive;
}

/// With position at 1e3 in place of 1e1: the published value gives way to the control cost by a few centimetres.
Primitive precise() {
  Primitive primitive = place_primitive();
  primitive.tasks[0].rho = 1e3;
  return primitive;
}

Pose grasp_pose(const Eigen::VectorXd& q) { return schunk().pose(schunk().forward(q), schunk().grasp_frame()); }

/// c1 in the hand where the planned grasp of it ended, to be placed on c2.
PlanRequest place_request(std::uint64_t seed) {
  PlanRequest grasp = request(seed, hand_tuned());
  const Plan grasped = plan(schunk(), grasp);
  const Eigen::VectorXd q = grasped.trajectory.q.bottomRows(1).transpose();
  PlanRequest place = grasp;
  place.action = {"place", "c1", "c2"};
  place.primitive = place_primitive();
  place.q_start.assign(q.data(), q.data() + q.size());
  place.held = HeldObject{"c1", grasp_pose(q).inverse() * grasp.scene.objects[0].X_WO};
  return place;
}

Pose held_pose(const PlanRequest& place, const Plan& plan, int t) {
  return grasp_pose(plan.trajectory.q.row(t).transpose()) * place.held->X_GO;
}

TEST(Place, BaselineHasThePublishedPrecisions) {
  const std::vector<std::string> names = {"position", "lift", "upright", "collision", "limits", "homing"};
  EXPECT_EQ(place_primitive().rho_names(), names);
  const std::vector<double> log_rho = {1, 1, 1, -1, 1, -5};
  ASSERT_EQ(place_primitive().log_rho().size(), log_rho.size());
  for (std::size_t i = 0; i < log_rho.size(); ++i)
    EXPECT_NEAR(place_primitive().log_rho()[i], log_rho[i], 1e-12) << names[i];
}

/// Where the held object's centre is to be on an upright support of half height `half`: both half heights and 5 mm up.
Eigen::Vector3d goal_on(const Pose& X_WS, double half) {
  return X_WS.translation() + Eigen::Vector3d(0, 0, half + 0.054 + 0.005);
}

struct Ends {
  int upright = 0, within_2_cm = 0, within_a_diameter = 0;
};

/// How ten places from planned grasps end.
Ends place_in_ten_scenes(const Primitive& primitive) {
  Ends ends;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    auto place = place_request(seed);
    place.primitive = primitive;
    const Plan answer = plan(schunk(), place);
    EXPECT_EQ(answer.trajectory.q.rows(), 65) << answer.reason;
    EXPECT_TRUE(answer.trajectory.q.allFinite());
    const Pose X_WO = held_pose(place, answer, 64);
    const double error = (X_WO.translation() - goal_on(place.scene.objects[1].X_WO, 0.054)).norm();
    ends.upright += std::acos(std::min(1.0, X_WO.linear()(2, 2))) < 0.1;
    ends.within_2_cm += error < 0.02;
    ends.within_a_diameter += error < 0.075;
  }
  return ends;
}

TEST(Place, HandTunedPrimitiveEndsUprightOverTheSupport) {
  const Ends ends = place_in_ten_scenes(place_primitive());
  EXPECT_EQ(ends.upright, 10);
  EXPECT_GE(ends.within_a_diameter, 8);
}

TEST(Place, WithAPrecisePositionTheHeldObjectEndsUprightOnTheSupport) {
  const Ends ends = place_in_ten_scenes(precise());
  EXPECT_GE(ends.upright, 8);
  EXPECT_GE(ends.within_2_cm, 8);
}

TEST(Place, RandomPrecisionsNeverGiveWhatIsNotFinite) {
  for (std::uint64_t i = 0; i < 60; ++i) {
    Random random(11, "random_rho of place", {i});
    std::vector<double> rho(place_primitive().log_rho().size());
    for (double& value : rho) value = random.uniform(-3, 9);
    auto place = place_request(i % 5);
    place.primitive = place_primitive().with_log_rho(rho);
    place.primitive.max_iterations = 30;
    place.want_gains = true;
    const Plan answer = plan(schunk(), place);
    ASSERT_NE(answer.status, PlanStatus::bad_input) << i << ": " << answer.reason;
    ASSERT_TRUE(answer.trajectory.q.allFinite() && std::isfinite(answer.cost_final)) << i;
    for (const auto& K : answer.gains.K) ASSERT_TRUE(K.allFinite()) << i;
    ASSERT_LE(answer.cost_final, answer.cost_initial) << i;
  }
}

TEST(Place, LiftsFirstAndLowersLast) {
  const auto place = place_request(1);
  const Plan answer = plan(schunk(), place);
  const auto height = [&](int t) { return held_pose(place, answer, t).translation().z(); };
  // The ramps' sums: τ 0.2 Σ_{t=1}^{8} t/8 = 5.6 cm up, τ 0.2 Σ_{t=1}^{7} t/8 = 4.4 cm down after step 56.
  EXPECT_GT(height(8) - height(0), 0.028);
  EXPECT_GT(height(56) - height(64), 0.022);
  EXPECT_LT((held_pose(place, answer, 64).translation() - held_pose(place, answer, 56).translation()).head<2>().norm(),
            0.03);
}

TEST(Place, TheHeldObjectIsKeptClearOfWhatIsInTheWay) {
  // A wall between where c1 is and where it goes.
  auto place = place_request(2);
  const Eigen::Vector3d from = place.scene.objects[0].X_WO.translation(), to = from + Eigen::Vector3d(0, -0.3, 0);
  place.scene.objects[1].X_WO.translation() = to;
  scene::ObjectEstimate wall;
  wall.name = "wall";
  wall.shape = {ShapeType::box, {0.15, 0.01, 0.11}};
  wall.X_WO = pose(Eigen::Vector3d(0.5 * (from + to).x(), 0.5 * (from + to).y(), 0.78));
  place.scene.objects.push_back(wall);
  for (auto& task : place.primitive.tasks) {
    if (task.name == "collision") task.rho = 1e3;
    if (task.name == "position") task.rho = 1e4;
  }
  const auto deepest = [&](const Plan& answer) {
    double least = INFINITY;
    for (int t = 1; t <= 64; ++t) {
      const auto& c1 = place.scene.objects[0].shape;
      least = std::min(least, robot::distance(c1, held_pose(place, answer, t), wall.shape, wall.X_WO).distance);
    }
    return least;
  };
  EXPECT_GT(deepest(plan(schunk(), place)), 0);
  std::erase_if(place.primitive.tasks, [](const Task& task) { return task.name == "collision"; });
  EXPECT_LT(deepest(plan(schunk(), place)), 0);
}

void expect_refused(const PlanRequest& asked, const std::string& said) {
  const Plan answer = plan(schunk(), asked);
  EXPECT_EQ(answer.status, PlanStatus::bad_input);
  EXPECT_NE(answer.reason.find(said), std::string::npos) << answer.reason;
}

TEST(Place, BadRequestsAreRefusedWithWhatThereIs) {
  const auto good = place_request(1);
  auto asked = good;
  asked.held.reset();
  expect_refused(asked,
                 "task 'position': frame: 'held' is asked for, but the hand holds nothing; there are c1, c2, table");
  asked = good;
  asked.held->name = "c9";
  expect_refused(asked, "held: no object 'c9' in the scene; its objects are c1, c2");
  asked = good;
  asked.held->X_GO.translation().x() = NAN;
  expect_refused(asked, "held: the pose of 'c1' in the grasp frame is not finite");
  asked = good;
  asked.action.pop_back();
  expect_refused(asked, "the action has one argument only");
  asked = good;
  asked.action[2] = "c7";
  expect_refused(asked, "'second' is no object of the scene");
  asked = good;
  asked.primitive.tasks[0].of["frame"] = "elbow";
  expect_refused(asked, "thumb, finger_2, finger_3");
  asked.primitive.tasks[0].of = {{"from", "held"}};
  expect_refused(asked, "takes no 'from'; it takes frame, object, point");
  asked.primitive.tasks[0].of = {{"point", "below"}};
  expect_refused(asked, "expected one of centre, on_top");
  asked = good;
  asked.primitive.tasks[1].at = 0.6;
  expect_refused(asked, "0 … 0.5");
  asked.primitive.tasks[1].at = 0.1;
  asked.primitive.tasks[1].from_start = true;
  expect_refused(asked, "course of its own");
}

TEST(Place, TheTableCanBeTheSupport) {
  auto place = place_request(3);
  place.action[2] = place.scene.table.name;
  place.primitive = precise();
  const Plan answer = plan(schunk(), place);
  // Above the table's top: its own half height counts from its centre.
  const Eigen::Vector3d goal = goal_on(pose(place.scene.table.top_centre), 0);
  EXPECT_LT((held_pose(place, answer, 64).translation() - goal).norm(), 0.02) << answer.reason;
}

}  // namespace
}  // namespace primo::motion
