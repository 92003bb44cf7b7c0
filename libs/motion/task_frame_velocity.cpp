// Frame velocity: how fast a frame's origin moved in the last step.
#include "motion/task_frames.h"
#include "motion/task_variables.h"

namespace primo::motion {
namespace {

/// φ(q, v) = (p_WF(q) − p_WF(q − τ v)) / τ in W, m/s (3 rows): the exact difference quotient, as q − τ v = q_{t−1}.
/// With the point's Jacobian J,
///   ∂φ/∂q|_v = (J(q) − J(q − τ v)) / τ,   ∂φ/∂v|_q = J(q − τ v).
class FrameVelocity final : public TaskVariable {
 public:
  FrameVelocity(const robot::Robot& robot, const robot::Frame& frame) : robot_(robot), frame_(frame) {}
  int size() const override { return 3; }
  bool moving() const override { return true; }
  void evaluate(const Configuration& at, Eigen::Ref<Eigen::VectorXd> phi, Jacobian* J) const override {
    const robot::Kinematics before = kinematics_before(at);
    phi = (origin(at.kinematics) - origin(before)) / at.dt;
    if (!J) return;
    J->setZero();
    add_jacobian(at.kinematics, 1 / at.dt, *J);
    add_jacobian(before, -1 / at.dt, *J);
  }
  void velocity_jacobian(const Configuration& at, Jacobian& J_v) const override {
    J_v.setZero();
    add_jacobian(kinematics_before(at), 1, J_v);
  }

 private:
  robot::Kinematics kinematics_before(const Configuration& at) const { return robot_.forward(at.q - at.dt * at.v); }
  Eigen::Vector3d origin(const robot::Kinematics& kinematics) const {
    return kinematics.X_WB[frame_.body] * frame_.X_BF.translation();
  }
  void add_jacobian(const robot::Kinematics& kinematics, double scale, Jacobian& J) const {
    const Eigen::Vector3d p_W = origin(kinematics);
    for (int i = 0; i < 3; ++i) {
      robot_.add_point_gradient(kinematics, frame_.body, p_W, scale * Eigen::Vector3d::Unit(i), J.row(i));
    }
  }

  const robot::Robot& robot_;
  const robot::Frame frame_;
};

Result<std::unique_ptr<TaskVariable>> create(const TaskSetup& setup) {
  PRIMO_ASSIGN(const auto frame, find_frame(setup.robot, setup.scene, setup.of.at("frame")));
  return std::unique_ptr<TaskVariable>(new FrameVelocity(setup.robot, frame));
}

}  // namespace

TaskVariableEntry frame_velocity_task() {
  return {"frame_velocity",
          "velocity of a frame's origin over the last step, m/s",
          {},
          {{"frame", "grasp", {}, kFrameHelp}},
          create};
}

}  // namespace primo::motion
