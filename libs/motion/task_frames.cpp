#include "motion/task_frames.h"

#include <algorithm>

namespace primo::motion {
namespace {

Error no_object(const PlanningScene& scene, const std::string& name, const std::string& why) {
  return {Code::data, "'" + name + "' " + why + "; there are " + scene.names() +
                          (scene.second.empty() ? "" : "; second is '" + scene.second + "'") +
                          (scene.held ? "; the hand holds '" + scene.held->name + "'" : "; the hand holds nothing")};
}

}  // namespace

Result<ObjectFrame> find_object(const robot::Robot& robot, const PlanningScene& scene, const std::string& name) {
  const SceneBody* body = nullptr;
  if (name == "target") {
    body = &scene.target;
  } else if (name == "held") {
    if (!scene.held) return no_object(scene, name, "is asked for, but the hand holds nothing");
    body = &*scene.held;
  } else if (name == "second") {
    if (scene.second.empty()) return no_object(scene, name, "is asked for, but the action has one argument only");
    body = scene.find(scene.second);
  } else {
    body = scene.find(name);
  }
  if (!body) return no_object(scene, name, "is no object of the scene");
  if (!scene.held || body->name != scene.held->name) return ObjectFrame{body, {0, body->X_WB}};
  const robot::Frame& grasp = robot.grasp_frame();
  return ObjectFrame{body, {grasp.body, grasp.X_BF * scene.X_GO}};
}

Result<robot::Frame> find_frame(const robot::Robot& robot, const PlanningScene& scene, const std::string& name) {
  if (name == "grasp") return robot.grasp_frame();
  if (name == "world") return robot::Frame{};
  std::string known = "grasp, tool, world";
  if (name == "tool") return robot::Frame{robot.tool_body(), Pose::Identity()};
  for (const auto& tip : robot.fingertips()) {
    if (tip.name == name) return tip.frame;
    known += ", " + tip.name;
  }
  if (const int body = robot.body(name); body >= 0) return robot::Frame{body, Pose::Identity()};
  for (std::size_t b = 1; b < robot.bodies().size(); ++b) known += ", " + robot.bodies()[b].name;
  auto object = find_object(robot, scene, name);
  if (object.ok()) return object->frame;
  return Error{object.error().code, "frame: " + object.error().message + "; frames of the robot are " + known};
}

}  // namespace primo::motion
