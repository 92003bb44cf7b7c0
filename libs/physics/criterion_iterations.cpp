#include "physics/criteria.h"

namespace primo::physics {

CriterionEntry iterations_criterion() {
  return {"iterations", "", "iterations the planner needed, accepted and rejected", false, [](const Motion& motion) {
            // Reported, not required: the published planner settings allow 100.
            constexpr double kMany = 100;
            const auto value = static_cast<double>(motion.iterations);
            return Criterion{"iterations", value, kMany, value <= kMany};
          }};
}

}  // namespace primo::physics
