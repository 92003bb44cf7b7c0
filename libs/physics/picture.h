// Pictures of a scene and a robot, rendered off-screen in software: no display or graphics card is needed.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>

#include "core/result.h"
#include "robot/robot.h"
#include "scene/scenario.h"

namespace primo::physics {

/// A pinhole view in W, z up.
struct View {
  Eigen::Vector3d position{1.9, -1.2, 1.55};
  Eigen::Vector3d look_at{0.6, 0.05, 0.8};
  double fov_y = 0.75;  ///< rad, vertical
};

/// The robot, the table and all objects.
View overview(const scene::Scenario& scenario);
/// The table and what stands on it.
View table_view(const scene::Scenario& scenario);
/// The hand at q and the action's object, from the side and above. @pre q has the robot's size.
View close_up(const robot::Robot& robot, const scene::Scenario& scenario, const Eigen::VectorXd& q);

struct PictureOptions {
  int width = 640, height = 480;  ///< pixels, 16 … 2048 each
  std::optional<View> view;       ///< when absent: overview(), or table_view() without a robot
  bool close_hand = false;        ///< show the fingers closed on the action's object
};

/// The scene with the robot at q (no robot: null, q ignored) as a PNG file, never half-written. The action's object is
/// purple, others green. Error: a wrong size, a model that MuJoCo refuses, no software renderer, a file that cannot be
/// written.
Status render_png(const std::filesystem::path& path, const robot::Robot* robot, const scene::Scenario& scenario,
                  const Eigen::VectorXd& q, const PictureOptions& options = {});

/// A motion q_0 … q_T (rows) in one picture: the robot at the end, its start and its middle as ghosts, and
/// the path of the grasp centre as a line, solid or dashed. What the hand holds is drawn with it each time. Another
/// motion's path can be drawn beside it, the other way.
struct MotionPictureOptions {
  PictureOptions picture;
  bool dashed = false;
  const Eigen::MatrixXd* compare = nullptr;  ///< rows: another motion of this robot, in blue
};
Status render_motion_png(const std::filesystem::path& path, const robot::Robot& robot, const scene::Scenario& scenario,
                         const Eigen::MatrixXd& q, const MotionPictureOptions& options = {});

}  // namespace primo::physics
