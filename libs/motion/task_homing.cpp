// Homing: the configuration itself.
#include "motion/task_variables.h"

namespace primo::motion {
namespace {

/// φ(q) = q, rad (n rows): draws towards the target angles, zero by default.
class Homing final : public TaskVariable {
 public:
  explicit Homing(const TaskSetup& setup) : robot_(setup.robot) {}
  int size() const override { return robot_.joints(); }
  bool is_identity() const override { return true; }
  void evaluate(const Configuration& at, Eigen::Ref<Eigen::VectorXd> phi, Jacobian* J) const override {
    phi = at.q;
    if (J) J->setIdentity();
  }

 private:
  const robot::Robot& robot_;
};

}  // namespace

TaskVariableEntry homing_task() {
  return {"homing", "the joint angles themselves, rad", {}, {}, make_variable<Homing>};
}

}  // namespace primo::motion
