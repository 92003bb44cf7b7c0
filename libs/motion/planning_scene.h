// The scene as planners see it: the action's objects, what the hand holds and everything to keep clear of, as primitive
// shapes; and, where a task asks for it, the occupancy map as distance fields.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/pose.h"
#include "core/result.h"
#include "robot/shape.h"
#include "scene/distance_field.h"
#include "scene/estimate.h"

namespace primo::motion {

struct SceneBody {
  std::string name;
  Shape shape;
  Pose X_WB = Pose::Identity();
  double bounding_radius = 0;  ///< m
};

/// An object in the hand: fixed in the grasp frame G at X_GO. Its shape is the scene's; its pose there is that of when
/// it was seen.
struct HeldObject {
  std::string name;
  Pose X_GO = Pose::Identity();
};

struct PlanningScene {
  SceneBody target;                  ///< the object that the action's first argument names
  std::vector<SceneBody> obstacles;  ///< the other objects in order of name, but for the held one; then the table
  std::string second;                ///< the action's second argument; empty where it has none
  std::optional<SceneBody> held;     ///< what the hand holds; may be the target too. Its X_WB is where it was seen
  Pose X_GO = Pose::Identity();      ///< of the held object in the grasp frame

  /// m, to the centres of occupied voxels but for the held object's; null unless perceive() was called.
  std::shared_ptr<const scene::DistanceField> perceived;
  /// The same without the voxels of contact().
  std::shared_ptr<const scene::DistanceField> perceived_without_contact;

  bool target_is_held() const { return held && held->name == target.name; }
  /// What the motion has to come near in the end: the target of a hand, or the support of a held target. Null: nothing.
  const SceneBody* contact() const { return target_is_held() ? find(second) : &target; }
  /// The object of that name, or the table; null where there is none.
  const SceneBody* find(const std::string& name) const;
  /// The names of all, for messages.
  std::string names() const;

  /// Error data: the action has no argument, the scene has no such object or none of the held one's name, or a size or
  /// pose is not finite.
  static Result<PlanningScene> create(const scene::SceneEstimate& estimate, const std::vector<std::string>& action,
                                      const std::optional<HeldObject>& held = std::nullopt);
  /// Builds the distance fields of the estimate's octree: an object's voxels are those within one voxel of its shape.
  /// Error data: an empty or malformed octree.
  Status perceive(const scene::SceneEstimate& estimate);
};

}  // namespace primo::motion
