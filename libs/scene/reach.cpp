#include "scene/reach.h"

#include <cmath>
#include <cstdio>

#include "scene/held.h"

namespace primo::scene {
namespace {

constexpr double kFarthest = 0.95;  // of the stretched arm: straight arms have no freedom left to turn the hand
constexpr double kNearest = 0.25;

std::string metres(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.2f m", value);
  return buffer;
}

}  // namespace

Reach reach(const robot::Robot& robot) {
  const robot::Kinematics at_home = robot.forward(robot.home());
  Reach result;
  bool first = true;
  Eigen::Vector3d last = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < robot.chain().size(); ++i) {
    if (robot.chain()[i].index >= robot.arm_joints()) continue;
    const Eigen::Vector3d anchor = at_home.anchor_W[i];
    if (first) result.shoulder_W = anchor;
    if (!first) result.longest += (anchor - last).norm();
    if (robot.chain()[i].slide) {
      const int q = robot.chain()[i].index;
      result.longest += std::abs(robot.chain()[i].ratio) * (robot.upper()[q] - robot.lower()[q]);
    }
    first = false;
    last = anchor;
  }
  if (first) last = result.shoulder_W = robot.pose(at_home, robot.grasp_frame()).translation();
  result.longest += (robot.pose(at_home, robot.grasp_frame()).translation() - last).norm();
  return result;
}

Status check_robot(const Scenario& scenario, const robot::Robot& robot) {
  const std::string place = "scenario " + scenario.name + " with robot " + robot.name();
  if (!scenario.robot_start.empty() && scenario.robot_start.size() != static_cast<std::size_t>(robot.joints())) {
    return Error{Code::config, place + ": 'robot_start' has " + std::to_string(scenario.robot_start.size()) +
                                   " joint angles, must have " + std::to_string(robot.joints()) +
                                   " (or none, for the robot's home)"};
  }
  for (std::size_t i = 0; i < scenario.robot_start.size(); ++i) {
    const auto joint = static_cast<Eigen::Index>(i);
    const double q = scenario.robot_start[i];
    if (q >= robot.lower()[joint] && q <= robot.upper()[joint]) continue;
    return Error{Code::config, place + ": 'robot_start[" + std::to_string(i) + "]' is " + std::to_string(q) +
                                   ", beyond the limits of joint " + robot.joint_names()[i] + ": " +
                                   std::to_string(robot.lower()[joint]) + " … " + std::to_string(robot.upper()[joint])};
  }
  const Reach arm = reach(robot);
  for (std::size_t i = 1; i < scenario.action.size(); ++i) {
    const Object* object = scenario.object(scenario.action[i]);
    if (!object || scenario.holds(object->name)) continue;
    const double distance = (object->position - arm.shoulder_W).norm();
    if (distance >= kNearest * arm.longest && distance <= kFarthest * arm.longest) continue;
    return Error{Code::config, place + ": object '" + object->name + "' cannot be reached: it is " + metres(distance) +
                                   " from the shoulder, must be between " + metres(kNearest * arm.longest) + " and " +
                                   metres(kFarthest * arm.longest)};
  }
  if (auto status = check_held(scenario, robot); !status.ok()) return status.error().at(place);
  return success();
}

}  // namespace primo::scene
