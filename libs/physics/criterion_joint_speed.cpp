#include <algorithm>

#include "physics/criteria.h"

namespace primo::physics {

CriterionEntry joint_speed_criterion() {
  return {"joint_speed", "rad/s", "largest speed of an arm joint", true, [](const Motion& motion) {
            const int arm = motion.robot.arm_joints();
            double value = 0;
            for (Eigen::Index t = 0; t + 1 < motion.q.rows(); ++t) {
              const auto step = motion.q.row(t + 1).head(arm) - motion.q.row(t).head(arm);
              value = std::max(value, step.cwiseAbs().maxCoeff() / motion.dt);
            }
            const double margin = motion.settings.max_joint_speed;
            return Criterion{"joint_speed", value, margin, value < margin};
          }};
}

}  // namespace primo::physics
