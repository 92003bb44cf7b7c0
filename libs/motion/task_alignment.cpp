// Alignment: the hand's opposition direction against the target's axis.
#include "motion/task_variables.h"

namespace primo::motion {
namespace {

/// φ(q) = x_G(q) · z_O (1 row): 0 when thumb and fingers close across the target's axis. x_G is the grasp frame's
/// opposition axis.
class Alignment final : public TaskVariable {
 public:
  explicit Alignment(const TaskSetup& setup) : robot_(setup.robot), axis_W_(setup.scene.target.X_WB.linear().col(2)) {}
  int size() const override { return 1; }
  void evaluate(const Configuration& at, Eigen::Ref<Eigen::VectorXd> phi, Jacobian* J) const override {
    const auto& frame = robot_.grasp_frame();
    const Eigen::Vector3d x_W = at.kinematics.X_WB[frame.body].linear() * frame.X_BF.linear().col(0);
    phi[0] = x_W.dot(axis_W_);
    if (!J) return;
    J->setZero();
    robot_.add_vector_gradient(at.kinematics, frame.body, x_W, axis_W_, J->row(0));
  }

 private:
  const robot::Robot& robot_;
  const Eigen::Vector3d axis_W_;
};

}  // namespace

TaskVariableEntry alignment_task() {
  return {"alignment",
          "opposition direction of the hand · the target's axis",
          {},
          [](const TaskSetup& setup) -> std::unique_ptr<TaskVariable> { return std::make_unique<Alignment>(setup); }};
}

}  // namespace primo::motion
