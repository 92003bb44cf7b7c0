// Finger distance: how near each distal phalanx is to an object's surface.
#include <algorithm>

#include "motion/task_frames.h"
#include "motion/task_variables.h"
#include "robot/distance.h"

namespace primo::motion {
namespace {

/// φ_i(q) = max(0, 1 − d_i / margin), one row a finger: 0 beyond the margin, 1 at touch, more inside. d_i is the signed
/// distance of the whole distal phalanx to the object, the target by default.
class FingerDistance final : public TaskVariable {
 public:
  FingerDistance(const TaskSetup& setup, const ObjectFrame& object)
      : robot_(setup.robot), object_(object), margin_(setup.parameters.at("margin")) {}
  int size() const override { return static_cast<int>(robot_.fingertips().size()); }
  void evaluate(const Configuration& at, Eigen::Ref<Eigen::VectorXd> phi, Jacobian* J) const override {
    if (J) J->setZero();
    const Pose X_WO = robot_.pose(at.kinematics, object_.frame);
    for (int i = 0; i < size(); ++i) {
      phi[i] = 0;
      const auto& link = robot_.link_shapes()[robot_.fingertips()[i].link_shape];
      const Eigen::Vector3d centre = at.kinematics.X_WB[link.body] * link.X_BG.translation();
      const double reach = robot::bounding_radius(link.shape) + object_.body->bounding_radius + margin_;
      if ((centre - X_WO.translation()).squaredNorm() > reach * reach) continue;
      const auto d = robot::distance(link.shape, robot_.pose(at.kinematics, link), object_.body->shape, X_WO);
      phi[i] = std::max(0.0, 1 - d.distance / margin_);
      if (J && phi[i] > 0) {
        robot_.add_point_gradient(at.kinematics, link.body, d.point_a, -d.gradient / margin_, J->row(i));
        robot_.add_point_gradient(at.kinematics, object_.frame.body, d.point_a, d.gradient / margin_, J->row(i));
      }
    }
  }

 private:
  const robot::Robot& robot_;
  const ObjectFrame object_;
  const double margin_;
};

Result<std::unique_ptr<TaskVariable>> create(const TaskSetup& setup) {
  PRIMO_ASSIGN(const auto object, find_object(setup.robot, setup.scene, setup.of.at("object")));
  return std::unique_ptr<TaskVariable>(new FingerDistance(setup, object));
}

}  // namespace

TaskVariableEntry finger_distance_task() {
  return {"finger_distance",
          "proximity 1 − d/margin of each distal phalanx to an object; 1 is touch",
          {{"margin", 0.05, 1e-4, 1, "m, the distance from which it counts"}},
          {{"object", "target", {}, kObjectHelp}},
          create};
}

}  // namespace primo::motion
