#include "physics/criteria.h"
#include "physics/set_down.h"

namespace primo::physics {
namespace {

/// Of a held object to its support where they may touch; before that they must be apart, so the distance counts less
/// by what the margin allows later and by the resolution of a path's distance.
double held_clearance(const Motion& motion) {
  ClearanceQuery query(motion.robot, target_pairs(motion.scenario, motion.target),
                       held_shape(motion.robot, motion.scenario));
  const SetDown parts = set_down(motion.robot, motion.scenario, motion.settings, motion.q);
  // The distance before is of interest only where it decides.
  const double touching = query.over(parts.contact);
  const double deduction = ClearanceQuery::kTolerance - motion.settings.target_margin;
  return query.over(parts.approach, touching + deduction) - deduction;
}

}  // namespace

std::vector<ClearancePair> target_pairs(const scene::Scenario& scenario, const std::string& target) {
  if (scenario.holds(target)) {
    std::vector<ClearancePair> pairs;
    const std::string support = scenario.action.size() > 2 ? scenario.action[2] : std::string();
    for (auto& obstacle : obstacles(scenario, target)) {
      if (obstacle.name == support) pairs.push_back({std::move(obstacle), RobotPart::held});
    }
    return pairs;
  }
  const auto* object = scenario.object(target);
  if (!object) return {};
  return {{{object->name, object->X_WO(), object->shape()}, RobotPart::hand}};
}

CriterionEntry target_clearance_criterion() {
  return {"target_clearance", "m",
          "smallest distance of the hand to the target: a hand that sweeps through it would knock it over; of a held "
          "object to its support, which it may touch only where it comes down",
          true, [](const Motion& motion) {
            const double margin = motion.settings.target_margin;
            double value = 0;
            if (motion.scenario.holds(motion.target)) {
              value = held_clearance(motion);
            } else {
              ClearanceQuery query(motion.robot, target_pairs(motion.scenario, motion.target));
              value = query.over(motion.q);
            }
            return Criterion{"target_clearance", value, margin, value > margin};
          }};
}

}  // namespace primo::physics
