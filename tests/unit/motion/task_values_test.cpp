// Task variables where their values are known.
#include <Eigen/Geometry>
#include <cmath>

#include "motion/motion_cost.h"
#include "motion/rotation_vector.h"
#include "task_fixture.h"

namespace primo::motion {
namespace {

Pose grasp_pose(const Eigen::VectorXd& q) { return schunk().pose(schunk().forward(q), schunk().grasp_frame()); }

TEST(RotationVector, IsAngleTimesAxisUpToAHalfTurn) {
  for (std::uint64_t i = 0; i < 200; ++i) {
    Random random(1, "rotation vector", {i});
    const Eigen::Vector3d axis = Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
    for (const double angle : {0.0, 1e-12, 1e-6, 1e-3, 0.5, 3.0, M_PI - 1e-7}) {
      const Eigen::Matrix3d R = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
      ASSERT_LT((rotation_vector(R) - angle * axis).norm(), 1e-8) << angle;
    }
    const Eigen::Vector3d half = rotation_vector(Eigen::AngleAxisd(M_PI, axis).toRotationMatrix());
    ASSERT_NEAR(half.norm(), M_PI, 1e-9);
    ASSERT_NEAR(std::abs(half.normalized().dot(axis)), 1, 1e-9);
  }
}

TEST(RotationVector, InverseRightJacobianInvertsTheSeriesOfTheRightJacobian) {
  // J_r = Σ_k (−[φ]×)^k / (k + 1)!.
  for (std::uint64_t i = 0; i < 100; ++i) {
    Random random(2, "rotation vector", {i});
    const Eigen::Vector3d axis = Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
    for (const double angle : {0.0, 1e-6, 9e-4, 1.1e-3, 0.1, 2.0, M_PI}) {
      const Eigen::Vector3d phi = angle * axis;
      Eigen::Matrix3d minus;
      minus << 0, phi.z(), -phi.y(), -phi.z(), 0, phi.x(), phi.y(), -phi.x(), 0;
      Eigen::Matrix3d power = Eigen::Matrix3d::Identity(), J_r = power;
      double factorial = 1;
      for (int k = 1; k < 40; ++k) {
        power = power * minus;
        factorial *= k + 1;
        J_r += power / factorial;
      }
      ASSERT_LT((inverse_right_jacobian(phi) * J_r - Eigen::Matrix3d::Identity()).norm(), 1e-9) << angle;
    }
  }
}

TEST(TaskValues, OrientationIsTheRotationVectorFromTheTarget) {
  PlanningScene at_hand = scene();
  const Eigen::VectorXd q = random_q(5);
  const Eigen::Vector3d turned(0.3, -1.1, 0.7);
  at_hand.target.X_WB = grasp_pose(q) * Eigen::AngleAxisd(turned.norm(), turned.normalized()).inverse();
  EXPECT_LT((value(*make("orientation", at_hand), q, 1) - turned).norm(), 1e-12);
  // The target's frame turned by yaw about its own z, and seen from there.
  at_hand.target.X_WB = grasp_pose(q);
  const auto yawed = make("orientation", at_hand, {{"yaw", 0.4}});
  EXPECT_LT((value(*yawed, q, 1) - Eigen::Vector3d(0, 0, -0.4)).norm(), 1e-12);
}

TEST(TaskValues, AHeldObjectMovesWithTheGraspFrame) {
  for (std::uint64_t i = 0; i < 5; ++i) {
    const Eigen::VectorXd q = random_q(i);
    const Eigen::Vector3d p_WO = (grasp_pose(q) * holding().X_GO).translation();
    const auto position = make("position", holding(), {}, {{"frame", "held"}, {"object", "world"}});
    EXPECT_LT((value(*position, q, 1) - p_WO).norm(), 1e-12);
    // Its own position relative to itself, by whatever name.
    const auto none = make("position", holding(), {}, {{"frame", "c1"}, {"object", "target"}});
    EXPECT_LT(value(*none, q, 1).norm(), 1e-12);
    const auto on_top = make("position", holding(), {{"clearance", 0.005}},
                             {{"frame", "held"}, {"object", "second"}, {"point", "on_top"}});
    const Eigen::Vector3d goal =
        holding().find("c2")->X_WB.translation() + Eigen::Vector3d(0, 0, 0.054 + 0.054 + 0.005);
    EXPECT_LT((value(*on_top, q, 1) - (p_WO - goal)).norm(), 1e-12);
  }
}

TEST(TaskValues, AxesOfAnUprightFrameArePerpendicularToTheWorldsZ) {
  PlanningScene held = holding();
  const Eigen::VectorXd q = random_q(7);
  const Pose upright = pose(Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(0, 0, 0.6));
  held.X_GO = grasp_pose(q).inverse() * upright;
  const Names of = {{"frame", "held"}, {"axis", "xyz"}, {"object", "world"}};
  EXPECT_LT((value(*make("alignment", held, {}, of), q, 1) - Eigen::Vector3d(0, 0, 1)).norm(), 1e-12);
  // Tilted by 0.2 about its own y, x sinks by sin 0.2.
  held.X_GO = held.X_GO * Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY());
  const Eigen::Vector3d tilted(-std::sin(0.2), 0, std::cos(0.2));
  EXPECT_LT((value(*make("alignment", held, {}, of), q, 1) - tilted).norm(), 1e-12);
}

TEST(TaskValues, FrameVelocityIsTheChordOverTheStep) {
  // One joint turns at 0.8 rad/s: a point at distance r from its axis moved the chord 2 r sin(ωτ/2).
  const Eigen::VectorXd q = random_q(9);
  const auto kinematics = schunk().forward(q);
  const double omega = 0.8;
  const Eigen::VectorXd v = omega * Eigen::VectorXd::Unit(schunk().joints(), 0);
  const Eigen::Vector3d from_axis = grasp_pose(q).translation() - kinematics.anchor_W[0];
  const double r = from_axis.cross(kinematics.axis_W[0]).norm();
  EXPECT_NEAR(value(*make("frame_velocity", scene()), q, v, 1).norm(), 2 * r * std::sin(omega * kStep / 2) / kStep,
              1e-12);
  EXPECT_EQ(value(*make("end_velocity", scene()), q, v, 1), v);
}

/// φ over an endless floor of voxels with centres at height z, summed over the spheres of all moving links: the field
/// over a floor is linear in the height.
double floor_proximity(const Eigen::VectorXd& q, double z, double voxel, double margin) {
  const auto kinematics = schunk().forward(q);
  double sum = 0;
  for (const auto& link : schunk().link_shapes()) {
    if (!link.moves) continue;
    for (const auto& sphere : link.cover) {
      const double height = (kinematics.X_WB[link.body] * sphere.centre).z() - z;
      sum += std::max(0.0, 1 - (height - voxel / 2 - sphere.radius) / margin);
    }
  }
  return sum;
}

TEST(TaskValues, PerceivedCollisionOverAFloorIsTheSummedProximityInHeight) {
  constexpr double kVoxel = 0.02;
  // A floor through the hand's height or below it, wide enough that its edge does not matter.
  for (const double below : {0.0, 0.05, 0.1, 0.2}) {
    const Eigen::VectorXd q = schunk().home();
    const double z = std::floor((grasp_pose(q).translation().z() - 0.15 - below) / kVoxel) * kVoxel + kVoxel / 2;
    std::vector<Eigen::Vector3d> floor;
    for (double x = -1; x < 2; x += kVoxel) {
      for (double y = -1.5; y < 1.5; y += kVoxel) floor.emplace_back(x, y, z);
    }
    PlanningScene flat = scene();
    // From below the floor the distance grows again; heights here are above it.
    flat.perceived = flat.perceived_without_contact =
        std::make_shared<scene::DistanceField>(scene::distance_field(floor, kVoxel, 0.3).value());
    const double expected = floor_proximity(q, z, kVoxel, 0.04);
    EXPECT_NEAR(value(*make("perceived_collision", flat, {{"margin", 0.04}}), q, 0.5)[0], expected,
                1e-5 * (1 + expected))
        << below;
  }
}

TEST(TaskValues, PerceivedCollisionLetsTheHandIntoTheTargetsVoxelsInTheEndOnly) {
  // The grasp frame at the target's centre: between its fingers there is nothing but the target.
  const Eigen::VectorXd q = random_q(8);
  PlanningScene at_hand = scene();
  at_hand.target.X_WB = grasp_pose(q);
  std::vector<Eigen::Vector3d> voxels;
  for (double x = -0.03; x < 0.03; x += 0.005) {
    for (double z = -0.05; z < 0.05; z += 0.005) voxels.push_back(at_hand.target.X_WB * Eigen::Vector3d(x, 0, z));
  }
  at_hand.perceived = std::make_shared<scene::DistanceField>(scene::distance_field(voxels, 0.01, 0.1).value());
  at_hand.perceived_without_contact =
      std::make_shared<scene::DistanceField>(scene::distance_field(std::vector<Eigen::Vector3d>{}, 0.01, 0.1).value());
  const auto variable = make("perceived_collision", at_hand, {{"target_until", 0.8}, {"margin", 0.1}});
  EXPECT_GT(value(*variable, q, 0.79)[0], 0);
  EXPECT_EQ(value(*variable, q, 0.8)[0], 0);
}

TEST(TaskValues, ThePerceivedMapLosesTheTargetsVoxelsAndNoOthers) {
  const auto& full = *scene().perceived;
  const auto& without = *scene().perceived_without_contact;
  const Eigen::Vector3d top1 = scene().find("c1")->X_WB * Eigen::Vector3d(0, 0, 0.05),
                        top2 = scene().find("c2")->X_WB * Eigen::Vector3d(0, 0, 0.05);
  EXPECT_LT(full.distance(top1), 0.02);
  EXPECT_LT(full.distance(top2), 0.02);
  EXPECT_GT(without.distance(top1), 0.05);
  EXPECT_LT(without.distance(top2), 0.02);
  // In the hand c1 is gone from the map altogether, and its support is what the motion has to come near.
  EXPECT_GT(holding().perceived->distance(top1), 0.05);
  EXPECT_LT(holding().perceived->distance(top2), 0.02);
  EXPECT_GT(holding().perceived_without_contact->distance(top2), 0.05);
}

TEST(TaskValues, APlanWithoutAnOctreeSaysThatItNeedsOne) {
  PlanRequest asked = request(1, hand_tuned());
  for (auto& task : asked.primitive.tasks) {
    if (task.variable == "collision") task.variable = "perceived_collision";
  }
  EXPECT_NE(plan(schunk(), asked).reason.find("its octree is empty"), std::string::npos);
  asked.scene = estimate();
  const Plan answer = plan(schunk(), asked);
  EXPECT_NE(answer.status, PlanStatus::bad_input) << answer.reason;
  EXPECT_TRUE(answer.trajectory.q.allFinite());
  asked.scene.octree.resize(20);
  EXPECT_EQ(plan(schunk(), asked).status, PlanStatus::bad_input);
}

/// The cost of one task over standing still at q for 16 steps of 0.25 s.
double standing_cost(const Task& task, const Eigen::VectorXd& q) {
  Primitive primitive;
  primitive.name = "p";
  primitive.steps = 16;
  primitive.tasks = {task};
  const auto cost = MotionCost::create(schunk(), scene(), primitive, q).value();
  return cost->task_costs(q.replicate(1, 16))[0].cost;
}

TEST(Profiles, EndsRampTheTargetUpFirstAndItsNegativeDownLast) {
  Task task;
  task.variable = "end_velocity";
  task.profile = Profile::ends;
  task.at = 0.125;  // 2 of 16 steps
  task.rho = 3;
  task.target = {1};
  // Targets ½, 1 at steps 1, 2 and −1, −½, 0 at 14, 15, 16, for 14 joints at rest.
  EXPECT_NEAR(standing_cost(task, random_q(1)), 3 * 14 * (0.25 + 1 + 1 + 0.25), 1e-9);
}

TEST(Profiles, EarlyCountsUntilItsFractionOnly) {
  Task task;
  task.variable = "homing";
  task.profile = Profile::early;
  task.at = 0.25;
  task.rho = 3;
  const Eigen::VectorXd q = random_q(2);
  EXPECT_NEAR(standing_cost(task, q), 3 * 4 * q.squaredNorm(), 1e-9);
}

TEST(TaskValues, HomingOfHandOrArmIsOfTheirAnglesAlone) {
  Task task;
  task.variable = "homing";
  task.profile = Profile::final;
  task.rho = 2;
  const Eigen::VectorXd q = random_q(4);
  task.of = {{"joints", "arm"}};
  EXPECT_NEAR(standing_cost(task, q), 2 * q.head(7).squaredNorm(), 1e-9);
  task.of = {{"joints", "hand"}};
  task.target = {0, -0.4, 0.4, -0.3, 0.3, -0.2, 0.2};
  const Eigen::VectorXd off = q.tail(7) - Eigen::Map<const Eigen::VectorXd>(task.target.data(), 7);
  EXPECT_NEAR(standing_cost(task, q), 2 * off.squaredNorm(), 1e-9);
}

TEST(TaskValues, HomingOfTheHandIsDifferentiatedByItsJointsOnly) {
  PlanningScene empty = scene();
  const TaskVariableEntry* entry = find_task_variable("homing").value();
  const auto variable = entry->create({schunk(), empty, {}, {{"joints", "hand"}}}).value();
  ASSERT_EQ(variable->size(), 7);
  EXPECT_FALSE(variable->is_identity()) << "or the solver would take q itself for φ";
  const Eigen::VectorXd q = random_q(5), still = Eigen::VectorXd::Zero(14);
  const auto kinematics = schunk().forward(q);
  Eigen::VectorXd phi(7);
  Jacobian J = Jacobian::Constant(7, 14, 9);
  variable->evaluate({q, kinematics, 1, still, 0.1}, phi, &J);
  EXPECT_EQ(phi, q.tail(7));
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(7, 14);
  for (int i = 0; i < 7; ++i) expected(i, 7 + i) = 1;
  EXPECT_EQ(Eigen::MatrixXd(J), expected);
}

TEST(Profiles, ATargetFromTheStartComesLinearly) {
  // Homing to 0 from q: y*_t = (1 − t/T) q, so that standing still is off by t/T q.
  Task task;
  task.variable = "homing";
  task.rho = 3;
  task.from_start = true;
  const Eigen::VectorXd q = random_q(3);
  double sum = 0;
  for (int t = 1; t <= 16; ++t) sum += std::pow(t / 16.0, 2);
  EXPECT_NEAR(standing_cost(task, q), 3 * sum * q.squaredNorm(), 1e-9);
}

}  // namespace
}  // namespace primo::motion
