// Orientation: the rotation from an object's frame to a frame of the hand.
#include <cmath>

#include "motion/rotation_vector.h"
#include "motion/task_frames.h"
#include "motion/task_variables.h"

namespace primo::motion {
namespace {

/// φ(q) = log(R), rad (3 rows): the rotation vector of R = (R_WO(q) R_OT)ᵀ R_WF(q), R_OT by roll, pitch and yaw; 0
/// where the frame F is turned as T. With ω_F, ω_O the angular velocities in W and J_r⁻¹ the inverse right Jacobian of
/// SO(3),
///   ∂φ/∂q = J_r⁻¹(φ) R_WFᵀ (ω_F − ω_O),
/// as R_WF · exp(δ) turns log(R) by J_r⁻¹ δ (Chirikjian, Stochastic Models, Information Theory, and Lie Groups
/// 2, 10.86). |φ| ≤ π; finite there too, where φ and −φ are the same rotation and φ jumps.
class Orientation final : public TaskVariable {
 public:
  Orientation(const robot::Robot& robot, const robot::Frame& frame, const robot::Frame& target)
      : robot_(robot), frame_(frame), target_(target) {}
  int size() const override { return 3; }
  void evaluate(const Configuration& at, Eigen::Ref<Eigen::VectorXd> phi, Jacobian* J) const override {
    const Eigen::Matrix3d R_WF = at.kinematics.X_WB[frame_.body].linear() * frame_.X_BF.linear();
    const Eigen::Matrix3d R_WT = at.kinematics.X_WB[target_.body].linear() * target_.X_BF.linear();
    const Eigen::Vector3d rotation = rotation_vector(R_WT.transpose() * R_WF);
    phi = rotation;
    if (!J) return;
    J->setZero();
    const Eigen::Matrix3d M = inverse_right_jacobian(rotation) * R_WF.transpose();
    for (int i = 0; i < 3; ++i) {
      robot_.add_angular_gradient(at.kinematics, frame_.body, M.row(i), J->row(i));
      robot_.add_angular_gradient(at.kinematics, target_.body, -M.row(i), J->row(i));
    }
  }

 private:
  const robot::Robot& robot_;
  const robot::Frame frame_, target_;
};

Result<std::unique_ptr<TaskVariable>> create(const TaskSetup& setup) {
  PRIMO_ASSIGN(const auto frame, find_frame(setup.robot, setup.scene, setup.of.at("frame")));
  robot::Frame target;
  if (setup.of.at("object") != "world") {
    PRIMO_ASSIGN(const auto found, find_object(setup.robot, setup.scene, setup.of.at("object")));
    target = found.frame;
  }
  const auto& p = setup.parameters;
  target.X_BF = target.X_BF * pose(Eigen::Vector3d::Zero(), {p.at("roll"), p.at("pitch"), p.at("yaw")});
  return std::unique_ptr<TaskVariable>(new Orientation(setup.robot, frame, target));
}

}  // namespace

TaskVariableEntry orientation_task() {
  return {"orientation",
          "rotation vector of a frame relative to an object's frame, rad",
          {{"roll", 0, -4, 4, "rad, about the object's x; of the wanted frame in the object's"},
           {"pitch", 0, -4, 4, "rad, about the object's y, after roll"},
           {"yaw", 0, -4, 4, "rad, about the object's z, after pitch"}},
          {{"frame", "grasp", {}, kFrameHelp}, {"object", "target", {}, std::string(kObjectHelp) + ", or world"}},
          create};
}

}  // namespace primo::motion
