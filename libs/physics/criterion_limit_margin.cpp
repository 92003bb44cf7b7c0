#include <algorithm>
#include <limits>

#include "physics/criteria.h"

namespace primo::physics {

CriterionEntry limit_margin_criterion() {
  return {"limit_margin", "rad", "smallest distance of a joint to its limits; a slide's range counts as half a turn",
          true, [](const Motion& motion) {
            // Linear between steps, so the steps are enough. A start exactly on a limit may carry rounding.
            constexpr double kRounding = 1e-6;
            double value = std::numeric_limits<double>::infinity();
            for (Eigen::Index t = 0; t < motion.q.rows(); ++t) {
              for (int i = 0; i < motion.robot.joints(); ++i) {
                const double q = motion.q(t, i);
                const double inside = std::min(q - motion.robot.lower()[i], motion.robot.upper()[i] - q);
                value = std::min(value, inside / motion.robot.radian(i));
              }
            }
            const double margin = motion.settings.limit_margin;
            return Criterion{"limit_margin", value, margin, value >= margin - kRounding};
          }};
}

}  // namespace primo::physics
