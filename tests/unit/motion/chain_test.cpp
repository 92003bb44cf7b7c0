// Robots of other sizes: chains with a coupled joint, written for the test.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/random.h"
#include "motion/planner.h"

namespace primo::motion {
namespace {

/// A chain of n − 1 hinges about y and z in turns, 1.2 m long in all, and a gripper of two fingers that one joint
/// closes: the second finger is coupled to the first.
robot::Robot chain(int n) {
  const auto folder = std::filesystem::path(testing::TempDir()) / ("primo_chain_" + std::to_string(n));
  std::filesystem::create_directories(folder);
  const double length = 1.2 / (n - 1);
  std::string bodies, closing, arm;
  for (int i = 0; i < n - 1; ++i) {
    const std::string name = "j" + std::to_string(i);
    bodies += "<body name=\"b" + std::to_string(i) + "\" pos=\"0 0 " + std::to_string(i ? length : 0.0) +
              "\"><joint name=\"" + name + "\" axis=\"" + (i % 2 ? "0 0 1" : "0 1 0") +
              "\" range=\"-1.5 1.5\"/><geom type=\"capsule\" fromto=\"0 0 0 0 0 " + std::to_string(length) +
              "\" size=\"0.015\"/>\n";
    closing += "</body>";
    arm += "  - {joint: " + name + ", control_weight: 0.2, home: " + (i % 2 ? "0.1" : "0.2") + "}\n";
  }
  std::ofstream(folder / "chain.xml") << "<mujoco><compiler angle=\"radian\" autolimits=\"true\"/><worldbody>" << bodies
                                      << "<body name=\"left\" pos=\"-0.03 0 " << length
                                      << "\"><joint name=\"close\" axis=\"0 1 0\" range=\"-1 1\"/>"
                                      << "<geom type=\"capsule\" fromto=\"0 0 0 0 0 0.05\" size=\"0.01\"/></body>"
                                      << "<body name=\"right\" pos=\"0.03 0 " << length
                                      << "\"><joint name=\"follow\" axis=\"0 1 0\" range=\"-1 1\"/>"
                                      << "<geom type=\"capsule\" fromto=\"0 0 0 0 0 0.05\" size=\"0.01\"/></body>"
                                      << closing
                                      << "</worldbody><equality><joint joint1=\"follow\" joint2=\"close\" polycoef=\"0 "
                                         "-1 0 0 0\"/></equality></mujoco>";
  std::ofstream(folder / "chain.yaml") << "name: chain\nmjcf: chain.xml\narm:\n"
                                       << arm << "hand:\n  - {joint: close}\ngrasp_frame: {body: b" << n - 2
                                       << ", position: [0, 0, " << length + 0.04 << "]}\nfingertips:\n"
                                       << "  - {name: left, thumb: true, frame: {body: left, position: [0, 0, 0.03]}}\n"
                                       << "  - {name: right, frame: {body: right, position: [0, 0, 0.03]}}\n";
  auto robot = robot::Robot::load(folder / "chain.yaml");
  EXPECT_TRUE(robot.ok()) << robot.error().message;
  return std::move(robot).value();
}

Primitive reach() {
  Primitive primitive;
  primitive.name = "reach";
  primitive.action = "reach";
  primitive.steps = 32;
  primitive.tolerance = 1e-4;
  const auto add = [&](const std::string& variable, Profile profile, double rho) {
    Task& task = primitive.tasks.emplace_back();
    task.name = task.variable = variable;
    task.profile = profile;
    task.rho = rho;
  };
  add("position", Profile::final, 1e5);
  add("end_velocity", Profile::final, 1e2);
  add("collision", Profile::constant, 0.1);
  add("limits", Profile::constant, 10);
  add("homing", Profile::constant, 1e-5);
  return primitive;
}

class Chain : public testing::TestWithParam<int> {};

TEST_P(Chain, OfAnyLengthReachesWhereItCanAndComesToRest) {
  const int n = GetParam();
  const robot::Robot robot = chain(n);
  ASSERT_EQ(robot.joints(), n);
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    Random random(seed, "chain test");
    // Where the robot's own kinematics gets at moderate angles: in reach.
    Eigen::VectorXd q = robot.home();
    for (int i = 0; i < n - 1; ++i) q[i] += random.uniform(-4.0, 4.0) / n;
    const Eigen::Vector3d goal = robot.pose(robot.forward(q), robot.grasp_frame()).translation();
    PlanRequest asked;
    asked.scene.table.top_centre.z() = -2;
    auto& ball = asked.scene.objects.emplace_back();
    ball.name = "ball";
    ball.shape = {ShapeType::sphere, {0.02, 0, 0}};
    ball.X_WO = pose(goal);
    asked.action = {"reach", "ball"};
    asked.q_start.assign(robot.home().data(), robot.home().data() + n);
    asked.primitive = reach();
    asked.want_gains = true;
    const Plan answer = plan(robot, asked);
    ASSERT_EQ(answer.trajectory.q.cols(), n) << answer.reason;
    ASSERT_TRUE(answer.trajectory.q.allFinite());
    ASSERT_EQ(answer.gains.K[0].cols(), 2 * n);
    const Eigen::VectorXd last = answer.trajectory.q.row(32).transpose();
    EXPECT_LT((robot.pose(robot.forward(last), robot.grasp_frame()).translation() - goal).norm(), 0.005)
        << answer.reason;
    EXPECT_LT((answer.trajectory.q.row(32) - answer.trajectory.q.row(31)).norm() / answer.trajectory.dt, 0.02);
  }
}

INSTANTIATE_TEST_SUITE_P(Joints, Chain, testing::Values(7, 12, 21, 30));

TEST(ChainKinematics, CoupledFingersMoveOppositely) {
  const robot::Robot robot = chain(9);
  Eigen::VectorXd q = Eigen::VectorXd::Zero(9);
  q[8] = 0.3;
  const auto kinematics = robot.forward(q);
  // Mirror images about the chain's axis: x of one is −x of the other.
  const Eigen::Vector3d left = robot.pose(kinematics, robot.fingertips()[0].frame).translation(),
                        right = robot.pose(kinematics, robot.fingertips()[1].frame).translation();
  EXPECT_NEAR(left.x(), -right.x(), 1e-12);
  EXPECT_NEAR(left.z(), right.z(), 1e-12);
  EXPECT_NEAR(left.x(), -0.03 + 0.03 * std::sin(0.3), 1e-12);
}

}  // namespace
}  // namespace primo::motion
