// What the motion tests share: the robot, scenes and requests.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>

#include "core/random.h"
#include "motion/planner.h"

namespace primo::motion {

inline const robot::Robot& schunk() {
  static const robot::Robot robot =
      robot::Robot::load(std::filesystem::path(PRIMO_SOURCE_DIR) / "configs/robots/schunk_lwa3_sdh2.yaml").value();
  return robot;
}

inline const Primitive& hand_tuned() {
  static const Primitive primitive =
      read_primitive(std::filesystem::path(PRIMO_SOURCE_DIR) / "configs/primitives/grasp_hand_tuned.yaml").value();
  return primitive;
}

inline scene::ObjectEstimate cylinder(const std::string& name, double x, double y) {
  scene::ObjectEstimate object;
  object.name = name;
  object.shape = {ShapeType::cylinder, {0.0375, 0.054, 0}};
  object.X_WO = pose(Eigen::Vector3d(x, y, 0.724));
  return object;
}

/// A grasp of c1 beside one other cylinder, from the robot's home.
inline PlanRequest request(std::uint64_t seed, const Primitive& primitive) {
  Random random(seed, "motion_test");
  PlanRequest request;
  const double x = random.uniform(0.7, 0.9), y = random.uniform(-0.15, 0.15), angle = random.uniform(0, 6.28);
  request.scene.objects = {cylinder("c1", x, y),
                           cylinder("c2", x + 0.14 * std::cos(angle), y + 0.14 * std::sin(angle))};
  request.action = {"grasp", "c1"};
  request.q_start.assign(schunk().home().data(), schunk().home().data() + schunk().joints());
  request.primitive = primitive;
  return request;
}

inline Eigen::VectorXd random_q(std::uint64_t i) {
  Random random(2, "motion_test q", {i});
  Eigen::VectorXd q(schunk().joints());
  for (int j = 0; j < q.size(); ++j) q[j] = random.uniform(schunk().lower()[j], schunk().upper()[j]);
  return q;
}

}  // namespace primo::motion
