// Position: the grasp frame's origin relative to the target's centre.
#include "motion/task_variables.h"

namespace primo::motion {
namespace {

/// φ(q) = p_WG(q) − p_WO in W, m (3 rows): paper, II.B, "reach target".
class Position final : public TaskVariable {
 public:
  explicit Position(const TaskSetup& setup) : robot_(setup.robot), p_WO_(setup.scene.target.X_WB.translation()) {}
  int size() const override { return 3; }
  void evaluate(const Configuration& at, Eigen::Ref<Eigen::VectorXd> phi, Jacobian* J) const override {
    const auto& frame = robot_.grasp_frame();
    const Eigen::Vector3d p_WG = at.kinematics.X_WB[frame.body] * frame.X_BF.translation();
    phi = p_WG - p_WO_;
    if (!J) return;
    J->setZero();
    for (int i = 0; i < 3; ++i) {
      robot_.add_point_gradient(at.kinematics, frame.body, p_WG, Eigen::Vector3d::Unit(i), J->row(i));
    }
  }

 private:
  const robot::Robot& robot_;
  const Eigen::Vector3d p_WO_;
};

}  // namespace

TaskVariableEntry position_task() {
  return {"position",
          "grasp frame's origin relative to the target's centre, m",
          {},
          [](const TaskSetup& setup) -> std::unique_ptr<TaskVariable> { return std::make_unique<Position>(setup); }};
}

}  // namespace primo::motion
