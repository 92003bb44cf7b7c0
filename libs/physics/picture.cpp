#include "physics/picture.h"

#include <algorithm>
#include <cmath>

#include "core/files.h"
#include "physics/canvas.h"
#include "physics/joint_map.h"
#include "scene/held.h"

namespace primo::physics {
namespace {

Status check_motion(const robot::Robot& robot, Eigen::Index columns, bool finite) {
  if (columns != robot.joints() || !finite) {
    return Error{Code::data, "a picture of robot " + robot.name() + " needs " + std::to_string(robot.joints()) +
                                 " finite joint angles, not " + std::to_string(columns)};
  }
  return success();
}

Status write_png(const std::filesystem::path& path, const Result<Image>& image) {
  if (!image.ok()) return image.error();
  PRIMO_ASSIGN(const std::string bytes, png_bytes(*image));
  return write_file(path, bytes);
}

/// Poses the robot and what it holds.
void pose_all(Canvas& canvas, const robot::Robot& robot, const scene::Scenario& scenario, const Eigen::VectorXd& q) {
  canvas.pose_robot(q);
  if (scenario.held) canvas.pose_object(scenario.held->object, scene::held_pose(scenario, robot, q));
}

Eigen::VectorXd shown(const robot::Robot& robot, const scene::Scenario& scenario, const Eigen::VectorXd& q,
                      bool close_hand) {
  if (scenario.held) return scene::with_held_fingers(scenario, robot, q);
  const scene::Object* object = scenario.action.size() > 1 ? scenario.object(scenario.action[1]) : nullptr;
  return close_hand && object ? close_onto(robot, q, object->shape(), object->X_WO()) : q;
}

}  // namespace

View overview(const scene::Scenario& scenario) {
  // Robot at the origin, table in front of it: look from the table's far right at the middle between them.
  const Eigen::Vector3d table = scenario.table.top_centre;
  View view;
  view.look_at = Eigen::Vector3d(0.55 * table.x(), 0.6 * table.y() + 0.08, table.z() + 0.17);
  view.position = view.look_at + Eigen::Vector3d(1.55, -1.25, 0.85);
  view.fov_y = 0.72;
  return view;
}

View table_view(const scene::Scenario& scenario) {
  View view;
  view.look_at = scenario.table.top_centre;
  view.position = view.look_at + 1.35 * scenario.table.size.norm() * Eigen::Vector3d(0.62, -0.62, 0.55);
  view.fov_y = 0.62;
  return view;
}

View close_up(const robot::Robot& robot, const scene::Scenario& scenario, const Eigen::VectorXd& q) {
  const Pose X_WG = robot.pose(robot.forward(q), robot.grasp_frame());
  const scene::Object* object = scenario.action.size() > 1 ? scenario.object(scenario.action[1]) : nullptr;
  View view;
  view.look_at =
      object ? Eigen::Vector3d(0.6 * object->position + 0.4 * X_WG.translation()) : Eigen::Vector3d(X_WG.translation());
  // From the side of the hand, a little ahead of it and above, so that thumb and fingers are both seen.
  Eigen::Vector3d approach = X_WG.linear().col(2), side = approach.cross(Eigen::Vector3d::UnitZ());
  if (side.norm() < 0.1) side = Eigen::Vector3d(0.6, -0.8, 0);
  side.normalize();
  if (side.y() > 0) side = -side;
  approach.z() = 0;
  view.position = view.look_at + 0.50 * side + 0.18 * approach + Eigen::Vector3d(0, 0, 0.36);
  view.fov_y = 0.62;
  return view;
}

Status render_png(const std::filesystem::path& path, const robot::Robot* robot, const scene::Scenario& scenario,
                  const Eigen::VectorXd& q, const PictureOptions& options) {
  if (robot) PRIMO_TRY(check_motion(*robot, q.size(), q.allFinite()));
  auto canvas = Canvas::create(robot, scenario, options);
  if (!canvas.ok()) return canvas.error();
  if (robot) pose_all(*canvas, *robot, scenario, shown(*robot, scenario, q, options.close_hand));
  canvas->draw_all();
  return write_png(path, canvas->image(options.view.value_or(robot ? overview(scenario) : table_view(scenario))));
}

Status render_motion_png(const std::filesystem::path& path, const robot::Robot& robot, const scene::Scenario& scenario,
                         const Eigen::MatrixXd& q, const MotionPictureOptions& options) {
  if (q.rows() < 1) return Error{Code::data, "a motion picture needs at least one row of joint angles"};
  PRIMO_TRY(check_motion(robot, q.cols(), q.allFinite()));
  if (options.compare) PRIMO_TRY(check_motion(robot, options.compare->cols(), options.compare->allFinite()));
  auto canvas = Canvas::create(&robot, scenario, options.picture);
  if (!canvas.ok()) return canvas.error();
  const Eigen::Index last = q.rows() - 1;
  const bool close = options.picture.close_hand;
  pose_all(*canvas, robot, scenario, shown(robot, scenario, q.row(last).transpose(), close));
  canvas->draw_all();
  for (int part = 0; part < 2 && last > 0; ++part) {
    Eigen::VectorXd at = q.row(last * part / 2).transpose();
    if (scenario.held) at = scene::with_held_fingers(scenario, robot, std::move(at));
    pose_all(*canvas, robot, scenario, at);
    canvas->draw_ghost(at, 0.3F, scenario.held ? scenario.held->object : std::string());
  }
  canvas->draw_path(q, options.dashed);
  if (options.compare) canvas->draw_path(*options.compare, !options.dashed, kOtherLine);
  return write_png(path, canvas->image(options.picture.view.value_or(overview(scenario))));
}

}  // namespace primo::physics
