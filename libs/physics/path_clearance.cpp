#include "physics/path_clearance.h"

#include <algorithm>
#include <cmath>

#include "robot/distance.h"

namespace primo::physics {

std::vector<Obstacle> obstacles(const scene::Scenario& scenario, const std::string& except) {
  const auto& table = scenario.table;
  std::vector<Obstacle> all;
  all.push_back({table.name,
                 pose(table.top_centre - Eigen::Vector3d(0, 0, table.thickness / 2)),
                 {ShapeType::box, {table.size.x() / 2, table.size.y() / 2, table.thickness / 2}}});
  for (const auto& object : scenario.objects) {
    if (object.name != except) all.push_back({object.name, object.X_WO(), object.shape()});
  }
  return all;
}

std::optional<robot::LinkShape> held_shape(const robot::Robot& robot, const scene::Scenario& scenario) {
  const auto* object = scenario.held ? scenario.object(scenario.held->object) : nullptr;
  if (!object) return std::nullopt;
  robot::LinkShape link;
  link.name = object->name;
  link.body = robot.grasp_frame().body;
  link.X_BG = robot.grasp_frame().X_BF * scenario.held->X_GO();
  link.shape = object->shape();
  link.moves = true;
  return link;
}

Eigen::VectorXd lever_arms(const robot::Robot& robot, const std::vector<robot::LinkShape>& links) {
  const robot::Kinematics home = robot.forward(robot.home());
  const auto& chain = robot.chain();
  Eigen::VectorXd lever = Eigen::VectorXd::Zero(robot.joints());
  for (const auto& link : links) {
    // Walk from the link towards the base. Distances between neighbouring anchors do not change with q (slides: plus
    // their travel).
    Eigen::Vector3d from = robot.pose(home, link).translation();
    double length = robot::bounding_radius(link.shape);
    Eigen::VectorXd own = Eigen::VectorXd::Zero(robot.joints());  // one q may drive several joints of a finger
    for (int body = link.body; body > 0; body = robot.bodies()[static_cast<std::size_t>(body)].parent) {
      for (auto j = chain.size(); j-- > 0;) {
        if (chain[j].body != body) continue;
        length += (from - home.anchor_W[j]).norm();
        from = home.anchor_W[j];
        const double per_unit = chain[j].slide ? 1.0 : length;
        own[chain[j].index] += std::abs(chain[j].ratio) * per_unit;
        if (chain[j].slide) {
          length += std::abs(chain[j].ratio) * (robot.upper()[chain[j].index] - robot.lower()[chain[j].index]);
        }
      }
    }
    lever = lever.cwiseMax(own);
  }
  return lever;
}

ClearanceQuery::ClearanceQuery(const robot::Robot& robot, std::vector<ClearancePair> pairs,
                               const std::optional<robot::LinkShape>& held)
    : robot_(robot), pairs_(std::move(pairs)), held_(held.has_value()) {
  for (const auto& pair : pairs_) obstacle_radius_.push_back(robot::bounding_radius(pair.obstacle.shape));
  for (const auto& link : robot.link_shapes()) {
    if (link.moves) links_.push_back(link);
  }
  if (held) links_.push_back(*held);
  for (const auto& link : links_) link_radius_.push_back(robot::bounding_radius(link.shape));
  lever_ = lever_arms(robot, links_);
}

double ClearanceQuery::at(const Eigen::Ref<const Eigen::VectorXd>& q, double enough, int* nearest) {
  robot_.forward(q, kinematics_);
  double best = enough;
  if (nearest) *nearest = -1;
  const auto counts = [&](std::size_t l, RobotPart part) {
    if (held_ && l + 1 == links_.size()) return part == RobotPart::held;
    return part == RobotPart::all || (part == RobotPart::hand && links_[l].hand) ||
           (part == RobotPart::arm && !links_[l].hand);
  };
  for (std::size_t l = 0; l < links_.size(); ++l) {
    const Pose X_WG = robot_.pose(kinematics_, links_[l]);
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
      const auto& [obstacle, part] = pairs_[p];
      if (!counts(l, part)) continue;
      const double apart =
          (X_WG.translation() - obstacle.X_WO.translation()).norm() - link_radius_[l] - obstacle_radius_[p];
      if (apart >= best) continue;
      const double d = robot::distance(links_[l].shape, X_WG, obstacle.shape, obstacle.X_WO).distance;
      if (d < best) {
        best = d;
        if (nearest) *nearest = static_cast<int>(p);
      }
    }
  }
  return best;
}

double ClearanceQuery::motion_bound(const Eigen::Ref<const Eigen::VectorXd>& a,
                                    const Eigen::Ref<const Eigen::VectorXd>& b) const {
  return (a - b).cwiseAbs().dot(lever_);
}

double ClearanceQuery::refine(const Eigen::VectorXd& a, double distance_a, const Eigen::VectorXd& b, double distance_b,
                              double best, int depth) {
  // The distance changes by at most the motion: between a and b it is at least this.
  const double bound = 0.5 * (distance_a + distance_b - motion_bound(a, b));
  if (best <= kDeep || bound >= best - kTolerance || depth == 0) return best;
  const Eigen::VectorXd middle = 0.5 * (a + b);
  const double distance_m = at(middle);
  best = std::min(best, distance_m);
  best = refine(a, distance_a, middle, distance_m, best, depth - 1);
  return refine(middle, distance_m, b, distance_b, best, depth - 1);
}

double ClearanceQuery::over(const Eigen::MatrixXd& q, double enough) {
  std::vector<double> distances(static_cast<std::size_t>(q.rows()));
  double best = enough;
  for (Eigen::Index t = 0; t < q.rows(); ++t) {
    distances[static_cast<std::size_t>(t)] = at(q.row(t).transpose());
    best = std::min(best, distances[static_cast<std::size_t>(t)]);
  }
  for (Eigen::Index t = 0; t + 1 < q.rows(); ++t) {
    best = refine(q.row(t).transpose(), distances[static_cast<std::size_t>(t)], q.row(t + 1).transpose(),
                  distances[static_cast<std::size_t>(t + 1)], best, 16);
  }
  return best;
}

std::optional<ClearanceQuery::Crossing> ClearanceQuery::first_below(const Eigen::MatrixXd& q, double margin) {
  constexpr double kResolution = 0.005;
  Crossing crossing;
  for (Eigen::Index t = 0; t < q.rows(); ++t) {
    const Eigen::Index next = std::min(t + 1, q.rows() - 1);
    const double motion = motion_bound(q.row(t).transpose(), q.row(next).transpose());
    const int parts = std::clamp(static_cast<int>(std::ceil(motion / kResolution)), 1, 400);
    for (int k = 0; k < parts; ++k) {
      const double s = static_cast<double>(k) / parts;
      const Eigen::VectorXd between = ((1 - s) * q.row(t) + s * q.row(next)).transpose();
      if (at(between, margin, &crossing.pair) < margin) {
        crossing.step = static_cast<double>(t) + s;
        return crossing;
      }
    }
  }
  return std::nullopt;
}

}  // namespace primo::physics
