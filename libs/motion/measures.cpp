#include "motion/measures.h"

#include <algorithm>
#include <limits>

#include "motion/planning_scene.h"
#include "robot/distance.h"

namespace primo::motion {
namespace {

constexpr double kFar = 10;  // m

double min_distance_at(const robot::Robot& robot, const PlanningScene& scene, const robot::Kinematics& kinematics) {
  double least = kFar;
  for (const auto& link : robot.link_shapes()) {
    if (!link.moves) continue;
    const Pose X_WG = robot.pose(kinematics, link);
    for (const auto& body : scene.obstacles)
      least = std::min(least, robot::distance(link.shape, X_WG, body.shape, body.X_WB).distance);
  }
  return least;
}

}  // namespace

Measures measure(const robot::Robot& robot, const PlanRequest& request, const Plan& plan) {
  const Eigen::MatrixXd& q = plan.trajectory.q;
  const auto scene = PlanningScene::create(request.scene, request.action);
  Measures measures;
  if (q.rows() == 0 || !scene.ok()) return measures;
  measures.min_distance = kFar;
  measures.min_limit_margin = std::numeric_limits<double>::max();
  for (Eigen::Index t = 0; t < q.rows(); ++t) {
    const Eigen::VectorXd q_t = q.row(t).transpose();
    measures.min_distance = std::min(measures.min_distance, min_distance_at(robot, *scene, robot.forward(q_t)));
    const double below = (q_t - robot.lower()).minCoeff(), above = (robot.upper() - q_t).minCoeff();
    measures.min_limit_margin = std::min({measures.min_limit_margin, below, above});
    if (t > 0) measures.path_length += (q.row(t) - q.row(t - 1)).norm();
  }
  return measures;
}

}  // namespace primo::motion
