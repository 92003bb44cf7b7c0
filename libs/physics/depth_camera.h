// The scenario's depth cameras: rays cast into its MuJoCo scene. The robot is filtered out.
#pragma once

#include <vector>

#include "core/result.h"
#include "scene/estimate.h"
#include "scene/scenario.h"

namespace primo::physics {

/// X_WC of a camera: x right, y down, z along the view. The picture's horizontal is level; a camera that looks straight
/// up or down has world x at its right.
Pose camera_pose(const scene::Camera& camera);

struct DepthSettings {
  double range = 4.0;   ///< m, of the cameras
  double lowest = 0.0;  ///< m in W; lower points are left out, and 0 or less leaves out none
};

/// One cloud for each camera, in order: a point for every pixel whose ray hits the table, an object or the floor within
/// the range, row by row. Noise is along the ray, from (camera_seed, camera, row), so that the same scenario has the
/// same points. Errors: camera values out of bounds, what MuJoCo refuses in the scene.
Result<std::vector<scene::PointCloud>> render_depth(const scene::Scenario& scenario,
                                                    const DepthSettings& settings = {});

}  // namespace primo::physics
