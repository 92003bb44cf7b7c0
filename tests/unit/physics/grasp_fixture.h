// Hand-made grasps for the tests: the robot's arm placed by inverse kinematics so that the grasp frame is where we want
// it.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>

#include "core/random.h"
#include "physics/judge.h"
#include "robot/robot.h"

namespace primo::physics::testing {

inline robot::Robot load_robot() {
  auto robot = robot::Robot::load(std::filesystem::path(PRIMO_SOURCE_DIR) / "configs/robots/schunk_lwa3_sdh2.yaml");
  PRIMO_CHECK(robot.ok(), robot.error().message);
  return std::move(robot).value();
}

/// A cylinder of the paper's size on the table's middle, nearer to the robot by default.
inline scene::Scenario one_cylinder(const Eigen::Vector2d& at = {0.8, 0.0}) {
  scene::Scenario scenario;
  scenario.name = "one cylinder";
  scene::Object object;
  object.name = "c1";
  object.position = {at.x(), at.y(), 0.67 + object.height / 2};
  scenario.objects = {object};
  scenario.cameras = {scene::Camera{}};
  scenario.action = {"grasp", "c1"};
  return scenario;
}

/// Moves the arm from q until the grasp frame is at X_WG; the fingers stay. Nothing if it does not get within 0.1 mm
/// and 1 mrad.
inline std::optional<Eigen::VectorXd> arm_to(const robot::Robot& robot, Eigen::VectorXd q, const Pose& X_WG) {
  const int arm = robot.arm_joints();
  robot::Kinematics kinematics;
  for (int iteration = 0; iteration < 300; ++iteration) {
    robot.forward(q, kinematics);
    const Pose X = robot.pose(kinematics, robot.grasp_frame());
    Eigen::Matrix<double, 12, 1> error;
    Eigen::MatrixXd J(12, arm);
    error.head<3>() = X_WG.translation() - X.translation();
    J.topRows(3) = robot.point_jacobian(kinematics, robot.grasp_frame().body, X.translation()).leftCols(arm);
    for (int axis = 0; axis < 3; ++axis) {
      error.segment<3>(3 + 3 * axis) = 0.2 * (X_WG.linear().col(axis) - X.linear().col(axis));
      J.middleRows(3 + 3 * axis, 3) =
          0.2 * robot.vector_jacobian(kinematics, robot.grasp_frame().body, X.linear().col(axis)).leftCols(arm);
    }
    if (error.head<3>().norm() < 1e-4 && error.tail<9>().norm() < 2e-4) return q;
    const Eigen::MatrixXd A = J.transpose() * J + 1e-5 * Eigen::MatrixXd::Identity(arm, arm);
    q.head(arm) += A.ldlt().solve(J.transpose() * error).cwiseMax(-0.3).cwiseMin(0.3);
    q.head(arm) = q.head(arm).cwiseMax(robot.lower().head(arm)).cwiseMin(robot.upper().head(arm));
  }
  return std::nullopt;
}

/// The grasp frame for a side grasp of an upright object at `centre`: approach z level in direction `heading` (rad from
/// x), opposition x level. `roll` turns the hand about its approach.
inline Pose side_grasp(const Eigen::Vector3d& centre, double heading, double roll = 0) {
  Pose X = Pose::Identity();
  const Eigen::Vector3d z(std::cos(heading), std::sin(heading), 0);
  const Eigen::Vector3d y = Eigen::Vector3d::UnitZ();
  X.linear() << y.cross(z), y, z;
  X.linear() = X.linear() * Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  X.translation() = centre;
  return X;
}

/// A clean side grasp of object c1: back off along the approach, then straight in.
struct HandMadeGrasp {
  double heading = 0, roll = 0;
  Eigen::MatrixXd q;  ///< rows: the approach
  double dt = 0.0625;
};

/// Tries headings and starts in a fixed order. `offset` shifts the final pose in the grasp frame's axes, m.
inline std::optional<HandMadeGrasp> hand_made_grasp(const robot::Robot& robot, const scene::Scenario& scenario,
                                                    const Eigen::Vector3d& offset = Eigen::Vector3d::Zero(),
                                                    double back_off = 0.12, int steps = 32) {
  const Eigen::Vector3d centre = scenario.object("c1")->position;
  for (const double heading : {0.0, -0.3, 0.3, -0.6, 0.6, -0.9, 0.9, -1.2, 1.2}) {
    for (const double roll : {0.0, 3.14159265358979}) {
      for (std::uint64_t attempt = 0; attempt < 12; ++attempt) {
        Random random(attempt, "hand-made grasp");
        Eigen::VectorXd q = robot.home();
        for (int i = 0; i < robot.arm_joints(); ++i) {
          q[i] = attempt == 0 ? 0.5 * (robot.lower()[i] + robot.upper()[i])
                              : random.uniform(robot.lower()[i], robot.upper()[i]);
        }
        Pose X_WG = side_grasp(centre, heading, roll);
        X_WG.translation() += X_WG.linear() * offset;
        auto end = arm_to(robot, q, X_WG);
        if (!end) continue;
        HandMadeGrasp grasp{heading, roll, Eigen::MatrixXd(steps + 1, robot.joints()), 0.0625};
        grasp.q.row(steps) = end->transpose();
        bool reached = true;
        for (int t = steps - 1; t >= 0 && reached; --t) {
          const double s = static_cast<double>(t) / steps, eased = s * s * (3 - 2 * s);
          Pose X = X_WG;
          X.translation() -= X.linear().col(2) * back_off * (1 - eased);
          const auto at = arm_to(robot, grasp.q.row(t + 1).transpose(), X);
          reached = at && (at->transpose() - grasp.q.row(t + 1)).cwiseAbs().maxCoeff() < 0.1;
          if (reached) grasp.q.row(t) = at->transpose();
        }
        if (reached) return grasp;
      }
    }
  }
  return std::nullopt;
}

/// From the side, along the opposition, to the configuration `end` in 40 steps: the thumb or the fingers have to cross
/// what stands there.
inline std::optional<Eigen::MatrixXd> sideways_sweep(const robot::Robot& robot, const Eigen::VectorXd& end) {
  const Pose X_WG = robot.pose(robot.forward(end), robot.grasp_frame());
  Eigen::MatrixXd q(41, robot.joints());
  for (const double side : {0.1, -0.1}) {  // m, from whichever side the arm can
    Eigen::VectorXd at = end;
    bool reached = true;
    for (int t = 40; t >= 0 && reached; --t) {
      Pose X = X_WG;
      X.translation() += X_WG.linear().col(0) * side * (40 - t) / 40;
      const auto next = arm_to(robot, at, X);
      reached = next.has_value();
      if (reached) at = *next, q.row(t) = at.transpose();
    }
    q.row(40) = end.transpose();
    if (reached) return q;
  }
  return std::nullopt;
}

/// Gives the request this motion, and the robot its start.
inline void set_motion(JudgeRequest& request, const Eigen::MatrixXd& q) {
  request.q = q;
  request.scenario.robot_start.resize(static_cast<std::size_t>(q.cols()));
  for (Eigen::Index i = 0; i < q.cols(); ++i) request.scenario.robot_start[static_cast<std::size_t>(i)] = q(0, i);
}

inline JudgeRequest request_for(const scene::Scenario& scenario, const HandMadeGrasp& grasp, std::uint64_t seed = 1) {
  JudgeRequest request;
  request.scenario = scenario;
  set_motion(request, grasp.q);
  request.dt = grasp.dt;
  request.seed = seed;
  return request;
}

}  // namespace primo::physics::testing
