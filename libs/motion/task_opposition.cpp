// Opposition: the thumb's pad (of a hand without one, the first fingertip's) against each other finger's.
#include <algorithm>

#include "motion/task_variables.h"

namespace primo::motion {
namespace {

/// φ_i(q) = n_thumb · n_i, one row for each finger that is not the thumb: −1 when the pads face each other. In a hand
/// without a thumb the first fingertip takes its place. Rows after the first count from phase `others_from` on.
class Opposition final : public TaskVariable {
 public:
  explicit Opposition(const TaskSetup& setup) : robot_(setup.robot), others_from_(setup.parameters.at("others_from")) {
    const auto& tips = robot_.fingertips();
    const auto thumb = std::find_if(tips.begin(), tips.end(), [](const auto& tip) { return tip.thumb; });
    if (thumb != tips.end()) thumb_ = static_cast<int>(thumb - tips.begin());
    for (int i = 0; i < static_cast<int>(tips.size()); ++i) {
      if (i != thumb_) others_.push_back(i);
    }
  }
  int size() const override { return static_cast<int>(others_.size()); }
  bool counts(int row, double phase) const override { return row == 0 || phase >= others_from_ - 1e-9; }
  void evaluate(const Configuration& at, Eigen::Ref<Eigen::VectorXd> phi, Jacobian* J) const override {
    if (J) J->setZero();
    const Eigen::Vector3d n_thumb = normal(at, thumb_);
    for (int i = 0; i < size(); ++i) {
      const Eigen::Vector3d n = normal(at, others_[i]);
      phi[i] = n_thumb.dot(n);
      if (!J) continue;
      robot_.add_vector_gradient(at.kinematics, robot_.fingertips()[thumb_].frame.body, n_thumb, n, J->row(i));
      robot_.add_vector_gradient(at.kinematics, robot_.fingertips()[others_[i]].frame.body, n, n_thumb, J->row(i));
    }
  }

 private:
  Eigen::Vector3d normal(const Configuration& at, int tip) const {
    const auto& frame = robot_.fingertips()[tip].frame;
    return at.kinematics.X_WB[frame.body].linear() * frame.X_BF.linear().col(2);
  }

  const robot::Robot& robot_;
  const double others_from_;
  int thumb_ = 0;
  std::vector<int> others_;
};

}  // namespace

TaskVariableEntry opposition_task() {
  return {"opposition",
          "normal of the thumb's pad (without a thumb: the first fingertip's) · normal of each other finger's pad",
          {{"others_from", 1.0, 0, 1, "phase from which fingers after the first count"}},
          {},
          make_variable<Opposition>};
}

}  // namespace primo::motion
