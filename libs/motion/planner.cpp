#include "motion/planner.h"

#include "motion/planner_gauss_newton.h"

namespace primo::motion {

const std::vector<PlannerEntry>& planners() {
  static const GaussNewtonPlanner gauss_newton;
  static const std::vector<PlannerEntry> table = {
      {"gauss_newton", "Levenberg–Marquardt on the banded Gauss–Newton system", &gauss_newton},
  };
  return table;
}

Plan plan(const robot::Robot& robot, const PlanRequest& request) {
  std::string known;
  for (const auto& entry : planners()) {
    if (entry.name == request.primitive.solver) return entry.planner->plan(robot, request);
    known += (known.empty() ? "" : ", ") + entry.name;
  }
  Plan refused;
  refused.status = PlanStatus::bad_input;
  refused.reason = "solver: no planner '" + request.primitive.solver + "'; there are " + known;
  return refused;
}

}  // namespace primo::motion
