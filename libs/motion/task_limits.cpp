// Limits: how far joints are inside a margin of their limits.
#include "motion/task_variables.h"

namespace primo::motion {
namespace {

/// φ(q) = Σ_i max(0, lower_i + margin − q_i) + max(0, q_i − upper_i + margin), rad (1 row). A slide's whole range
/// counts as half a turn (Robot::radian), margin included.
class Limits final : public TaskVariable {
 public:
  explicit Limits(const TaskSetup& setup) : robot_(setup.robot), margin_(setup.parameters.at("margin")) {}
  int size() const override { return 1; }
  void evaluate(const Configuration& at, Eigen::Ref<Eigen::VectorXd> phi, Jacobian* J) const override {
    phi[0] = 0;
    if (J) J->setZero();
    for (int i = 0; i < robot_.joints(); ++i) {
      const double radian = robot_.radian(i), margin = margin_ * radian;
      const double below = robot_.lower()[i] + margin - at.q[i], above = at.q[i] - robot_.upper()[i] + margin;
      if (below > 0) {
        phi[0] += below / radian;
        if (J) (*J)(0, i) -= 1 / radian;
      }
      if (above > 0) {
        phi[0] += above / radian;
        if (J) (*J)(0, i) += 1 / radian;
      }
    }
  }

 private:
  const robot::Robot& robot_;
  const double margin_;
};

}  // namespace

TaskVariableEntry limits_task() {
  return {"limits",
          "summed angle by which joints are nearer than the margin to their limits, rad",
          {{"margin", 0.1, 0, 3, "rad, the distance from which a limit counts"}},
          {},
          make_variable<Limits>};
}

}  // namespace primo::motion
