// Smallest distance between a moving robot and a fixed scene over a whole piecewise linear joint path, also between its
// steps.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "physics/verdict.h"
#include "robot/robot.h"

namespace primo::physics {

/// A fixed shape of the scene.
struct Obstacle {
  std::string name;
  Pose X_WO = Pose::Identity();
  Shape shape;
};

/// Which of the moving shapes count against an obstacle: the robot's, or what its hand holds.
enum class RobotPart { all, hand, arm, held };

struct ClearancePair {
  Obstacle obstacle;
  RobotPart part = RobotPart::all;
};

/// The scenario's table, and its objects with `except` left out.
std::vector<Obstacle> obstacles(const scene::Scenario& scenario, const std::string& except = {});

/// What the hand holds in the scenario, as a shape that moves with the grasp frame; nothing when it is free.
std::optional<robot::LinkShape> held_shape(const robot::Robot& robot, const scene::Scenario& scenario);

/// Distances of one robot to a fixed list of obstacles. For one thread at a time.
class ClearanceQuery {
 public:
  ClearanceQuery(const robot::Robot& robot, std::vector<ClearancePair> pairs,
                 const std::optional<robot::LinkShape>& held = std::nullopt);

  /// Smallest signed distance at q, m, or `enough` if none is smaller; `nearest` is the index of its pair (−1: none
  /// below `enough`).
  double at(const Eigen::Ref<const Eigen::VectorXd>& q, double enough = kFar, int* nearest = nullptr);

  /// Smallest signed distance over the path q_0 … q_T (rows), joints interpolated linearly: at most kTolerance (1 mm)
  /// above the truth, by branch and bound with a Lipschitz bound of the motion. Deeper than −0.1 m it is only known to
  /// be that deep. `enough`, m, if none is smaller: what is above need not be known.
  double over(const Eigen::MatrixXd& q, double enough = kFar);

  /// The first time along the path, in steps, at which the distance falls below `margin`, to within 5 mm of motion, and
  /// the pair that does.
  struct Crossing {
    double step = 0;
    int pair = -1;
  };
  std::optional<Crossing> first_below(const Eigen::MatrixXd& q, double margin);

  /// Upper bound of how far any point of the robot moves between a and b, m.
  double motion_bound(const Eigen::Ref<const Eigen::VectorXd>& a, const Eigen::Ref<const Eigen::VectorXd>& b) const;

  static constexpr double kTolerance = 1e-3;
  static constexpr double kFar = 10.0;
  static constexpr double kDeep = -0.1;

 private:
  double refine(const Eigen::VectorXd& a, double distance_a, const Eigen::VectorXd& b, double distance_b, double best,
                int depth);

  const robot::Robot& robot_;
  std::vector<ClearancePair> pairs_;
  std::vector<robot::LinkShape> links_;  // those that move, the held object last
  bool held_ = false;
  std::vector<double> obstacle_radius_;
  std::vector<double> link_radius_;
  Eigen::VectorXd lever_;  // by joint: m of motion per rad, at most
  robot::Kinematics kinematics_;
};

/// Upper bound of the distance from joint `joint`'s anchor to any point of `links` it moves, by joint of q, m (1 for
/// slides).
Eigen::VectorXd lever_arms(const robot::Robot& robot, const std::vector<robot::LinkShape>& links);

}  // namespace primo::physics
