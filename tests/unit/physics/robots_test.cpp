// The judge with other hands: the parallel gripper, two to five fingers, with and without a thumb, sliding and coupled.
#include <gtest/gtest.h>

#include <algorithm>

#include "../robot/robot_text.h"
#include "../robot/style_text.h"
#include "grasp_fixture.h"
#include "physics/criteria.h"
#include "physics/grasp_trial.h"
#include "robot/distance.h"

namespace primo::physics {
namespace {

using robot::GeneratedRobot;
using testing::hand_made_grasp;
using testing::one_cylinder;
using testing::request_for;

const robot::Robot& gripper() {
  static const robot::Robot robot =
      robot::Robot::load(std::filesystem::path(PRIMO_SOURCE_DIR) / "configs/robots/column7_pg130.yaml").value();
  return robot;
}
const Judge& gripper_judge() {
  static const Judge judge(gripper());
  return judge;
}

/// How many of `seeds` jiggles a hand-made grasp, shifted in the grasp frame, survives.
int held(const Eigen::Vector3d& offset, int seeds, Mode mode = Mode::final_pose) {
  const auto scenario = one_cylinder();
  const auto grasp = hand_made_grasp(gripper(), scenario, offset);
  PRIMO_CHECK(grasp.has_value(), "the fixture finds a grasp");
  int count = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    auto request = request_for(scenario, *grasp, static_cast<std::uint64_t>(seed));
    request.mode = mode;
    const auto verdict = gripper_judge().evaluate(request);
    PRIMO_CHECK(verdict.ok(), verdict.error().message);
    count += verdict->success;
  }
  return count;
}

TEST(GripperJudge, a_good_grasp_survives_the_jiggle_and_one_displaced_by_five_centimetres_does_not) {
  EXPECT_GE(held({0, 0, 0}, 20), 19);
  // Along the opposition axis a finger would start inside the object; along the approach the fingers are short of it,
  // and along the object's own axis they hold its end.
  EXPECT_EQ(held({0.05, 0, 0}, 5), 0);
  EXPECT_EQ(held({0, 0, -0.07}, 5), 0);
}

TEST(GripperJudge, a_good_grasp_is_lifted_when_executed_and_a_miss_stays) {
  EXPECT_EQ(held({0, 0, 0}, 1, Mode::execute), 1);
  EXPECT_EQ(held({0, 0, -0.07}, 1, Mode::execute), 0);
}

TEST(GripperJudge, a_trajectory_of_the_other_robot_is_refused) {
  const auto scenario = one_cylinder();
  const auto grasp = hand_made_grasp(testing::load_robot(), scenario);
  ASSERT_TRUE(grasp.has_value());
  const auto verdict = gripper_judge().evaluate(request_for(scenario, *grasp));
  ASSERT_FALSE(verdict.ok());
  EXPECT_NE(verdict.error().message.find("14 columns; robot column7_pg130 has 8"), std::string::npos)
      << verdict.error().message;
}

TEST(BackOff, opens_a_gripper_in_metres_until_it_is_clear) {
  const auto scenario = one_cylinder();
  const auto grasp = hand_made_grasp(gripper(), scenario);
  ASSERT_TRUE(grasp.has_value());
  Eigen::VectorXd q = grasp->q.bottomRows(1).transpose();
  const auto& object = *scenario.object("c1");
  const auto gap = [&](const Eigen::VectorXd& at) {
    double smallest = 1;
    const auto kinematics = gripper().forward(at);
    for (const auto& link : gripper().link_shapes()) {
      if (!link.hand) continue;
      smallest = std::min(
          smallest,
          robot::distance(link.shape, gripper().pose(kinematics, link), object.shape(), object.X_WO()).distance);
    }
    return smallest;
  };
  // A side grasp's ribs touch the cylinder at its radius: 4 mm less is 4 mm inside.
  q[7] = 0.0375 - 0.004;
  ASSERT_NEAR(gap(q), -0.004, 3e-4);
  const Eigen::VectorXd opened = back_off(gripper(), q, object.shape(), object.X_WO(), 0.4);
  EXPECT_GE(gap(opened), 0);
  EXPECT_LE(opened[7] - q[7], 0.0065) << "no more than three steps of 2 mm";
  EXPECT_EQ(opened.head(7), q.head(7));
  // And the other way: closed from open, neither finger goes further than one step past touch.
  q[7] = 0.06;
  const Eigen::VectorXd closed = close_onto(gripper(), q, object.shape(), object.X_WO());
  EXPECT_NEAR(closed[7], 0.0375, 1.2e-3);
}

TEST(Criteria, a_slides_range_counts_as_half_a_turn_and_its_speed_by_its_own_limit) {
  const auto robot = robot::generated_robot({.arm = 4, .fingers = 2, .slides = true, .rail = true});
  const auto scenario = one_cylinder();
  Eigen::MatrixXd q(2, robot.joints());
  q.row(0) = robot.home().transpose();
  q.row(1) = q.row(0);
  q(1, 0) += 0.02;  // the rail
  const JudgeSettings settings;
  const auto found = evaluate_criteria({robot, scenario, "c1", q, 0.1, 0, settings});
  // 0.2 m/s of 0.5 m/s are as much as 0.8 rad/s of 2 rad/s.
  EXPECT_EQ(found[3].name, "joint_speed");
  EXPECT_NEAR(found[3].value, 0.8, 1e-12);
  EXPECT_TRUE(found[3].met);
  // A finger 1 cm from the end of its 8 cm.
  EXPECT_EQ(found[2].name, "limit_margin");
  EXPECT_NEAR(found[2].value, 0.01 / 0.08 * M_PI, 1e-12);
  EXPECT_NEAR(found[4].value, 0.02 / 3.0 * M_PI, 1e-12);
}

class Hands : public ::testing::TestWithParam<GeneratedRobot> {
 protected:
  /// A cylinder of 3 cm radius, shifted in the grasp frame, and the hand about it with its approach pointing down.
  TrialResult grip(const Eigen::Vector3d& offset, std::uint64_t seed) {
    const auto robot = robot::generated_robot(GetParam());
    const Model whole = robot_model(robot).value();
    const Shape object{ShapeType::cylinder, {0.03, 0.05, 0}};
    HandWorkspace workspace = HandWorkspace::create(robot, whole.get(), object, 0.3, 0.002).value();
    const auto home = robot.forward(robot.home());
    const int palm = robot.bodies()[static_cast<std::size_t>(robot.body("palm"))].parent;
    const Pose X_PG = home.X_WB[static_cast<std::size_t>(palm)].inverse() * robot.pose(home, robot.grasp_frame());
    const Pose X_WG = pose(Eigen::Vector3d(0.8, 0, 0.72), Eigen::Vector3d(M_PI, 0, 0));
    const Pose X_WO = X_WG * pose(offset);
    return run_trial(robot, workspace, robot.home(), X_WG * X_PG.inverse(), X_WO, offset.norm(), {}, seed);
  }
};

TEST_P(Hands, hold_what_is_between_their_fingers_and_miss_what_is_not) {
  int count = 0;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const TrialResult result = grip({0, 0, 0}, seed);
    EXPECT_NE(result.outcome, Outcome::unstable);
    count += result.outcome == Outcome::held;
  }
  EXPECT_GE(count, 4);
  const TrialResult miss = grip({0, 0, 0.12}, 0);
  EXPECT_EQ(miss.outcome, Outcome::no_contact) << miss.reason;
  EXPECT_GT(miss.steps, 0);
}

/// How a hand in Menagerie's style, its jaws coupled as `coupling` says, fares with a cylinder that stands off the
/// middle of its jaws.
TrialResult grip_off_middle(const std::string& coupling, double off, std::uint64_t seed) {
  const robot::RobotFolder folder;
  write_model(folder, coupling);
  const robot::Robot robot = folder.load().value();
  const Model whole = robot_model(robot).value();
  const Shape object{ShapeType::cylinder, {0.02, 0.03, 0}};
  HandWorkspace workspace = HandWorkspace::create(robot, whole.get(), object, 0.1, 0.002).value();
  const auto home = robot.forward(robot.home());
  const Pose X_PG = home.X_WB[static_cast<std::size_t>(robot.tool_body())].inverse(Eigen::Isometry) *
                    robot.pose(home, robot.grasp_frame());
  const Pose X_WG = pose(Eigen::Vector3d(0.8, 0, 0.72), Eigen::Vector3d(M_PI, 0, 0));
  return run_trial(robot, workspace, robot.home(), X_WG * X_PG.inverse(Eigen::Isometry),
                   X_WG * pose(Eigen::Vector3d(off, 0, 0)), std::abs(off), {}, seed);
}

TEST(CoupledJaws, push_what_stands_off_their_middle_between_them_and_hold_it) {
  for (const char* coupling : {robot::kJaws, R"(<joint joint1="one" joint2="two" solref="0.005 1"/>)",
                               R"(<tendon tendon1="difference" solref="0.005 1"/>)"}) {
    for (const double off : {0.0, 0.005, -0.012}) {
      int held = 0;
      for (std::uint64_t seed = 0; seed < 5; ++seed) {
        const TrialResult result = grip_off_middle(coupling, off, seed);
        EXPECT_NE(result.outcome, Outcome::unstable) << result.reason;
        held += result.outcome == Outcome::held;
        if (result.outcome == Outcome::held) {
          // Both pads press, so the object is in their middle: the palm's y, as far as a contact yields.
          EXPECT_NEAR((pose(Eigen::Vector3d(0, 0, 0.1)).inverse() * result.X_PO).translation().head<2>().norm(), 0,
                      0.004)
              << coupling << " off by " << off;
        }
      }
      EXPECT_GE(held, 4) << coupling << " off by " << off;
    }
  }
}

TEST(CoupledJaws, leave_what_they_would_have_to_push_far) {
  // Wider open than they are, so that 24 mm off the middle is still between them.
  const auto robot = robot::generated_robot({.fingers = 2, .slides = true, .coupled = true});
  const Model whole = robot_model(robot).value();
  const Shape object{ShapeType::cylinder, {0.03, 0.05, 0}};
  HandWorkspace workspace = HandWorkspace::create(robot, whole.get(), object, 0.3, 0.002).value();
  const auto home = robot.forward(robot.home());
  const Pose X_PG = home.X_WB[static_cast<std::size_t>(robot.tool_body())].inverse(Eigen::Isometry) *
                    robot.pose(home, robot.grasp_frame());
  const auto trial = [&](double off) {
    return run_trial(robot, workspace, robot.home(), X_PG.inverse(Eigen::Isometry), pose(Eigen::Vector3d(off, 0, 0)),
                     std::abs(off), {}, 3);
  };
  const TrialResult far = trial(0.03), near = trial(0.01), again = trial(0.03);
  EXPECT_EQ(near.outcome, Outcome::held) << near.reason;
  EXPECT_EQ(far.outcome, Outcome::not_opposed) << far.reason;
  EXPECT_NE(far.reason.find("push the object by more than 20 mm"), std::string::npos) << far.reason;
  EXPECT_EQ(again.steps, far.steps) << "what a trial changes does not reach the next";
  EXPECT_EQ(again.X_PO.matrix(), far.X_PO.matrix());
}

TEST(Grip, of_a_hand_without_a_thumb_needs_pushes_from_opposite_sides) {
  Grip grip;
  grip.has_thumb = false;
  grip.fingers = 1;
  grip.only = "left";
  EXPECT_FALSE(grip.opposed());
  EXPECT_NE(grip.complaint().find("only fingertip left"), std::string::npos);
  grip.fingers = 2;
  EXPECT_FALSE(grip.opposed());
  EXPECT_NE(grip.complaint().find("same side"), std::string::npos);
  grip.from_sides = true;
  EXPECT_TRUE(grip.opposed());
}

TEST(Grip, is_found_from_the_contacts_of_a_posed_hand) {
  const auto robot = robot::generated_robot({.fingers = 2, .slides = true});
  const Model whole = robot_model(robot).value();
  const Shape object{ShapeType::cylinder, {0.03, 0.05, 0}};
  HandWorkspace hand = HandWorkspace::create(robot, whole.get(), object, 0.3, 0.002).value();
  const auto home = robot.forward(robot.home());
  const int palm = robot.bodies()[static_cast<std::size_t>(robot.body("palm"))].parent;
  const Pose X_PG = home.X_WB[static_cast<std::size_t>(palm)].inverse() * robot.pose(home, robot.grasp_frame());
  const auto grip = [&](double first, double second) {
    Eigen::VectorXd q = robot.home();
    q.tail(2) << first, second;
    mj_resetData(hand.model.get(), hand.data.get());
    hand.joints.set(hand.data.get(), q);
    set_free_joint(hand.model.get(), hand.data.get(), hand.object_joint, X_PG);
    mj_forward(hand.model.get(), hand.data.get());
    return hand.joints.grip(hand.model.get(), hand.data.get(), hand.object_geom);
  };
  // A finger's surface is at its q; the cylinder's at 0.03.
  EXPECT_EQ(grip(0.05, 0.05).parts(), 0);
  EXPECT_EQ(grip(0.029, 0.05).only, "tip0");
  EXPECT_FALSE(grip(0.029, 0.05).opposed());
  EXPECT_EQ(grip(0.029, 0.029).parts(), 2);
  EXPECT_TRUE(grip(0.029, 0.029).opposed());
}

INSTANTIATE_TEST_SUITE_P(Fingers, Hands,
                         ::testing::Values(GeneratedRobot{.fingers = 2, .slides = true},
                                           GeneratedRobot{.fingers = 2, .slides = true, .coupled = true},
                                           GeneratedRobot{.fingers = 3}, GeneratedRobot{.fingers = 3, .thumb = true},
                                           GeneratedRobot{.fingers = 3, .coupled = true},
                                           GeneratedRobot{.fingers = 4, .slides = true}, GeneratedRobot{.fingers = 5},
                                           GeneratedRobot{.fingers = 5, .thumb = true}),
                         [](const auto& about) {
                           const GeneratedRobot& r = about.param;
                           return "of_" + std::to_string(r.fingers) + (r.slides ? "_sliding" : "") +
                                  (r.coupled ? "_coupled" : "") + (r.thumb ? "_with_thumb" : "");
                         });

TEST(HandModel, keeps_tendons_that_couple_fingers) {
  const robot::RobotFolder folder;
  write_robot(folder, {.fingers = 2, .slides = true, .coupled = true});
  std::string text = read_file(folder.path("robot.xml")).value();
  const auto at = text.find("<equality>");
  text.replace(
      at, text.find("</equality>") + 11 - at,
      "<tendon><fixed name=\"difference\" damping=\"2\"><joint joint=\"f0\" coef=\"1\"/><joint joint=\"f1\" "
      "coef=\"-1\"/></fixed></tendon><equality><tendon tendon1=\"difference\" polycoef=\"0 1 0 0 0\" solref=\"0.005 "
      "1\"/></equality>");
  folder.put("robot.xml", text);
  const robot::Robot robot = folder.load().value();
  const Model whole = robot_model(robot).value();
  const Model hand = hand_model(robot, whole.get(), {ShapeType::sphere, {0.03, 0, 0}}, 0.3, 0.002).value();
  ASSERT_EQ(hand->ntendon, 1);
  ASSERT_EQ(hand->neq, 1);
  EXPECT_EQ(hand->eq_type[0], mjEQ_TENDON);
  EXPECT_EQ(hand->tendon_damping[0], 2);
  EXPECT_EQ(hand->wrap_prm[1], -1);
}

TEST(Assemble, a_robots_own_options_defaults_keyframes_and_contact_bits_do_not_reach_the_scene) {
  const robot::RobotFolder folder;
  write_robot(folder, {.arm = 4, .fingers = 2, .slides = true, .coupled = true});
  std::string text = read_file(folder.path("robot.xml")).value();
  text.replace(text.find("<worldbody>"), 0,
               "<option integrator=\"RK4\" gravity=\"0 0 0\" timestep=\"0.01\" cone=\"pyramidal\"/><size njmax=\"5\"/>"
               "<default><geom margin=\"0.01\" priority=\"3\" solmix=\"7\" condim=\"1\"/><joint damping=\"9\" "
               "armature=\"4\"/></default>");
  text.replace(
      text.find("</mujoco>"), 0,
      "<actuator><position joint=\"j0\" kp=\"1000\"/></actuator><keyframe><key qpos=\"0 0 0 0 0 0\"/></keyframe>");
  folder.put("robot.xml", text);
  const robot::Robot robot = folder.load().value();
  const auto scenario = one_cylinder();
  const Model with = assemble(&robot, scenario).value(), without = assemble(nullptr, scenario).value();
  EXPECT_EQ(with->opt.integrator, without->opt.integrator);
  EXPECT_EQ(with->opt.cone, without->opt.cone);
  EXPECT_EQ(with->opt.timestep, without->opt.timestep);
  EXPECT_EQ(with->opt.gravity[2], without->opt.gravity[2]);
  EXPECT_GE(with->njmax, 400);
  EXPECT_EQ(with->nu, 0);
  EXPECT_EQ(with->nkey, 0);
  const int a = with.geom("object:c1"), b = without.geom("object:c1");
  EXPECT_EQ(with->geom_margin[a], without->geom_margin[b]);
  EXPECT_EQ(with->geom_priority[a], without->geom_priority[b]);
  EXPECT_EQ(with->geom_solmix[a], without->geom_solmix[b]);
  EXPECT_EQ(with->geom_condim[a], without->geom_condim[b]);
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ(with->dof_damping[with->jnt_dofadr[with.joint("c1")] + i], 0);
    EXPECT_EQ(with->dof_armature[with->jnt_dofadr[with.joint("c1")] + i], 0);
  }
  int robot_geoms = 0;
  for (int g = 0; g < with->ngeom; ++g) {
    if (with->geom_group[g] != kRobotGroup) continue;
    ++robot_geoms;
    EXPECT_EQ(with->geom_contype[g], kRobotContype);
    EXPECT_EQ(with->geom_conaffinity[g], kRobotConaffinity);
  }
  EXPECT_EQ(robot_geoms, static_cast<int>(robot.link_shapes().size()));
}

TEST(Assemble, hides_the_shapes_that_collide_where_there_are_others_for_the_eye) {
  const Model model = assemble(&gripper(), one_cylinder()).value();
  EXPECT_EQ(model->geom_group[model.geom("left_rib_1")], kHiddenGroup);
  EXPECT_EQ(model->geom_group[model.geom("upper_arm")], kRobotGroup);
  int shells = 0;
  for (int g = 0; g < model->ngeom; ++g)
    shells += model->geom_type[g] == mjGEOM_MESH && model->geom_group[g] == kRobotGroup;
  EXPECT_EQ(shells, 2);
}

}  // namespace
}  // namespace primo::physics
