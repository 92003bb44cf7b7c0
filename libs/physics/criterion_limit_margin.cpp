#include <algorithm>
#include <limits>

#include "physics/criteria.h"

namespace primo::physics {

CriterionEntry limit_margin_criterion() {
  return {"limit_margin", "rad", "smallest distance of a joint to its limits", true, [](const Motion& motion) {
            // Linear between steps, so the steps are enough. A start exactly on a limit may carry rounding.
            constexpr double kRounding = 1e-6;
            double value = std::numeric_limits<double>::infinity();
            for (Eigen::Index t = 0; t < motion.q.rows(); ++t) {
              const Eigen::VectorXd q = motion.q.row(t).transpose();
              value = std::min({value, (q - motion.robot.lower()).minCoeff(), (motion.robot.upper() - q).minCoeff()});
            }
            const double margin = motion.settings.limit_margin;
            return Criterion{"limit_margin", value, margin, value >= margin - kRounding};
          }};
}

}  // namespace primo::physics
