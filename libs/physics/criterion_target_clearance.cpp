#include "physics/criteria.h"

namespace primo::physics {

std::vector<ClearancePair> target_pairs(const scene::Scenario& scenario, const std::string& target) {
  const auto* object = scenario.object(target);
  if (!object) return {};
  return {{{object->name, object->X_WO(), object->shape()}, RobotPart::hand}};
}

CriterionEntry target_clearance_criterion() {
  return {"target_clearance", "m",
          "smallest distance of the hand to the target: a hand that sweeps through it would knock it over", true,
          [](const Motion& motion) {
            ClearanceQuery query(motion.robot, target_pairs(motion.scenario, motion.target));
            const double value = query.over(motion.q), margin = motion.settings.target_margin;
            return Criterion{"target_clearance", value, margin, value > margin};
          }};
}

}  // namespace primo::physics
