// The frames and objects that tasks name by text.
#pragma once

#include <string>

#include "core/result.h"
#include "motion/planning_scene.h"
#include "robot/robot.h"

namespace primo::motion {

inline constexpr const char* kFrameHelp =
    "a frame: grasp, tool, a fingertip, a body of the robot, world, or an object as target, second, held or by its "
    "name";
inline constexpr const char* kObjectHelp = "an object: target, second, held, or its name in the scene";

/// An object with its frame: fixed to the world (body 0), or to the grasp frame's body when it is held.
struct ObjectFrame {
  const SceneBody* body = nullptr;  ///< in the scene it was found in
  robot::Frame frame;
};

/// `target` and `second` are the action's first and second argument, `held` is what the hand holds; else a name of the
/// scene, its table included. Error data lists what there is.
Result<ObjectFrame> find_object(const robot::Robot& robot, const PlanningScene& scene, const std::string& name);

/// `grasp`, `tool` (the body that the last arm joint moves), `world`, a fingertip, a body of the robot, or an object as
/// above. Error data lists what there is.
Result<robot::Frame> find_frame(const robot::Robot& robot, const PlanningScene& scene, const std::string& name);

}  // namespace primo::motion
