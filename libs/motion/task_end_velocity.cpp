// End velocity: the joint velocities; with profile final it brings the motion to rest.
#include "motion/task_variables.h"

namespace primo::motion {
namespace {

/// φ(q, v) = v, rad/s (n rows).
class EndVelocity final : public TaskVariable {
 public:
  explicit EndVelocity(const TaskSetup& setup) : robot_(setup.robot) {}
  int size() const override { return robot_.joints(); }
  bool moving() const override { return true; }
  void evaluate(const Configuration& at, Eigen::Ref<Eigen::VectorXd> phi, Jacobian* J) const override {
    phi = at.v;
    if (J) J->setZero();
  }
  void velocity_jacobian(const Configuration& /*at*/, Jacobian& J_v) const override { J_v.setIdentity(); }

 private:
  const robot::Robot& robot_;
};

}  // namespace

TaskVariableEntry end_velocity_task() {
  return {"end_velocity", "the joint velocities, rad/s", {}, {}, make_variable<EndVelocity>};
}

}  // namespace primo::motion
