// Every task variable with robots unlike the published one: parallel grippers, two to five fingers, thirty joints,
// coupled and sliding joints.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <map>
#include <numeric>

#include "../robot/robot_text.h"
#include "motion/planner.h"
#include "robot/distance.h"
#include "task_fixture.h"

namespace primo::motion {
namespace {

const robot::Robot& robot_named(const std::string& name) {
  static std::map<std::string, robot::Robot> robots;
  if (const auto found = robots.find(name); found != robots.end()) return found->second;
  const auto load = [&]() -> robot::Robot {
    if (name == "thirty_joints") return robot::generated_robot({.arm = 29, .fingers = 2, .coupled = true});
    if (name == "two_sliding_fingers") return robot::generated_robot({.fingers = 2, .slides = true});
    if (name == "five_fingers") return robot::generated_robot({.fingers = 5, .thumb = true});
    if (name == "four_coupled_on_a_rail")
      return robot::generated_robot({.arm = 6, .fingers = 4, .slides = true, .coupled = true, .rail = true});
    return robot::Robot::load(std::filesystem::path(PRIMO_SOURCE_DIR) / "configs/robots" / (name + ".yaml")).value();
  };
  return robots.emplace(name, load()).first->second;
}

class TaskVariablesOf : public testing::TestWithParam<const char*> {
 protected:
  const robot::Robot& robot() const { return robot_named(GetParam()); }

  /// Within limits; every other one with the grasp frame about the target, where proximities count.
  Eigen::VectorXd configuration(std::uint64_t i) const {
    Random random(5, "task_robots", {i});
    Eigen::VectorXd q(robot().joints());
    for (int j = 0; j < q.size(); ++j) q[j] = random.uniform(robot().lower()[j], robot().upper()[j]);
    if (i % 2 == 0) return q;
    // From about home: a long chain that begins curled up does not get there.
    q = robot().home() + 0.2 * (q - robot().home());
    const auto& frame = robot().grasp_frame();
    const Eigen::Vector3d goal =
        scene().target.X_WB.translation() +
        Eigen::Vector3d(random.uniform(-.06, .06), random.uniform(-.06, .06), random.uniform(0, .1));
    for (int k = 0; k < 100; ++k) {
      const auto at = robot().forward(q);
      const Eigen::Vector3d p = robot().pose(at, frame).translation();
      const Eigen::Matrix3Xd J = robot().point_jacobian(at, frame.body, p);
      q += 0.3 * J.transpose() * (J * J.transpose() + 1e-4 * Eigen::Matrix3d::Identity()).inverse() * (goal - p);
    }
    return q;
  }

  /// Whether a box or cylinder of the robot is inside something: then the gradient is the direction of least overlap,
  /// which itself turns with the shapes (robot/distance.h).
  bool overlaps(const Eigen::VectorXd& q) const {
    const auto at = robot().forward(q);
    std::vector<SceneBody> bodies = scene().obstacles;
    bodies.push_back(scene().target);
    for (const auto& link : robot().link_shapes()) {
      if (!link.moves || link.shape.type == ShapeType::capsule || link.shape.type == ShapeType::sphere) continue;
      for (const auto& body : bodies) {
        if (robot::distance(link.shape, robot().pose(at, link), body.shape, body.X_WB).distance < 1e-5) return true;
      }
    }
    return false;
  }

  Eigen::VectorXd value(const TaskVariable& variable, const Eigen::VectorXd& q, const Eigen::VectorXd& v,
                        double phase) const {
    const auto kinematics = robot().forward(q);
    Eigen::VectorXd phi(variable.size());
    variable.evaluate({q, kinematics, phase, v, kStep}, phi, nullptr);
    return phi;
  }
};

/// Boxes against cylinders and boxes are apart to 1e-9 m (GJK), which a step of 1e-6 turns into 1e-3 of a slope.
constexpr double kRoundedByGjk = 2e-3;

TEST_P(TaskVariablesOf, HaveJacobiansThatAgreeWithCentralDifferences) {
  const int n = robot().joints();
  for (const auto& entry : task_variables()) {
    Task task;
    task.variable = entry.name;
    auto made = make_task_variable(task, robot(), scene());
    ASSERT_TRUE(made.ok()) << entry.name << ": " << made.error().message;
    const TaskVariable& variable = **made;
    ASSERT_GT(variable.size(), 0) << entry.name;
    Compared counts;
    int compared = 0;
    for (std::uint64_t i = 0; i < 40; ++i) {
      const Eigen::VectorXd q = configuration(i);
      const bool of_shapes = entry.name == "collision" || entry.name == "finger_distance";
      if (of_shapes && overlaps(q)) continue;
      ++compared;
      Random random(6, "task_robots v", {i});
      Eigen::VectorXd v(n);
      for (int j = 0; j < n; ++j) v[j] = random.uniform(-2, 2);
      const double phase = i % 8 < 4 ? 0.3 : 1.0;
      const auto kinematics = robot().forward(q);
      Eigen::VectorXd phi(variable.size());
      Jacobian J = Jacobian::Constant(variable.size(), n, 1e9), J_v = J;
      variable.evaluate({q, kinematics, phase, v, kStep}, phi, &J);
      compare(
          entry.name, q, J, [&](const Eigen::VectorXd& at) { return value(variable, at, v, phase); }, counts,
          of_shapes ? kRoundedByGjk : 2e-4);
      if (!variable.moving()) continue;
      variable.velocity_jacobian({q, kinematics, phase, v, kStep}, J_v);
      compare(
          entry.name, v, J_v, [&](const Eigen::VectorXd& at) { return value(variable, q, at, phase); }, counts);
    }
    EXPECT_LT(counts.kinks, counts.columns / 20) << entry.name;
    EXPECT_GE(compared, 10) << entry.name;
    // Sliding fingers do not turn against each other.
    const bool turning = entry.name != "opposition" || !robot().slides(n - 1);
    EXPECT_EQ(counts.nonzero > counts.columns / 100, turning) << entry.name;
  }
}

TEST_P(TaskVariablesOf, HaveARowForEveryFingerBesidesTheFirstOrTheThumb) {
  Task task;
  task.variable = "opposition";
  const auto variable = make_task_variable(task, robot(), scene()).value();
  const auto& tips = robot().fingertips();
  ASSERT_EQ(variable->size(), static_cast<int>(tips.size()) - 1);
  const Eigen::VectorXd q = configuration(2);
  const auto kinematics = robot().forward(q);
  std::size_t first = 0;
  for (std::size_t t = 0; t < tips.size(); ++t) {
    if (tips[t].thumb) first = t;
  }
  const Eigen::VectorXd phi = value(*variable, q, Eigen::VectorXd::Zero(q.size()), 1.0);
  for (std::size_t t = 0, row = 0; t < tips.size(); ++t) {
    if (t == first) continue;
    const Eigen::Vector3d a = robot().pose(kinematics, tips[first].frame).linear().col(2),
                          b = robot().pose(kinematics, tips[t].frame).linear().col(2);
    EXPECT_NEAR(phi[static_cast<Eigen::Index>(row++)], a.dot(b), 1e-12);
  }
}

INSTANTIATE_TEST_SUITE_P(Robots, TaskVariablesOf,
                         testing::Values("schunk_lwa3_sdh2", "column7_pg130", "thirty_joints", "two_sliding_fingers",
                                         "five_fingers", "four_coupled_on_a_rail"));

TEST(TaskVariablesOfTheGripper, OppositionIsMinusOneWhateverTheOpening) {
  const auto& robot = robot_named("column7_pg130");
  Task task;
  task.variable = "opposition";
  const auto variable = make_task_variable(task, robot, scene()).value();
  for (const double opening : {0.0, 0.03, 0.065}) {
    Eigen::VectorXd q = robot.home(), phi(1);
    q[7] = opening;
    variable->evaluate({q, robot.forward(q), 1.0, q, kStep}, phi, nullptr);
    EXPECT_NEAR(phi[0], -1, 1e-12);
  }
}

TEST(TaskVariablesOfTheGripper, LimitsCountASlidesRangeAsHalfATurn) {
  const auto& robot = robot_named("column7_pg130");
  Task task;
  task.variable = "limits";
  task.parameters = {{"margin", 0.1}};
  const auto variable = make_task_variable(task, robot, scene()).value();
  Eigen::VectorXd q = 0.5 * (robot.lower() + robot.upper()), phi(1);
  // The margin is 0.1 / π of the range; half of it is left.
  q[7] = 0.065 * 0.05 / M_PI;
  variable->evaluate({q, robot.forward(q), 1.0, q, kStep}, phi, nullptr);
  EXPECT_NEAR(phi[0], 0.05, 1e-12);
}

}  // namespace
}  // namespace primo::motion
