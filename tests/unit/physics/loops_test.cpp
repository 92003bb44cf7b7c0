// The judge with a gripper whose fingers are carried by closed loops.
#include <gtest/gtest.h>

#include "../robot/four_bar_text.h"
#include "grasp_fixture.h"
#include "physics/grasp_trial.h"
#include "verdict_bytes.h"

namespace primo::physics {
namespace {

using robot::FourBar;
using testing::hand_made_grasp;
using testing::one_cylinder;
using testing::request_for;

/// The gripper; its files stay as long as the tests, for the judge reads the model again.
const Judge& judge() {
  static const robot::RobotFolder folder;
  static const Judge judge([] {
    write_four_bar(folder);
    return folder.load().value();
  }());
  return judge;
}

Verdict verdict_of(const Eigen::Vector3d& offset, std::uint64_t seed, Mode mode) {
  const auto scenario = one_cylinder();
  const auto grasp = hand_made_grasp(judge().robot(), scenario, offset);
  PRIMO_CHECK(grasp.has_value(), "the fixture finds a grasp");
  auto request = request_for(scenario, *grasp, seed);
  request.mode = mode;
  return judge().evaluate(request).value();
}

TEST(FourBarJudge, a_centred_grasp_is_held_and_one_displaced_by_five_centimetres_is_not) {
  int held = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const Verdict verdict = verdict_of({0, 0, 0}, seed, Mode::final_pose);
    held += verdict.success;
    EXPECT_TRUE(verdict.path_clean) << verdict.reason;
  }
  EXPECT_GE(held, 9);
  for (const double across : {-0.05, 0.05}) EXPECT_FALSE(verdict_of({across, 0, 0}, 1, Mode::final_pose).success);
}

TEST(FourBarJudge, a_centred_grasp_is_lifted_when_executed_and_a_displaced_one_is_not) {
  const Verdict verdict = verdict_of({0, 0, 0}, 1, Mode::execute);
  EXPECT_TRUE(verdict.success) << verdict.reason;
  EXPECT_FALSE(verdict_of({0.05, 0, 0}, 1, Mode::execute).success);
}

TEST(FourBarJudge, the_same_request_gets_the_same_bytes_from_a_robot_read_twice) {
  const robot::RobotFolder folder;
  write_four_bar(folder);
  const Judge second(folder.load().value());
  const auto scenario = one_cylinder();
  const auto grasp = hand_made_grasp(judge().robot(), scenario);
  ASSERT_TRUE(grasp.has_value());
  for (const Mode mode : {Mode::final_pose, Mode::execute}) {
    auto request = request_for(scenario, *grasp, 7);
    request.mode = mode;
    const std::string first = testing::bytes(judge().evaluate(request).value());
    EXPECT_EQ(testing::bytes(judge().evaluate(request).value()), first);
    EXPECT_EQ(testing::bytes(second.evaluate(request).value()), first);
  }
}

/// All that the equality constraints of two models say, bodies by name.
void expect_same_equalities(const Model& whole, const Model& hand) {
  ASSERT_EQ(whole->neq, hand->neq);
  for (int e = 0; e < whole->neq; ++e) {
    ASSERT_EQ(whole->eq_type[e], hand->eq_type[e]);
    if (whole->eq_type[e] == mjEQ_JOINT) continue;
    EXPECT_STREQ(mj_id2name(whole.get(), mjOBJ_BODY, whole->eq_obj1id[e]),
                 mj_id2name(hand.get(), mjOBJ_BODY, hand->eq_obj1id[e]));
    EXPECT_STREQ(mj_id2name(whole.get(), mjOBJ_BODY, whole->eq_obj2id[e]),
                 mj_id2name(hand.get(), mjOBJ_BODY, hand->eq_obj2id[e]));
    for (int k = 0; k < mjNEQDATA; ++k)
      EXPECT_NEAR(whole->eq_data[mjNEQDATA * e + k], hand->eq_data[mjNEQDATA * e + k], 1e-12) << k;
    for (int k = 0; k < mjNREF; ++k) EXPECT_EQ(whole->eq_solref[mjNREF * e + k], hand->eq_solref[mjNREF * e + k]);
  }
}

TEST(HandModel, keeps_the_loops_of_the_hand) {
  for (const FourBar& about :
       {FourBar{},
        FourBar{.connect = R"(<weld body1="SIDE_crank" body2="SIDE_finger" anchor="0.01 0.02 0.03" torquescale="0.3"/>
                                         <joint joint1="SIDE_rocker" joint2="SIDE"/>)"}}) {
    const robot::RobotFolder folder;
    write_four_bar(folder, about);
    const robot::Robot robot = folder.load().value();
    const Model whole = robot_model(robot).value();
    const Model hand = hand_model(robot, whole.get(), {ShapeType::sphere, {0.03, 0, 0}}, 0.3, 0.002).value();
    expect_same_equalities(whole, hand);
  }
}

TEST(Loops, are_closed_where_the_simulation_begins_and_while_it_closes) {
  const auto& robot = judge().robot();
  const Model whole = robot_model(robot).value();
  HandWorkspace hand =
      HandWorkspace::create(robot, whole.get(), {ShapeType::cylinder, {0.0375, 0.1, 0}}, 0.3, 0.002).value();
  mjData* d = hand.data.get();
  const auto gap = [&] {
    double widest = 0;
    for (const std::string side : {"left", "right"}) {
      const auto at = [&](const std::string& body, const Eigen::Vector3d& p) {
        return Eigen::Vector3d(body_pose(d, hand.model.body(side + body)) * p);
      };
      widest = std::max(widest, (at("_rocker", {0, 0, 0.07}) - at("_finger", {0.03, 0, 0})).norm());
    }
    return widest;
  };
  for (const double crank : {-0.25, 0.1, 0.7}) {
    Eigen::VectorXd q = robot.home();
    q[7] = crank;
    hand.joints.set(d, q);
    mj_forward(hand.model.get(), d);
    EXPECT_LT(gap(), 1e-7);
  }
  // From open until the fingers press the object with all their torque.
  set_free_joint(hand.model.get(), d, hand.object_joint,
                 palm_pose(robot, robot.home()).inverse(Eigen::Isometry) *
                     robot.pose(robot.forward(robot.home()), robot.grasp_frame()) *
                     pose(Eigen::Vector3d::Zero(), Eigen::Vector3d(M_PI / 2, 0, 0)));
  const Eigen::VectorXd held = robot.home().tail(1);
  double widest = 0;
  for (int k = 0; k < 500; ++k) {
    mj_step1(hand.model.get(), d);
    hand.joints.close(robot, d, held);
    mj_step2(hand.model.get(), d);
    widest = std::max(widest, gap());
  }
  EXPECT_TRUE(hand.joints.grip(hand.model.get(), d, hand.object_geom).opposed());
  EXPECT_LT(widest, 1e-3) << "the constraints of the model yield, but hold";
}

TEST(FingerOfBody, counts_the_links_of_a_loop_to_their_finger) {
  const auto& robot = judge().robot();
  const auto finger = finger_of_body(robot);
  for (const auto& [side, tip] : {std::pair("left", 0), std::pair("right", 1)}) {
    for (const char* link : {"_crank", "_finger", "_rocker"})
      EXPECT_EQ(finger[static_cast<std::size_t>(robot.body(std::string(side) + link))], tip) << side << link;
  }
  EXPECT_EQ(finger[static_cast<std::size_t>(robot.body("gripper"))], -1);
}

}  // namespace
}  // namespace primo::physics
