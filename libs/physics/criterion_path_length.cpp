#include "physics/criteria.h"

namespace primo::physics {

CriterionEntry path_length_criterion() {
  return {"path_length", "rad", "length of the path in joint space; a slide's range counts as half a turn", false,
          [](const Motion& motion) {
            // Reported, not required: a path is long when its joints together travel more than two full turns.
            constexpr double kLong = 12.566370614359172;
            Eigen::RowVectorXd per_radian(motion.q.cols());
            for (int i = 0; i < motion.robot.joints(); ++i) per_radian[i] = 1 / motion.robot.radian(i);
            double value = 0;
            for (Eigen::Index t = 0; t + 1 < motion.q.rows(); ++t)
              value += (motion.q.row(t + 1) - motion.q.row(t)).cwiseProduct(per_radian).norm();
            return Criterion{"path_length", value, kLong, value <= kLong};
          }};
}

}  // namespace primo::physics
