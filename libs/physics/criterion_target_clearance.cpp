#include <algorithm>
#include <cmath>

#include "physics/criteria.h"

namespace primo::physics {
namespace {

/// Of a held object to its support: as it is in the late part, where it may touch; before that it must be clear, so its
/// distance counts less by as much as the margin allows later.
double held_clearance(const Motion& motion) {
  ClearanceQuery query(motion.robot, target_pairs(motion.scenario, motion.target),
                       held_shape(motion.robot, motion.scenario));
  const Eigen::Index late = late_row(motion.q);
  const double early = query.over(motion.q.topRows(late + 1));
  return std::min(early + motion.settings.target_margin, query.over(motion.q.bottomRows(motion.q.rows() - late)));
}

}  // namespace

Eigen::Index late_row(const Eigen::MatrixXd& q) {
  // The published place lowers in the last eighth; a little more time for motions that come down earlier.
  constexpr double kLate = 0.85;
  return static_cast<Eigen::Index>(std::ceil(kLate * static_cast<double>(q.rows() - 1)));
}

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
          "object to its support",
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
