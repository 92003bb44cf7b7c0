#include "motion/task_variables.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "motion/task_frames.h"
#include "robot/distance.h"
#include "task_fixture.h"

namespace primo::motion {
namespace {

/// A task variable as a primitive may ask for it.
struct Case {
  std::string label;
  std::unique_ptr<TaskVariable> variable;
};

/// Every entry of the table with its defaults, with a free and with a holding hand; and what else names can say.
std::vector<Case> cases() {
  std::vector<Case> all;
  for (const auto& entry : task_variables()) {
    all.push_back({entry.name, make(entry.name, scene())});
    all.push_back({entry.name + ", holding", make(entry.name, holding())});
  }
  const auto add = [&](const std::string& variable, const Names& of, const Numbers& parameters = {}) {
    std::string label = variable;
    for (const auto& [key, text] : of) label += " " + key + "=" + text;
    all.push_back({label, make(variable, holding(), parameters, of)});
  };
  add("position", {{"frame", "held"}, {"object", "second"}, {"point", "on_top"}});
  add("position", {{"frame", "thumb"}, {"object", "held"}});
  add("position", {{"frame", "tool"}, {"object", "world"}});
  add("orientation", {{"frame", "held"}, {"object", "second"}}, {{"roll", 3.0}, {"yaw", -2.0}});
  add("orientation", {{"frame", "finger_2"}, {"object", "held"}});
  add("alignment", {{"frame", "held"}, {"axis", "xy"}, {"object", "world"}});
  add("alignment", {{"frame", "finger_3"}, {"axis", "xyz"}, {"object", "held"}, {"object_axis", "y"}});
  add("frame_velocity", {{"frame", "held"}});
  add("frame_velocity", {{"frame", "finger_3_distal"}});
  add("finger_distance", {{"object", "second"}});
  return all;
}

/// Configurations with the hand about an object, where proximities count.
Eigen::VectorXd near_target(std::uint64_t i) {
  Random random(3, "near_target", {i});
  Eigen::VectorXd q = random_q(i);
  const auto& frame = schunk().grasp_frame();
  const Eigen::Vector3d goal =
      scene().find(i % 4 == 1 ? "c1" : "c2")->X_WB.translation() +
      Eigen::Vector3d(random.uniform(-.1, .1), random.uniform(-.1, .1), random.uniform(-.1, .1));
  for (int k = 0; k < 100; ++k) {
    const auto kinematics = schunk().forward(q);
    const Eigen::Vector3d p = schunk().pose(kinematics, frame).translation();
    const Eigen::Matrix3Xd J = schunk().point_jacobian(kinematics, frame.body, p);
    const Eigen::Matrix3d JJt = J * J.transpose() + 1e-4 * Eigen::Matrix3d::Identity();
    q += 0.3 * J.transpose() * JJt.inverse() * (goal - p);
  }
  return q;
}

/// Whether what the hand holds is inside an obstacle: overlapping cylinders and boxes have the direction of least
/// overlap for a gradient, which itself turns with them (robot/distance.h).
bool held_overlaps(const Eigen::VectorXd& q) {
  const auto held = find_object(schunk(), holding(), "held").value();
  const Pose X_WH = schunk().pose(schunk().forward(q), held.frame);
  return std::any_of(holding().obstacles.begin(), holding().obstacles.end(), [&](const SceneBody& body) {
    return robot::distance(held.body->shape, X_WH, body.shape, body.X_WB).distance < 0;
  });
}

TEST(TaskVariables, JacobiansAgreeWithCentralDifferences) {
  const int n = schunk().joints();
  for (const auto& [label, variable] : cases()) {
    ASSERT_GT(variable->size(), 0) << label;
    Compared counts;
    int configurations = 0;
    for (std::uint64_t i = 0; i < 200; ++i) {
      const Eigen::VectorXd q = i % 2 ? near_target(i) : random_q(i);
      if (label == "collision, holding" && held_overlaps(q)) continue;
      ++configurations;
      Random random(4, "motion_test v", {i});
      Eigen::VectorXd v(n);
      for (int j = 0; j < n; ++j) v[j] = random.uniform(-2, 2);
      const double phase = i % 8 < 4 ? 0.3 : 1.0;
      const auto kinematics = schunk().forward(q);
      Eigen::VectorXd phi(variable->size());
      Jacobian J = Jacobian::Constant(variable->size(), n, 1e9), J_v = J;
      variable->evaluate({q, kinematics, phase, v, kStep}, phi, &J);
      ASSERT_EQ(phi, value(*variable, q, v, phase)) << label;
      compare(
          label, q, J, [&](const Eigen::VectorXd& at) { return value(*variable, at, v, phase); }, counts);
      if (variable->moving()) {
        variable->velocity_jacobian({q, kinematics, phase, v, kStep}, J_v);
        compare(
            label, v, J_v, [&](const Eigen::VectorXd& at) { return value(*variable, q, at, phase); }, counts);
      } else {
        ASSERT_EQ(phi, value(*variable, q, 2 * v, phase)) << label;
      }
    }
    EXPECT_GT(configurations, 100) << label;
    EXPECT_LT(counts.kinks, counts.columns / 50) << label;
    // A held target does not turn in the hand.
    const bool still = label == "orientation, holding" || label == "alignment, holding";
    if (still) {
      EXPECT_EQ(counts.nonzero, 0) << label;
    } else {
      EXPECT_GT(counts.nonzero, counts.columns / 100) << label;
    }
  }
}

TEST(TaskVariables, AreFiniteAtExtremeAngles) {
  const int n = schunk().joints();
  for (const auto& [label, variable] : cases()) {
    for (const double angle : {0.0, M_PI, 1e3, -1e6}) {
      for (const double speed : {0.0, 1e-9, -1e4}) {
        const Eigen::VectorXd q = Eigen::VectorXd::Constant(n, angle), v = Eigen::VectorXd::Constant(n, speed);
        Eigen::VectorXd phi(variable->size());
        Jacobian J(variable->size(), n), J_v = Jacobian::Zero(variable->size(), n);
        variable->evaluate({q, schunk().forward(q), 0.5, v, kStep}, phi, &J);
        if (variable->moving()) variable->velocity_jacobian({q, schunk().forward(q), 0.5, v, kStep}, J_v);
        EXPECT_TRUE(phi.allFinite() && J.allFinite() && J_v.allFinite()) << label << " at " << angle;
      }
    }
  }
}

TEST(TaskVariables, PositionVanishesWithTheGraspFrameAtTheTarget) {
  PlanningScene at_hand = scene();
  const Eigen::VectorXd q = random_q(5);
  const Pose X_WG = schunk().pose(schunk().forward(q), schunk().grasp_frame());
  at_hand.target.X_WB = pose(X_WG.translation() - Eigen::Vector3d(0.1, 0.2, -0.3));
  const auto variable = make("position", at_hand);
  EXPECT_LT((value(*variable, q, 1) - Eigen::Vector3d(0.1, 0.2, -0.3)).norm(), 1e-12);
}

TEST(TaskVariables, AlignmentIsTheCosineBetweenOppositionAndAxis) {
  PlanningScene at_hand = scene();
  const Eigen::VectorXd q = random_q(6);
  const Pose X_WG = schunk().pose(schunk().forward(q), schunk().grasp_frame());
  for (const double angle : {0.0, 0.4, M_PI / 2}) {
    // The target's axis is the opposition axis turned by `angle` about the approach.
    at_hand.target.X_WB = X_WG * Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()) *
                          Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitY());
    const auto variable = make("alignment", at_hand);
    EXPECT_NEAR(value(*variable, q, 1)[0], std::cos(angle), 1e-12);
  }
}

TEST(TaskVariables, FingerDistanceIsOneAtTouchAndZeroBeyondTheMargin) {
  PlanningScene ball = scene();
  const Eigen::VectorXd q = Eigen::VectorXd::Zero(schunk().joints());
  const auto& link = schunk().link_shapes()[schunk().fingertips()[0].link_shape];
  const Pose X_WG = schunk().pose(schunk().forward(q), link);
  ball.target.shape = {ShapeType::sphere, {0.03, 0, 0}};
  ball.target.bounding_radius = 0.03;
  for (const double gap : {0.0, 0.02, 0.05, 0.2, -0.01}) {
    // Beside the thumb's distal phalanx, away from the fingers.
    ball.target.X_WB = pose(X_WG * Eigen::Vector3d(-(link.shape.size[0] + 0.03 + gap), 0, 0));
    const auto variable = make("finger_distance", ball, {{"margin", 0.05}});
    EXPECT_NEAR(value(*variable, q, 1)[0], std::max(0.0, 1 - gap / 0.05), 1e-9) << gap;
  }
}

TEST(TaskVariables, OppositionIsMinusOneForParallelFingers) {
  const auto variable = make("opposition", scene(), {{"others_from", 1.0}});
  Eigen::VectorXd q = random_q(7);
  q.tail(7).setZero();
  EXPECT_LT((value(*variable, q, 1) - Eigen::Vector2d(-1, -1)).norm(), 1e-12);
  EXPECT_TRUE(variable->counts(0, 0.8));
  EXPECT_FALSE(variable->counts(1, 0.8));
  EXPECT_TRUE(variable->counts(1, 1.0));
}

TEST(TaskVariables, CollisionLetsTheHandNearTheTargetInTheEndOnly) {
  PlanningScene free = scene();
  free.obstacles.clear();
  const auto variable = make("collision", free, {{"margin", 0.04}, {"target_until", 0.8}});
  const Eigen::VectorXd q = random_q(8);
  free.target.X_WB = pose(schunk().pose(schunk().forward(q), schunk().grasp_frame()).translation());
  EXPECT_GT(value(*variable, q, 0.79)[0], 0);
  EXPECT_EQ(value(*variable, q, 0.8)[0], 0);
  // The arm has to keep off it even then.
  free.target.X_WB = pose(schunk().forward(q).X_WB[schunk().body("link_4")].translation());
  EXPECT_GT(value(*variable, q, 1)[0], 1);
}

TEST(TaskVariables, LimitsSumAnglesInsideTheMargin) {
  const auto variable = make("limits", scene(), {{"margin", 0.1}});
  Eigen::VectorXd q = 0.5 * (schunk().lower() + schunk().upper());
  EXPECT_EQ(value(*variable, q, 1)[0], 0);
  q[0] = schunk().lower()[0] + 0.07;
  q[9] = schunk().upper()[9] + 0.2;
  EXPECT_NEAR(value(*variable, q, 1)[0], 0.03 + 0.3, 1e-12);
}

TEST(TaskVariables, WrongParametersAreRefusedWithWhatThereIs) {
  const auto* entry = find_task_variable("collision").value();
  const auto unknown = complete_parameters(*entry, {{"margn", 0.04}});
  ASSERT_FALSE(unknown.ok());
  EXPECT_NE(unknown.error().message.find("margin, target_until"), std::string::npos) << unknown.error().message;
  EXPECT_FALSE(complete_parameters(*entry, {{"margin", -1}}).ok());
  EXPECT_FALSE(complete_parameters(*entry, {{"margin", NAN}}).ok());
  EXPECT_FALSE(find_task_variable("colision").ok());
}

}  // namespace
}  // namespace primo::motion
