// The scene as planners see it: the target and everything to keep clear of, as primitive shapes.
#pragma once

#include <string>
#include <vector>

#include "core/pose.h"
#include "core/result.h"
#include "robot/shape.h"
#include "scene/estimate.h"

namespace primo::motion {

struct SceneBody {
  std::string name;
  Shape shape;
  Pose X_WB = Pose::Identity();
  double bounding_radius = 0;  ///< m
};

struct PlanningScene {
  SceneBody target;                  ///< the object that the action's first argument names
  std::vector<SceneBody> obstacles;  ///< the other objects in order of name, then the table

  /// Error data: the action has no argument, or the scene no such object, or a size or pose that is not finite.
  static Result<PlanningScene> create(const scene::SceneEstimate& estimate, const std::vector<std::string>& action);
};

}  // namespace primo::motion
