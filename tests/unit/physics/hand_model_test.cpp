#include "physics/hand_model.h"

#include <gtest/gtest.h>

#include <cmath>

#include "grasp_fixture.h"
#include "physics/joint_map.h"

namespace primo::physics {
namespace {

const Shape kCylinder{ShapeType::cylinder, {0.0375, 0.054, 0}};

Model hand(const robot::Robot& robot) {
  auto whole = robot_model(robot);
  PRIMO_CHECK(whole.ok(), whole.error().message);
  auto model = hand_model(robot, whole->get(), kCylinder, 0.3, 0.002);
  PRIMO_CHECK(model.ok(), model.error().message);
  return std::move(model).value();
}

TEST(HandModel, has_the_masses_shapes_and_places_of_the_whole_robots_hand) {
  const auto robot = testing::load_robot();
  auto whole = robot_model(robot);
  ASSERT_TRUE(whole.ok()) << whole.error().message;
  const Model model = hand(robot);
  Data whole_data(*whole), data(model);
  Eigen::VectorXd q = robot.home();
  for (int i = 0; i < q.size(); ++i) q[i] = 0.7 * robot.lower()[i] + 0.3 * robot.upper()[i];
  JointMap(robot, whole->get()).set(whole_data.get(), q);
  JointMap(robot, model.get()).set(data.get(), q);
  mj_kinematics(whole->get(), whole_data.get());
  mj_kinematics(model.get(), data.get());
  const int root = whole->body("link_7");
  ASSERT_GE(root, 0);
  const Pose X_WP = body_pose(whole_data.get(), root);
  int compared = 0;
  for (int b = 1; b < model->nbody; ++b) {
    const std::string name = mj_id2name(model.get(), mjOBJ_BODY, b);
    if (name == kHandObject) continue;
    const int other = whole->body(name);
    ASSERT_GE(other, 0) << name;
    EXPECT_NEAR(model->body_mass[b], (*whole)->body_mass[other], 1e-12) << name;
    EXPECT_LT(
        (X_WP * body_pose(data.get(), b)).matrix().isApprox(body_pose(whole_data.get(), other).matrix(), 1e-9) ? 0 : 1,
        1)
        << name;
    EXPECT_EQ(model->body_geomnum[b], (*whole)->body_geomnum[other]) << name;
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(model->body_inertia[3 * b + k], (*whole)->body_inertia[3 * other + k], 1e-12) << name;
    ++compared;
  }
  EXPECT_EQ(compared, 10);
  EXPECT_EQ(model->nv, 8 + 6);
  EXPECT_EQ(model->neq, 1);
}

TEST(FrameForces, a_free_body_seen_from_a_shaken_frame_moves_straight_in_the_world) {
  // Nothing touches the object and there is no gravity: seen from the world it must go on in a straight line and keep
  // its angular momentum.
  const auto robot = testing::load_robot();
  const Model model = hand(robot);
  Data data(model);
  const int joint = model.joint(kHandObject), body = model.body(kHandObject);
  const double dt = 1e-4;
  const_cast<Model&>(model)->opt.timestep = dt;
  const Eigen::Vector3d centre(0, 0, 0.32);
  Pose X_PO = pose({0.3, 0.5, 0.1}, Eigen::Vector3d(0.3, 0.2, 0.1));
  set_free_joint(model.get(), data.get(), joint, X_PO);
  // The frame turns about `centre`, which stays at the world's origin and does not accelerate.
  Eigen::Matrix3d R_WP = Eigen::Matrix3d::Identity();
  Eigen::Vector3d spin(0.2, -0.4, 0.3), p0, momentum0;
  const auto omega_at = [](double t) {
    return Eigen::Vector3d(2 * std::sin(5 * t), 1.5 * std::sin(7 * t), -std::sin(4 * t));
  };
  const auto alpha_at = [](double t) {
    return Eigen::Vector3d(10 * std::cos(5 * t), 10.5 * std::cos(7 * t), -4 * std::cos(4 * t));
  };
  const Eigen::Vector3d v_world(0.1, -0.2, 0.05);
  const int dof = model->jnt_dofadr[joint];
  Eigen::Map<Eigen::Vector3d>(data->qvel + dof) = v_world;                               // ω(0) = 0: the frames agree
  Eigen::Map<Eigen::Vector3d>(data->qvel + dof + 3) = X_PO.linear().transpose() * spin;  // MuJoCo's spin is in the body
  const auto momentum = [&](const Eigen::Vector3d& omega) {
    const Eigen::Matrix3d R_PO = body_pose(data.get(), body).linear();
    const Eigen::Vector3d w = R_PO * Eigen::Vector3d(Eigen::Map<Eigen::Vector3d>(data->qvel + dof + 3)) + omega;
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R(data->ximat + 9 * body);
    return Eigen::Vector3d(
        R_WP * (R * Eigen::Vector3d(Eigen::Map<const Eigen::Vector3d>(model->body_inertia + 3 * body)).asDiagonal() *
                R.transpose() * w));
  };
  mj_forward(model.get(), data.get());
  p0 = X_PO.translation() - centre;
  momentum0 = momentum(Eigen::Vector3d::Zero());
  const int steps = 10000;
  for (int k = 0; k < steps; ++k) {
    mj_step1(model.get(), data.get());
    ShakerState state;
    state.omega = omega_at(k * dt);
    state.alpha = alpha_at(k * dt);
    apply_frame_forces(model.get(), data.get(), state, centre, Eigen::Vector3d::Zero());
    mj_step2(model.get(), data.get());
    const Eigen::Vector3d middle = omega_at((k + 0.5) * dt);
    R_WP = R_WP * Eigen::AngleAxisd(middle.norm() * dt, middle.normalized()).toRotationMatrix();
  }
  mj_forward(model.get(), data.get());
  const Eigen::Vector3d p = R_WP * (body_pose(data.get(), body).translation() - centre);
  EXPECT_LT((p - (p0 + v_world * (steps * dt))).norm(), 2e-3);  // first-order integration: error ∝ dt
  EXPECT_LT((momentum(omega_at(steps * dt)) - momentum0).norm(), 0.01 * momentum0.norm());
}

TEST(FrameForces, a_free_body_in_a_still_hand_falls_with_gravity) {
  const auto robot = testing::load_robot();
  const Model model = hand(robot);
  Data data(model);
  set_free_joint(model.get(), data.get(), model.joint(kHandObject), pose({0, 0, 1}));
  const Eigen::Vector3d gravity(3, -4, -8);
  const int steps = 200;
  for (int k = 0; k < steps; ++k) {
    mj_step1(model.get(), data.get());
    apply_frame_forces(model.get(), data.get(), {}, Eigen::Vector3d::Zero(), gravity);
    mj_step2(model.get(), data.get());
  }
  const double t = steps * 0.002;
  const Eigen::Vector3d p = Eigen::Map<Eigen::Vector3d>(data->qpos + model->jnt_qposadr[model.joint(kHandObject)]);
  EXPECT_LT((p - (Eigen::Vector3d(0, 0, 1) + 0.5 * gravity * t * (t + 0.002))).norm(), 1e-9);  // Euler's own sum
}

}  // namespace
}  // namespace primo::physics
