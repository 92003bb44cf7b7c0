// Hands with closed loops, against the equations of their linkages.
#include "robot/loops.h"

#include <gtest/gtest.h>

#include <cmath>

#include "four_bar_text.h"
#include "robot/robot.h"

namespace primo::robot {
namespace {

Robot four_bar(const FourBar& about = {}) {
  const RobotFolder folder;
  write_four_bar(folder, about);
  auto robot = folder.load();
  PRIMO_CHECK(robot.ok(), robot.error().message);
  return std::move(robot).value();
}

std::string refusal_of(const FourBar& about) {
  const RobotFolder folder;
  write_four_bar(folder, about);
  return folder.error();
}

double value(const Robot& robot, const std::string& name, double crank) {
  for (const auto& joint : robot.chain()) {
    if (joint.name == name) return joint.value(crank);
  }
  PRIMO_CHECK(false, "no joint " + name);
}

Eigen::VectorXd with_crank(const Robot& robot, double crank) {
  Eigen::VectorXd q = robot.home();
  q[robot.joints() - 1] = crank;
  return q;
}

/// How far the end of a rocker is from its place on the finger, m.
double gap(const Robot& robot, const Kinematics& k, const std::string& side, double rocker, double drop) {
  const auto at = [&](const std::string& name, const Eigen::Vector3d& p) {
    return Eigen::Vector3d(k.X_WB[static_cast<std::size_t>(robot.body(side + name))] * p);
  };
  return (at("_rocker", {0, 0, rocker}) - at("_finger", {kRockerAway, 0, -drop})).norm();
}

TEST(Loops, OfParallelogramsCarryTheFingersParallel) {
  const Robot robot = four_bar();
  EXPECT_EQ(robot.joints(), 8);
  EXPECT_EQ(robot.loops().size(), 2U);
  EXPECT_EQ(robot.lower()[7], -0.3);
  EXPECT_EQ(robot.upper()[7], 0.85);
  for (double crank = -0.3; crank <= 0.85; crank += 0.023) {
    for (const std::string side : {"left", "right"}) {
      EXPECT_NEAR(value(robot, side + "_knuckle", crank), -crank, 1e-8);
      EXPECT_NEAR(value(robot, side + "_rocker", crank), crank, 1e-8);
    }
    const Kinematics k = robot.forward(with_crank(robot, crank));
    EXPECT_LT(gap(robot, k, "left", kCrank, 0), 1e-7);
    const Pose X_GL = robot.pose(k, robot.grasp_frame()).inverse() * robot.pose(k, robot.fingertips()[0].frame);
    EXPECT_NEAR(X_GL.translation().x(), kPivot + kCrank * std::sin(crank), 1e-8);
    EXPECT_NEAR(X_GL.translation().z(), 0.07 + kCrank * std::cos(crank) + 0.071 - 0.2088, 1e-8);
    EXPECT_LT((X_GL.linear().col(2) + Eigen::Vector3d::UnitX()).norm(), 1e-8) << "the pad faces the other finger";
  }
}

/// A rocker of 60 mm: at θ = 0 its end is 10 mm below the finger's foot, so the coupler is √(30² + 10²) mm long.
const FourBar kUnequal = {
    .connect = R"(<connect body1="SIDE_rocker" body2="SIDE_finger" anchor="0 0 0.06" solref="0.005 1"/>)"};

/// The rocker's angle of that linkage: where the circles of rocker and coupler meet, on the side of the assembly.
double rocker_angle(double crank) {
  const Eigen::Vector2d P(kCrank * std::sin(crank), kCrank * std::cos(crank)), B(kRockerAway, 0);
  const double r = 0.06, c = std::hypot(0.03, 0.01), d = (P - B).norm();
  const double along = (d * d + r * r - c * c) / (2 * d), across = std::sqrt(r * r - along * along);
  const Eigen::Vector2d e = (P - B) / d, n(e.y(), -e.x());  // n: to the right of e, outwards
  const Eigen::Vector2d Q = B + along * e + across * n;
  return std::atan2(Q.x() - B.x(), Q.y());
}

TEST(Loops, OfUnequalLinksFollowTheCirclesOfTheirLinks) {
  const Robot robot = four_bar(kUnequal);
  ASSERT_NEAR(rocker_angle(0), 0, 1e-12);
  for (double crank = robot.lower()[7]; crank <= robot.upper()[7]; crank += 0.017) {
    EXPECT_NEAR(value(robot, "left_rocker", crank), rocker_angle(crank), 1e-5) << crank;
    EXPECT_LT(gap(robot, robot.forward(with_crank(robot, crank)), "right", 0.06, 0.01), 1e-5) << crank;
  }
  EXPECT_LT(gap(robot, robot.forward(robot.home()), "left", 0.06, 0.01), 1e-7);
}

TEST(Loops, HaveGradientsThatAgreeWithCentralDifferences) {
  const Robot robot = four_bar(kUnequal);
  const int body = robot.fingertips()[0].frame.body;
  const Eigen::Vector3d p_B(0.01, 0.02, 0.07);
  for (const double crank : {-0.2, 0.1, 0.4, 0.7}) {
    const auto at = [&](double c) { return robot.forward(with_crank(robot, c)).X_WB[static_cast<std::size_t>(body)]; };
    const Kinematics k = robot.forward(with_crank(robot, crank));
    const Eigen::Vector3d numeric = (at(crank + 1e-5) * p_B - at(crank - 1e-5) * p_B) / 2e-5;
    EXPECT_LT((robot.point_jacobian(k, body, at(crank) * p_B).col(7) - numeric).norm(), 1e-7);
    const Eigen::Vector3d turning = (at(crank + 1e-5).linear() - at(crank - 1e-5).linear()) * p_B / 2e-5;
    EXPECT_LT((robot.vector_jacobian(k, body, at(crank).linear() * p_B).col(7) - turning).norm(), 1e-7);
  }
}

TEST(Loops, NarrowTheLeadersRangeToWhereTheyClose) {
  // Rocker and coupler stretched, |PB| = r + c: the dead point.
  const double r = 0.06, c = std::hypot(0.03, 0.01);
  const double dead =
      std::asin((kCrank * kCrank + kRockerAway * kRockerAway - (r + c) * (r + c)) / (2 * kCrank * kRockerAway));
  ASSERT_GT(dead, -1.5);
  FourBar about = kUnequal;
  about.range = "-1.5 0.85";
  const Robot robot = four_bar(about);
  EXPECT_GT(robot.lower()[7], dead);
  EXPECT_LT(robot.lower()[7], dead + 0.02 * (0.7 - dead) + 1e-3) << "a fiftieth of the way from home";
  EXPECT_EQ(robot.upper()[7], 0.85);
}

TEST(Loops, CanBeClosedByWelds) {
  // Finger and crank as one; the rocker goes along.
  FourBar about{.connect =
                    R"(<weld body1="SIDE_crank" body2="SIDE_finger"/><joint joint1="SIDE_rocker" joint2="SIDE"/>)"};
  const Robot robot = four_bar(about);
  for (const double crank : {-0.3, 0.2, 0.8}) {
    EXPECT_NEAR(value(robot, "left_knuckle", crank), 0, 1e-9);
    EXPECT_NEAR(value(robot, "right_rocker", crank), crank, 1e-15);
  }
}

TEST(Loops, ThatNoListedJointLeadsStayWhereTheyComeToRest) {
  // The right finger's three joints hang together by themselves, and a spring holds them.
  FourBar about{.coupling = ""};
  const RobotFolder folder;
  write_four_bar(folder, about);
  folder.put("robot.xml", replaced(read_file(folder.path("robot.xml")).value(), "<joint name=\"right\" ",
                                   "<joint name=\"right\" stiffness=\"0.3\" springref=\"0.5\" "));
  const Robot robot = folder.load().value();
  for (const double crank : {-0.3, 0.4}) {
    EXPECT_NEAR(value(robot, "right", crank), 0.5, 1e-6);
    EXPECT_NEAR(value(robot, "right_knuckle", crank), -0.5, 1e-6);
    EXPECT_NEAR(value(robot, "left_knuckle", crank), -crank, 1e-8);
  }
}

TEST(Loops, ThatCannotBeReadAreRefusedInWords) {
  const auto expect = [](const FourBar& about, std::initializer_list<const char*> words) {
    const std::string error = refusal_of(about);
    for (const char* word : words) EXPECT_NE(error.find(word), std::string::npos) << word << ": " << error;
    EXPECT_NE(error.find("robot.xml"), std::string::npos) << error;
  };
  FourBar arm;
  arm.more_equalities = R"(<connect body1="forearm" body2="shoulder" anchor="0 0 0"/>)";
  expect(arm, {"'a3' of the arm", "'forearm' and 'shoulder'", "only the hand"});
  FourBar world;
  world.more_equalities = R"(<connect body1="left_finger" anchor="0 0 0"/>)";
  expect(world, {"'a1' of the arm", "'left_finger' and 'world'"});
  FourBar open;
  open.connect = R"(<weld body1="SIDE_crank" body2="SIDE_finger" relpose="0 0.01 0.07 1 0 0 0"/>
                    <joint joint1="SIDE_rocker" joint2="SIDE"/>)";
  expect(open, {"stays open by", "'left_crank' and 'left_finger'", "home"});
  FourBar stiff;
  stiff.connect += R"(<connect body1="SIDE_finger" body2="gripper" anchor="0 0 0"/>)";
  expect(stiff, {"stays open by", "home"});
  FourBar loose;
  loose.range = "-1.5 1.5";
  loose.connect = "";
  loose.coupling = R"(<connect body1="left_finger" body2="right_finger" anchor="0 0 0.05"/>
                      <joint joint1="left_rocker" joint2="left"/><joint joint1="right_rocker"/>)";
  expect(loose, {"leaves joint", "neither the loop nor a spring"});
}

TEST(Loops, ThatTwoListedJointsLeadAreRefused) {
  const RobotFolder folder;
  write_four_bar(folder, {.coupling = R"(<connect body1="left_finger" body2="right_rocker" anchor="0 0 0.05"/>)"});
  folder.put("robot.yaml", replaced(read_file(folder.path("robot.yaml")).value(),
                                    "grasp_frame:", "  - {joint: right, home: 0.7}\ngrasp_frame:"));
  EXPECT_NE(folder.error().find("both 'left' and 'right' lead"), std::string::npos) << folder.error();
}

TEST(Loops, ThatWouldPassALimitSayWhichJointIsBeyondIt) {
  const RobotFolder folder;
  write_four_bar(folder);
  folder.put("robot.xml",
             replaced(read_file(folder.path("robot.xml")).value(), "name=\"left_rocker\" range=\"-1.5 1.5\"",
                      "name=\"left_rocker\" range=\"-1.5 0.4\""));
  // At home, 0.7, neither the limit nor the loop can be met.
  EXPECT_NE(folder.error().find("home"), std::string::npos) << folder.error();
  folder.put("robot.yaml", replaced(read_file(folder.path("robot.yaml")).value(), "home: 0.7", "home: 0.3"));
  const Robot robot = folder.load().value();
  EXPECT_LE(robot.upper()[7], 0.4 + 1e-3);
  EXPECT_GE(robot.upper()[7], 0.4 - 0.02 * 0.1 - 1e-3);
}

}  // namespace
}  // namespace primo::robot
