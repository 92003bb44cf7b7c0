#include "scene/held.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

#include "robot/distance.h"

namespace primo::scene {
namespace {

constexpr double kPositionTolerance = 1e-3;  // m
constexpr double kAngleTolerance = 0.01;     // rad
constexpr double kOpposed = -0.3;            // cosine between the directions from which two parts of the hand hold it

Eigen::VectorXd start_of(const Scenario& scenario) {
  return Eigen::Map<const Eigen::VectorXd>(scenario.robot_start.data(),
                                           static_cast<Eigen::Index>(scenario.robot_start.size()));
}

std::string text(const char* format, double a, double b = 0, double c = 0) {
  char buffer[96];
  std::snprintf(buffer, sizeof buffer, format, a, b, c);
  return buffer;
}

Status check_grip(const std::string& place, const Object& object, const Pose& X_WO, const robot::Robot& robot,
                  const robot::Kinematics& kinematics) {
  double nearest = std::numeric_limits<double>::infinity();
  std::vector<Eigen::Vector3d> from;
  for (const auto& link : robot.link_shapes()) {
    if (!link.hand) continue;
    const auto d = robot::distance(link.shape, robot.pose(kinematics, link), object.shape(), X_WO);
    if (d.distance < -kHeldDepth) {
      return Error{Code::config, place + link.name + " of the hand is " + text("%.1f mm", -1e3 * d.distance) +
                                     " inside it; at most " + text("%.0f mm", 1e3 * kHeldDepth) + " are right"};
    }
    nearest = std::min(nearest, d.distance);
    if (d.distance <= kHeldGap) from.push_back(d.normal);
  }
  for (std::size_t i = 1; i < from.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (from[i].dot(from[j]) < kOpposed) return success();
    }
  }
  return Error{Code::config, place + "it is not in the hand: the nearest part of the hand is " +
                                 text("%.1f mm", 1e3 * nearest) + " away and " + std::to_string(from.size()) +
                                 " are near enough; two that face each other must be within " +
                                 text("%.0f mm", 1e3 * kHeldGap)};
}

}  // namespace

Pose held_pose(const Scenario& scenario, const robot::Robot& robot, const Eigen::VectorXd& q) {
  return robot.pose(robot.forward(q), robot.grasp_frame()) * scenario.held->X_GO();
}

Pose held_pose(const Scenario& scenario, const robot::Robot& robot) {
  return held_pose(scenario, robot, start_of(scenario));
}

Eigen::VectorXd with_held_fingers(const Scenario& scenario, const robot::Robot& robot, Eigen::VectorXd q) {
  for (int j = robot.arm_joints(); j < robot.joints(); ++j) {
    if (static_cast<std::size_t>(j) < scenario.robot_start.size())
      q[j] = scenario.robot_start[static_cast<std::size_t>(j)];
  }
  return q;
}

Status check_held(const Scenario& scenario, const robot::Robot& robot) {
  if (!scenario.held) return success();
  const Object& object = *scenario.object(scenario.held->object);
  const std::string place = "held object '" + object.name + "': ";
  const Pose X_WO = object.X_WO(), expected = held_pose(scenario, robot);
  const double off = (X_WO.translation() - expected.translation()).norm();
  // A cylinder looks the same however it is turned about its axis, but a box does not: all axes count.
  const double angle = Eigen::AngleAxisd(X_WO.linear().transpose() * expected.linear()).angle();
  if (!(off <= kPositionTolerance) || !(angle <= kAngleTolerance)) {
    const Eigen::Vector3d p = expected.translation();
    return Error{Code::config, place + "its pose is " + text("%.1f mm and %.3f rad", 1e3 * off, angle) +
                                   " from where robot_start and 'held' put it; position would be " +
                                   text("[%.4f, %.4f, %.4f]", p.x(), p.y(), p.z())};
  }
  return check_grip(place, object, X_WO, robot, robot.forward(start_of(scenario)));
}

}  // namespace primo::scene
