// Random scenes for a place: a nominal grasp of one cylinder, held upright above the table, and another to put it on.
#pragma once

#include <cstdint>
#include <optional>

#include "core/result.h"
#include "robot/robot.h"
#include "scene/generator.h"

namespace primo::physics {

/// How the held object is held at the start. The support and the obstacles around it are `scenes`' target and
/// obstacles.
struct PlaceSceneSettings {
  scene::RandomSceneSettings scenes;
  double min_distance = 0.15;  ///< m, horizontal, held object to support, centres
  double max_distance = 0.30;  ///< m
  double min_lift = 0.02;      ///< m, of the held object's lowest point over the table
  double max_lift = 0.10;      ///< m
  double max_heading = 0.8;    ///< rad, of the approach, from the direction shoulder to object
  double max_pitch = 0.5;      ///< rad, of the approach below the level
  double min_gap = 0.02;       ///< m, of robot and held object to table and objects at the start
  double limit_margin = 0.15;  ///< rad, of the arm's joints at the start
};

/// A scene of [place, c1, c2] with c1 in the hand, the support c2 and obstacles. The grasp: grasp centre at c1's
/// centre, the opposition level, so across its axis, the approach level or from above, fingers closed onto it and all
/// as it rests in physics; of the joint angles that reach it, the first drawn that keeps the margins. Same arguments,
/// same bytes. Errors (config): bounds the wrong way round, or no such start in bounded tries.
Result<scene::Scenario> random_place_scenario(const robot::Robot& robot, const PlaceSceneSettings& settings,
                                              std::uint64_t seed, std::uint64_t index);

/// The arm moved from q until the grasp frame is at X_WG, the fingers as they are. Nothing when it does not get within
/// 0.1 mm and 1 mrad inside the limits.
std::optional<Eigen::VectorXd> arm_to(const robot::Robot& robot, Eigen::VectorXd q, const Pose& X_WG);

}  // namespace primo::physics
