#include "physics/criteria.h"

namespace primo::physics {

CriterionEntry path_length_criterion() {
  return {"path_length", "rad", "length of the path in joint space", false, [](const Motion& motion) {
            // Reported, not required: a path is long when its joints together travel more than two full turns.
            constexpr double kLong = 12.566370614359172;
            double value = 0;
            for (Eigen::Index t = 0; t + 1 < motion.q.rows(); ++t)
              value += (motion.q.row(t + 1) - motion.q.row(t)).norm();
            return Criterion{"path_length", value, kLong, value <= kLong};
          }};
}

}  // namespace primo::physics
