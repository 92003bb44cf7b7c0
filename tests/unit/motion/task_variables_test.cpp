#include "motion/task_variables.h"

#include <Eigen/LU>
#include <cmath>

#include "fixture.h"

namespace primo::motion {
namespace {

const PlanningScene& scene() {
  static const PlanningScene scene = PlanningScene::create(request(1, hand_tuned()).scene, {"grasp", "c1"}).value();
  return scene;
}

const Eigen::VectorXd kStill = Eigen::VectorXd::Zero(14);
constexpr double kStep = 4.0 / 64;  // s

Eigen::VectorXd value(const TaskVariable& variable, const Eigen::VectorXd& q, double phase) {
  const auto kinematics = schunk().forward(q);
  Eigen::VectorXd phi(variable.size());
  variable.evaluate({q, kinematics, phase, kStill, kStep}, phi, nullptr);
  return phi;
}

/// Configurations with the hand about the target, where proximities count.
Eigen::VectorXd near_target(std::uint64_t i) {
  Random random(3, "near_target", {i});
  Eigen::VectorXd q = random_q(i);
  const auto& frame = schunk().grasp_frame();
  const Eigen::Vector3d goal =
      scene().target.X_WB.translation() +
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

TEST(TaskVariables, JacobiansAgreeWithCentralDifferences) {
  constexpr double kDifference = 1e-6;
  const int n = schunk().joints();
  for (const auto& entry : task_variables()) {
    const auto variable = entry.create({schunk(), scene(), complete_parameters(entry, {}).value()});
    ASSERT_GT(variable->size(), 0) << entry.name;
    int compared = 0, kinks = 0, nonzero = 0;
    for (std::uint64_t i = 0; i < 300; ++i) {
      const Eigen::VectorXd q = i % 2 ? near_target(i) : random_q(i);
      const double phase = i % 4 < 2 ? 0.3 : 1.0;
      const auto kinematics = schunk().forward(q);
      Eigen::VectorXd phi(variable->size());
      Jacobian J = Jacobian::Constant(variable->size(), n, 1e9);
      variable->evaluate({q, kinematics, phase, kStill, kStep}, phi, &J);
      ASSERT_EQ(phi, value(*variable, q, phase)) << entry.name;
      for (int j = 0; j < n; ++j) {
        const Eigen::VectorXd step = kDifference * Eigen::VectorXd::Unit(n, j);
        const Eigen::VectorXd ahead = value(*variable, q + step, phase), behind = value(*variable, q - step, phase);
        // Hinges have kinks where one-sided slopes differ; the Jacobian is that of one side there.
        if ((ahead - 2 * phi + behind).cwiseAbs().maxCoeff() > 1e-8) {
          ++kinks;
          continue;
        }
        ++compared;
        nonzero += J.col(j).norm() > 1e-6;
        ASSERT_LT((J.col(j) - (ahead - behind) / (2 * kDifference)).norm(), 2e-4 * (1 + J.col(j).norm()))
            << entry.name << " configuration " << i << " joint " << j;
      }
    }
    EXPECT_LT(kinks, compared / 50) << entry.name;
    EXPECT_GT(nonzero, compared / 100) << entry.name;
  }
}

TEST(TaskVariables, AreFiniteAtExtremeAngles) {
  for (const auto& entry : task_variables()) {
    const auto variable = entry.create({schunk(), scene(), complete_parameters(entry, {}).value()});
    for (const double angle : {0.0, 1e3, -1e6}) {
      EXPECT_TRUE(value(*variable, Eigen::VectorXd::Constant(schunk().joints(), angle), 0.5).allFinite()) << entry.name;
    }
  }
}

TEST(TaskVariables, PositionVanishesWithTheGraspFrameAtTheTarget) {
  PlanningScene at_hand = scene();
  const Eigen::VectorXd q = random_q(5);
  const Pose X_WG = schunk().pose(schunk().forward(q), schunk().grasp_frame());
  at_hand.target.X_WB = pose(X_WG.translation() - Eigen::Vector3d(0.1, 0.2, -0.3));
  const auto variable = find_task_variable("position").value()->create({schunk(), at_hand, {}});
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
    const auto variable = find_task_variable("alignment").value()->create({schunk(), at_hand, {}});
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
    const auto variable = find_task_variable("finger_distance").value()->create({schunk(), ball, {{"margin", 0.05}}});
    EXPECT_NEAR(value(*variable, q, 1)[0], std::max(0.0, 1 - gap / 0.05), 1e-9) << gap;
  }
}

TEST(TaskVariables, OppositionIsMinusOneForParallelFingers) {
  const auto variable = find_task_variable("opposition").value()->create({schunk(), scene(), {{"others_from", 1.0}}});
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
  const auto variable =
      find_task_variable("collision").value()->create({schunk(), free, {{"margin", 0.04}, {"target_until", 0.8}}});
  const Eigen::VectorXd q = random_q(8);
  free.target.X_WB = pose(schunk().pose(schunk().forward(q), schunk().grasp_frame()).translation());
  EXPECT_GT(value(*variable, q, 0.79)[0], 0);
  EXPECT_EQ(value(*variable, q, 0.8)[0], 0);
  // The arm has to keep off it even then.
  free.target.X_WB = pose(schunk().forward(q).X_WB[schunk().body("link_4")].translation());
  EXPECT_GT(value(*variable, q, 1)[0], 1);
}

TEST(TaskVariables, LimitsSumAnglesInsideTheMargin) {
  const auto variable = find_task_variable("limits").value()->create({schunk(), scene(), {{"margin", 0.1}}});
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
