// What the tests of task variables share: a perceived scene, with the hand free and with the target in it.
#pragma once

#include "fixture.h"
#include "motion/task_variables.h"
#include "scene/occupancy_map.h"

namespace primo::motion {

/// c1 and c2 on the table with the map of what a camera 2 m above sees of them, to 5 mm.
inline const scene::SceneEstimate& estimate() {
  static const scene::SceneEstimate estimate = [] {
    scene::SceneEstimate seen = request(1, hand_tuned()).scene;
    scene::PointCloud cloud;
    cloud.X_WC = pose(Eigen::Vector3d(0.8, 0, 2));
    for (double x = 0.55; x < 1.05; x += 0.005) {
      for (double y = -0.25; y < 0.25; y += 0.005) {
        Eigen::Vector3d p_W(x, y, 0.665);
        for (const auto& object : seen.objects) {
          if ((p_W - object.X_WO.translation()).head<2>().norm() < 0.0375) p_W.z() = 0.774;
        }
        cloud.points.push_back((p_W - cloud.X_WC.translation()).cast<float>());
      }
    }
    seen.octree = scene::OccupancyMap({cloud}, {{0.5, -0.3, 0.5}, {1.1, 0.3, 1.9}}, 0.01).to_bytes();
    return seen;
  }();
  return estimate;
}

inline const PlanningScene& scene() {
  static const PlanningScene scene = [] {
    auto made = PlanningScene::create(estimate(), {"grasp", "c1"}).value();
    EXPECT_TRUE(made.perceive(estimate()).ok());
    return made;
  }();
  return scene;
}

/// The same with c1 in the hand, to be placed on c2.
inline const PlanningScene& holding() {
  static const PlanningScene scene = [] {
    const HeldObject held{"c1", pose(Eigen::Vector3d(0.01, -0.02, 0.015), Eigen::Vector3d(1.2, 0.3, -0.4))};
    auto made = PlanningScene::create(estimate(), {"place", "c1", "c2"}, held).value();
    EXPECT_TRUE(made.perceive(estimate()).ok());
    return made;
  }();
  return scene;
}

inline constexpr double kStep = 4.0 / 64;  // s

inline Eigen::VectorXd value(const TaskVariable& variable, const Eigen::VectorXd& q, const Eigen::VectorXd& v,
                             double phase) {
  const auto kinematics = schunk().forward(q);
  Eigen::VectorXd phi(variable.size());
  variable.evaluate({q, kinematics, phase, v, kStep}, phi, nullptr);
  return phi;
}

inline Eigen::VectorXd value(const TaskVariable& variable, const Eigen::VectorXd& q, double phase) {
  return value(variable, q, Eigen::VectorXd::Zero(q.size()), phase);
}

using Names = std::map<std::string, std::string>;
using Numbers = std::map<std::string, double>;

inline std::unique_ptr<TaskVariable> make(const std::string& variable, const PlanningScene& in,
                                          const Numbers& parameters = {}, const Names& of = {}) {
  Task task;
  task.variable = variable;
  task.parameters = parameters;
  task.of = of;
  auto made = make_task_variable(task, schunk(), in);
  EXPECT_TRUE(made.ok()) << made.error().message;
  return std::move(made).value();
}

struct Compared {
  int columns = 0, kinks = 0, nonzero = 0;
};

/// Columns of J against central differences of f about x, to `tolerance` of 1 + their norm.
template <class F>
void compare(const std::string& label, const Eigen::VectorXd& x, const Jacobian& J, F&& f, Compared& counts,
             double tolerance = 2e-4) {
  constexpr double kDifference = 1e-6;
  const Eigen::VectorXd phi = f(x);
  for (int j = 0; j < x.size(); ++j) {
    const Eigen::VectorXd step = kDifference * Eigen::VectorXd::Unit(x.size(), j);
    const Eigen::VectorXd ahead = f(x + step), behind = f(x - step);
    // Hinges have kinks where one-sided slopes differ; the Jacobian is that of one side there.
    if ((ahead - 2 * phi + behind).cwiseAbs().maxCoeff() > 1e-8) {
      ++counts.kinks;
      continue;
    }
    ++counts.columns;
    counts.nonzero += J.col(j).norm() > 1e-6;
    ASSERT_LT((J.col(j) - (ahead - behind) / (2 * kDifference)).norm(), tolerance * (1 + J.col(j).norm()))
        << label << " joint " << j;
  }
}

}  // namespace primo::motion
