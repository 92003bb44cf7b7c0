#include "physics/set_down.h"

#include <gtest/gtest.h>

#include "grasp_fixture.h"
#include "place_fixture.h"

namespace primo::physics {
namespace {

struct World {
  robot::Robot robot = testing::load_robot();
  Judge judge{robot};
  scene::Scenario scenario;
  World() { scenario = testing::place_at(robot, {0, 0, 0}).value().scenario; }
};
const World& world() {
  static const World instance;
  return instance;
}

/// c1 lifted, carried through these places, given from where it stands on c2, m in W.
JudgeRequest carried(const std::vector<Eigen::Vector3d>& offsets) {
  JudgeRequest request;
  request.scenario = world().scenario;
  request.dt = 0.0625;
  const Eigen::Vector3d top = testing::top_of_support(request.scenario);
  Eigen::Vector3d lifted = request.scenario.object("c1")->position;
  lifted.z() = std::max(lifted.z(), top.z()) + 0.06;
  std::vector<Eigen::Vector3d> places = {lifted};
  for (const auto& offset : offsets) places.push_back(top + offset);
  const auto path = testing::carry(world().robot, request.scenario, places);
  PRIMO_CHECK(path.has_value(), "the arm can carry c1 this way");
  request.q = *path;
  return request;
}

/// Horizontal, unit, from c2 to where c1 comes from.
Eigen::Vector3d outward() {
  Eigen::Vector3d away = world().scenario.object("c1")->position - world().scenario.object("c2")->position;
  away.z() = 0;
  return away.normalized();
}

Verdict judged(JudgeRequest request, Mode mode = Mode::final_pose) {
  request.mode = mode;
  auto verdict = world().judge.evaluate(request);
  PRIMO_CHECK(verdict.ok(), verdict.error().message);
  return std::move(verdict).value();
}

/// Of the held object's centre in each row, m in W.
Eigen::Vector3d centre(const Eigen::Ref<const Eigen::RowVectorXd>& q) {
  const auto& robot = world().robot;
  return (robot.pose(robot.forward(q.transpose()), robot.grasp_frame()) * world().scenario.held->X_GO()).translation();
}

constexpr double kHigh = 0.06;

TEST(SetDown, straight_down_a_few_millimetres_into_the_support_is_a_clean_path) {
  for (const double depth : {0.0, 0.002, 0.004, 0.0055}) {
    const auto request = carried({{0, 0, kHigh}, {0, 0, -depth}});
    const Verdict v = judged(request);
    EXPECT_TRUE(v.success) << depth << ": " << v.reason;
    EXPECT_NEAR(v.target_clearance, -depth, 1e-3);
    EXPECT_TRUE(judged(request, Mode::execute).success) << depth;
  }
  EXPECT_FALSE(judged(carried({{0, 0, kHigh}, {0, 0, -0.008}})).path_clean);
}

TEST(SetDown, sideways_into_the_rim_is_refused_however_late_it_comes) {
  for (const double depth : {0.002, 0.004, 0.006}) {
    // Down beside the support, then across its top, in the last quarter of the motion or, after a long wait, in the
    // last tenth.
    const Eigen::Vector3d beside = 0.1 * outward() - Eigen::Vector3d(0, 0, depth), on(0, 0, -depth);
    const Eigen::Vector3d above = beside + Eigen::Vector3d(0, 0, kHigh);
    for (const std::size_t wait : {0, 6}) {
      std::vector<Eigen::Vector3d> places = {above, beside};
      places.insert(places.end(), wait, beside);
      places.push_back(on);
      const JudgeRequest request = carried(places);
      const Verdict v = judged(request);
      EXPECT_TRUE(v.final_pose_success || depth >= 0.006) << "the final pose alone would not tell: " << v.reason;
      EXPECT_FALSE(v.path_clean) << depth << ", " << wait;
      EXPECT_LT(v.target_clearance, v.criteria[1].margin - depth / 2);
      EXPECT_NE(v.reason.find("touches c2 first"), std::string::npos) << v.reason;
      const Verdict executed = judged(request, Mode::execute);
      EXPECT_FALSE(executed.final_pose_success) << depth << ", " << wait << ": " << executed.reason;
    }
  }
}

TEST(SetDown, an_object_must_pass_the_rim_by_more_than_the_arm_gives_under_it) {
  const auto across = [](double height) {
    const Eigen::Vector3d beside = 0.1 * outward() + Eigen::Vector3d(0, 0, height);
    return carried({beside + Eigen::Vector3d(0, 0, kHigh), beside, {0, 0, height}});
  };
  const JudgeRequest grazing = across(0.0003);
  EXPECT_TRUE(judged(grazing).final_pose_success);
  EXPECT_FALSE(judged(grazing).path_clean) << "clear as planned, and not as the arm carries it";
  EXPECT_FALSE(judged(grazing, Mode::execute).final_pose_success);
  const JudgeRequest clear = across(0.005);
  EXPECT_TRUE(judged(clear).success) << judged(clear).reason;
  EXPECT_TRUE(judged(clear, Mode::execute).success);
}

TEST(SetDown, contact_may_begin_where_the_foot_has_so_far_to_go_that_the_support_leans_by_the_tilt_of_a_place) {
  const JudgeSettings settings;
  const auto& scenario = world().scenario;
  EXPECT_DOUBLE_EQ(contact_travel(scenario, settings), settings.place_tilt * scenario.object("c2")->height);
  scene::Scenario on_table = scenario;
  on_table.action[2] = scenario.table.name;
  EXPECT_DOUBLE_EQ(contact_travel(on_table, settings), settings.place_tilt * scenario.object("c1")->height);

  const JudgeRequest request = carried({{0, 0, kHigh}, 0.03 * outward() + Eigen::Vector3d(0, 0, 0.01), {0, 0, 0}});
  const SetDown parts = set_down(world().robot, scenario, settings, request.q);
  EXPECT_EQ(parts.approach.rows() + parts.contact.rows(), request.q.rows() + 2);
  EXPECT_EQ(parts.contact.bottomRows(1), request.q.bottomRows(1));
  double travel = 0;
  for (Eigen::Index t = 1; t < parts.contact.rows(); ++t)
    travel += (centre(parts.contact.row(t)) - centre(parts.contact.row(t - 1))).head<2>().norm();
  EXPECT_NEAR(travel, contact_travel(scenario, settings), 1e-4);
  EXPECT_EQ(parts.approach.bottomRows(1), loaded(world().robot, scenario, parts.contact.topRows(1)));

  // Pressed down and dragged so far, the support stands again afterwards.
  const Eigen::Vector3d pressed(0, 0, -0.005);
  for (const double side : {-1.0, 1.0}) {
    const Eigen::Vector3d beside = side * (contact_travel(scenario, settings) - 5e-4) * outward();
    const JudgeRequest dragged = carried({beside + Eigen::Vector3d(0, 0, kHigh), beside + pressed, pressed});
    EXPECT_TRUE(judged(dragged).success) << judged(dragged).reason;
    EXPECT_TRUE(judged(dragged, Mode::execute).success) << judged(dragged, Mode::execute).reason;
  }

  // Who does not move sideways may touch all the time.
  const Eigen::MatrixXd down = carried({{0, 0, kHigh}, {0, 0, 0}}).q.bottomRows(32);
  EXPECT_EQ(set_down(world().robot, scenario, settings, down).contact, down);
}

TEST(SetDown, the_arm_gives_under_its_load_where_drives_and_weight_balance) {
  // Stationary energy: kp_i δ_i = −m g ∂z/∂q_i, here by differences.
  const auto& robot = world().robot;
  const auto& scenario = world().scenario;
  const Eigen::RowVectorXd q = carried({{0, 0, kHigh}}).q.bottomRows(1);
  const Eigen::RowVectorXd bent = loaded(robot, scenario, q);
  for (int i = 0; i < robot.joints(); ++i) {
    if (i >= robot.arm_joints()) {
      EXPECT_EQ(bent[i], q[i]);
      continue;
    }
    constexpr double kStep = 1e-5;
    Eigen::RowVectorXd up = q, down = q;
    up[i] += kStep;
    down[i] -= kStep;
    const double slope = (centre(up).z() - centre(down).z()) / (2 * kStep);
    const double kp = robot.file().arm[static_cast<std::size_t>(i)].kp;
    EXPECT_NEAR(kp * (bent[i] - q[i]), -9.81 * scenario.object("c1")->mass * slope, 1e-6);
  }
}

TEST(SetDown, an_executed_arm_hangs_as_low_as_its_load_bends_it_and_less_than_two_millimetres_lower) {
  // It hovers over the support for the last two of eight seconds.
  const JudgeRequest request = carried({{0, 0, kHigh}, {0, 0, 0.04}, {0, 0, 0.04}});
  JudgeRequest executed = request;
  executed.mode = Mode::execute;
  Recording recording;
  ASSERT_TRUE(world().judge.evaluate(executed, &recording).ok());
  const double planned = centre(request.q.bottomRows(1)).z();
  const double bent = centre(loaded(world().robot, request.scenario, request.q.bottomRows(1))).z();
  ASSERT_LT(bent, planned - 5e-4);
  const auto frame = std::find_if(recording.frames.begin(), recording.frames.end(),
                                  [](const Recording::Frame& f) { return f.time > 7.5; });
  ASSERT_NE(frame, recording.frames.end());
  const double found = frame->X_WO[0].translation().z();
  EXPECT_LT(found, bent + 5e-4);
  EXPECT_GT(found, bent - 2e-3);
}

}  // namespace
}  // namespace primo::physics
