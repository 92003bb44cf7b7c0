#include <algorithm>
#include <cmath>

#include "physics/criteria.h"

namespace primo::physics {

namespace {

/// What of joint i's speed counts as 1 rad/s. The margin is meant for joints that reach the published robot's 2 rad/s:
/// slower ones, and slides, count in proportion to the speed their robot file allows.
double speed_unit(const robot::Robot& robot, int i) {
  constexpr double kPublished = 2.0;  // rad/s
  const double own = robot.file().arm[static_cast<std::size_t>(i)].max_speed / kPublished;
  return robot.slides(i) ? own : std::min(own, 1.0);
}

}  // namespace

CriterionEntry joint_speed_criterion() {
  return {"joint_speed", "rad/s", "largest speed of an arm joint; of slow joints and slides in proportion to their own",
          true, [](const Motion& motion) {
            double value = 0;
            for (int i = 0; i < motion.robot.arm_joints(); ++i) {
              const double unit = speed_unit(motion.robot, i);
              for (Eigen::Index t = 0; t + 1 < motion.q.rows(); ++t)
                value = std::max(value, std::abs(motion.q(t + 1, i) - motion.q(t, i)) / motion.dt / unit);
            }
            const double margin = motion.settings.max_joint_speed;
            return Criterion{"joint_speed", value, margin, value < margin};
          }};
}

}  // namespace primo::physics
