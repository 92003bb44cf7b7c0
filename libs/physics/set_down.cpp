#include "physics/set_down.h"

#include "physics/path_clearance.h"

namespace primo::physics {
namespace {

constexpr double kGravity = 9.81;  // m/s²

double height_of(const scene::Object& object) {
  const Shape shape = object.shape();
  return 2 * shape.size[shape.type == ShapeType::box ? 2 : 1];
}

/// Where the held object's foot is in each row, m in W: the point of it that is lowest under its centre at the end.
Eigen::Matrix3Xd foot_path(const robot::Robot& robot, const scene::Scenario& scenario, const Eigen::MatrixXd& q) {
  const scene::Object& object = *scenario.object(scenario.held->object);
  const auto X_WX = [&](Eigen::Index t) {
    return robot.pose(robot.forward(q.row(t).transpose()), robot.grasp_frame()) * scenario.held->X_GO();
  };
  const Eigen::Vector3d foot_X =
      X_WX(q.rows() - 1).linear().transpose() * Eigen::Vector3d(0, 0, -height_of(object) / 2);
  Eigen::Matrix3Xd path(3, q.rows());
  for (Eigen::Index t = 0; t < q.rows(); ++t) path.col(t) = X_WX(t) * foot_X;
  return path;
}

}  // namespace

double contact_travel(const scene::Scenario& scenario, const JudgeSettings& settings) {
  const auto* support = scenario.object(scenario.action[2]);
  return settings.place_tilt * height_of(support ? *support : *scenario.object(scenario.held->object));
}

Eigen::MatrixXd loaded(const robot::Robot& robot, const scene::Scenario& scenario, const Eigen::MatrixXd& q) {
  const Eigen::Vector3d weight_W(0, 0, -kGravity * scenario.object(scenario.held->object)->mass);
  const auto& frame = robot.grasp_frame();
  robot::Kinematics kinematics;
  Eigen::MatrixXd bent = q;
  for (Eigen::Index t = 0; t < q.rows(); ++t) {
    robot.forward(q.row(t).transpose(), kinematics);
    const Eigen::Vector3d centre_W = (robot.pose(kinematics, frame) * scenario.held->X_GO()).translation();
    const Eigen::VectorXd torque = robot.point_jacobian(kinematics, frame.body, centre_W).transpose() * weight_W;
    for (int i = 0; i < robot.arm_joints(); ++i) {
      const double kp = robot.file().arm[static_cast<std::size_t>(i)].kp;
      if (kp > 0) bent(t, i) += torque[i] / kp;
    }
  }
  return bent;
}

SetDown set_down(const robot::Robot& robot, const scene::Scenario& scenario, const JudgeSettings& settings,
                 const Eigen::MatrixXd& q) {
  const Eigen::Matrix3Xd foot = foot_path(robot, scenario, q);
  const double most = contact_travel(scenario, settings);
  // Backwards from the end, until the foot has moved that far.
  Eigen::Index row = q.rows() - 1;
  double travel = 0, step = 0;
  for (; row > 0; --row) {
    step = (foot.col(row) - foot.col(row - 1)).head<2>().norm();
    if (travel + step > most) break;
    travel += step;
  }
  SetDown parts;
  if (row == 0) {
    parts.approach = loaded(robot, scenario, q.topRows(1));
    parts.contact = q;
    return parts;
  }
  const double back = (most - travel) / step;  // of the step before `row`
  const Eigen::RowVectorXd cut = (1 - back) * q.row(row) + back * q.row(row - 1);
  parts.approach.resize(row + 1, q.cols());
  parts.approach << q.topRows(row), cut;
  parts.approach = loaded(robot, scenario, parts.approach);
  parts.contact.resize(q.rows() - row + 1, q.cols());
  parts.contact << cut, q.bottomRows(q.rows() - row);
  return parts;
}

}  // namespace primo::physics
