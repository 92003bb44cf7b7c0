// Hand-made places for the tests: a nominal grasp from the scene generator, moved straight up, across and down.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "physics/judge.h"
#include "physics/place_scenes.h"

namespace primo::physics::testing {

/// c1 in the hand and c2 on the table, no obstacles.
inline scene::Scenario place_scenario(const robot::Robot& robot, std::uint64_t index = 0) {
  PlaceSceneSettings settings;
  settings.scenes.min_obstacles = settings.scenes.max_obstacles = 0;
  auto scenario = random_place_scenario(robot, settings, 5, index);
  PRIMO_CHECK(scenario.ok(), scenario.error().message);
  return std::move(scenario).value();
}

inline Eigen::VectorXd start_of(const scene::Scenario& scenario) {
  return Eigen::Map<const Eigen::VectorXd>(scenario.robot_start.data(),
                                           static_cast<Eigen::Index>(scenario.robot_start.size()));
}

/// Where c1 stands on c2.
inline Eigen::Vector3d top_of_support(const scene::Scenario& scenario) {
  const auto &x = *scenario.object("c1"), &y = *scenario.object("c2");
  return y.position + Eigen::Vector3d(0, 0, (x.height + y.height) / 2);
}

/// Joint paths that carry c1, its orientation kept, through these places of its centre; 32 steps each, slow at their
/// ends. Nothing where the arm cannot.
inline std::optional<Eigen::MatrixXd> carry(const robot::Robot& robot, const scene::Scenario& scenario,
                                            const std::vector<Eigen::Vector3d>& places) {
  constexpr int kSteps = 32;
  const Eigen::VectorXd start = start_of(scenario);
  const Pose X_WG0 = robot.pose(robot.forward(start), robot.grasp_frame());
  Eigen::Vector3d from = scenario.object("c1")->position;
  const Eigen::Vector3d grasp = X_WG0.translation() - from;
  Eigen::MatrixXd q(kSteps * static_cast<int>(places.size()) + 1, start.size());
  q.row(0) = start.transpose();
  Eigen::Index row = 0;
  for (const auto& to : places) {
    for (int k = 1; k <= kSteps; ++k) {
      const double x = static_cast<double>(k) / kSteps, s = x * x * (3 - 2 * x);
      Pose X_WG = X_WG0;
      X_WG.translation() = grasp + from + s * (to - from);
      const auto at = arm_to(robot, q.row(row).transpose(), X_WG);
      if (!at) return std::nullopt;
      q.row(++row) = at->transpose();
    }
    from = to;
  }
  return q;
}

/// A request that lifts c1, carries it over c2 and lowers it to 5 mm above its place, `offset` (m, in W) off it. The
/// first scene of a fixed order in which the arm can.
inline std::optional<JudgeRequest> place_at(const robot::Robot& robot, const Eigen::Vector3d& offset,
                                            std::uint64_t first = 0) {
  for (std::uint64_t index = first; index < first + 8; ++index) {
    JudgeRequest request;
    request.scenario = place_scenario(robot, index);
    const Eigen::Vector3d from = request.scenario.object("c1")->position;
    const Eigen::Vector3d to = top_of_support(request.scenario) + offset + Eigen::Vector3d(0, 0, 0.005);
    const double high = std::max(from.z(), to.z()) + 0.06;
    const auto path = carry(robot, request.scenario, {{from.x(), from.y(), high}, {to.x(), to.y(), high}, to});
    if (!path) continue;
    request.q = *path;
    request.dt = 0.0625;
    return request;
  }
  return std::nullopt;
}

}  // namespace primo::physics::testing
