// Alignment: axes of a frame against an axis of an object or of the world.
#include "motion/task_frames.h"
#include "motion/task_variables.h"

namespace primo::motion {
namespace {

/// φ_i(q) = a_i(q) · b(q), a cosine (one row for each letter of `axis`): 0 where the frame's axis a_i is perpendicular
/// to the object's axis b, ±1 where they are parallel. By default the grasp frame's opposition axis x against the
/// target's z: 0 when thumb and fingers close across it. Axes xy against the world's z: 0 and 0 when the frame stands
/// upright.
class Alignment final : public TaskVariable {
 public:
  Alignment(const robot::Robot& robot, const robot::Frame& frame, const std::string& axes, const robot::Frame& object,
            int object_axis)
      : robot_(robot),
        body_(frame.body),
        axes_F_(3, static_cast<Eigen::Index>(axes.size())),
        object_body_(object.body),
        axis_O_(object.X_BF.linear().col(object_axis)) {
    for (std::size_t i = 0; i < axes.size(); ++i) {
      axes_F_.col(static_cast<Eigen::Index>(i)) = frame.X_BF.linear().col(axes[i] - 'x');
    }
  }
  int size() const override { return static_cast<int>(axes_F_.cols()); }
  void evaluate(const Configuration& at, Eigen::Ref<Eigen::VectorXd> phi, Jacobian* J) const override {
    const Eigen::Vector3d b_W = at.kinematics.X_WB[object_body_].linear() * axis_O_;
    if (J) J->setZero();
    for (int i = 0; i < size(); ++i) {
      const Eigen::Vector3d a_W = at.kinematics.X_WB[body_].linear() * axes_F_.col(i);
      phi[i] = a_W.dot(b_W);
      if (!J) continue;
      robot_.add_vector_gradient(at.kinematics, body_, a_W, b_W, J->row(i));
      robot_.add_vector_gradient(at.kinematics, object_body_, b_W, a_W, J->row(i));
    }
  }

 private:
  const robot::Robot& robot_;
  const int body_;
  Eigen::Matrix3Xd axes_F_;  // in the frame's body
  const int object_body_;
  const Eigen::Vector3d axis_O_;  // in the object's body
};

Result<std::unique_ptr<TaskVariable>> create(const TaskSetup& setup) {
  PRIMO_ASSIGN(const auto frame, find_frame(setup.robot, setup.scene, setup.of.at("frame")));
  robot::Frame object;
  if (setup.of.at("object") != "world") {
    PRIMO_ASSIGN(const auto found, find_object(setup.robot, setup.scene, setup.of.at("object")));
    object = found.frame;
  }
  const int object_axis = setup.of.at("object_axis")[0] - 'x';
  return std::unique_ptr<TaskVariable>(new Alignment(setup.robot, frame, setup.of.at("axis"), object, object_axis));
}

}  // namespace

TaskVariableEntry alignment_task() {
  return {"alignment",
          "axes of a frame · an axis of an object or of the world",
          {},
          {{"frame", "grasp", {}, kFrameHelp},
           {"axis", "x", {"x", "y", "z", "xy", "xz", "yz", "xyz"}, "the frame's axes, a row each"},
           {"object", "target", {}, std::string(kObjectHelp) + ", or world"},
           {"object_axis", "z", {"x", "y", "z"}, "the axis of the object"}},
          create};
}

}  // namespace primo::motion
