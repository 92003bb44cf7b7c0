// Primitive shapes around meshes: primo plans and judges with primitive shapes only.
#pragma once

#include <mujoco/mujoco.h>

#include <string>

#include "core/pose.h"
#include "core/result.h"
#include "robot/shape.h"

namespace primo::robot {

struct Cover {
  Shape shape;
  Pose X_MS = Pose::Identity();  ///< in the frame of the points
};

/// The smallest, by volume, of the box along the axes, the sphere about its centre and the capsule along its longest
/// axis that hold all points (columns, m). MuJoCo's mesh frames are those of inertia, so the axes suit the mesh.
/// @pre at least one point.
Cover cover(const Eigen::Ref<const Eigen::Matrix3Xf>& points);

/// Replaces every colliding mesh geom by its cover; meshes that only are seen stay. Masses and inertias do not change.
/// Error (Code::config): a colliding mesh without vertices or with one that is not finite; `where` names the model.
Status cover_meshes(mjModel& model, const std::string& where);

}  // namespace primo::robot
