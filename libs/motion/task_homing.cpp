// Homing: the configuration itself.
#include "motion/task_variables.h"

namespace primo::motion {
namespace {

/// φ(q) = q, rad: draws towards the target angles, zero by default. A row for each joint, or for those of the arm or
/// the hand alone: a shape of the hand to come with.
class Homing final : public TaskVariable {
 public:
  explicit Homing(const TaskSetup& setup) {
    const auto& joints = setup.of.at("joints");
    const int all = setup.robot.joints(), arm = setup.robot.arm_joints();
    first_ = joints == "hand" ? arm : 0;
    count_ = (joints == "arm" ? arm : all) - first_;
    whole_ = count_ == all;
  }
  int size() const override { return count_; }
  bool is_identity() const override { return whole_; }
  void evaluate(const Configuration& at, Eigen::Ref<Eigen::VectorXd> phi, Jacobian* J) const override {
    phi = at.q.segment(first_, count_);
    if (!J) return;
    J->setZero();
    J->middleCols(first_, count_).setIdentity();
  }

 private:
  int first_ = 0, count_ = 0;
  bool whole_ = true;
};

}  // namespace

TaskVariableEntry homing_task() {
  return {"homing",
          "the joint angles themselves, rad",
          {},
          {{"joints", "all", {"all", "arm", "hand"}, "whose angles"}},
          make_variable<Homing>};
}

}  // namespace primo::motion
