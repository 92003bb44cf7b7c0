#include "physics/criteria.h"

namespace primo::physics {

std::vector<ClearancePair> clearance_pairs(const scene::Scenario& scenario, const std::string& target) {
  std::vector<ClearancePair> pairs;
  for (auto& obstacle : obstacles(scenario, target)) pairs.push_back({std::move(obstacle), RobotPart::all});
  if (scenario.holds(target)) {
    const std::string support = scenario.action.size() > 2 ? scenario.action[2] : std::string();
    for (auto& obstacle : obstacles(scenario, target)) {
      if (obstacle.name != support) pairs.push_back({std::move(obstacle), RobotPart::held});
    }
  } else if (const auto* object = scenario.object(target)) {
    pairs.push_back({{object->name, object->X_WO(), object->shape()}, RobotPart::arm});
  }
  return pairs;
}

CriterionEntry clearance_criterion() {
  return {"clearance", "m",
          "smallest distance of the robot and of what it holds to table and obstacles, of the arm also to the target",
          true, [](const Motion& motion) {
            ClearanceQuery query(motion.robot, clearance_pairs(motion.scenario, motion.target),
                                 held_shape(motion.robot, motion.scenario));
            const double value = query.over(motion.q), margin = motion.settings.clearance_margin;
            return Criterion{"clearance", value, margin, value > margin};
          }};
}

}  // namespace primo::physics
