// The paper's criteria of a motion (Sec. V): each a value against a margin. One file and one line of criteria() for
// each.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string_view>

#include "physics/path_clearance.h"
#include "physics/verdict.h"
#include "robot/robot.h"

namespace primo::physics {

/// A motion in a true scene. Row t of q is q_t, in rad; dt in s.
struct Motion {
  const robot::Robot& robot;
  const scene::Scenario& scenario;
  std::string target;  ///< the object to be grasped, or the held one to be placed
  const Eigen::MatrixXd& q;
  double dt = 0;
  int iterations = 0;  ///< of the planner
  const JudgeSettings& settings;
};

struct CriterionEntry {
  std::string_view name;
  std::string_view unit;
  std::string_view meaning;
  bool strict = false;  ///< whether a clean path must meet it
  /// Value, margin and whether it is met.
  Criterion (*evaluate)(const Motion&) = nullptr;
};

/// The table of all criteria.
std::span<const CriterionEntry> criteria();

/// Every criterion of a motion, in the order of the table.
std::vector<Criterion> evaluate_criteria(const Motion& motion);

CriterionEntry clearance_criterion();
CriterionEntry target_clearance_criterion();
CriterionEntry limit_margin_criterion();
CriterionEntry joint_speed_criterion();
CriterionEntry path_length_criterion();
CriterionEntry iterations_criterion();

/// What must stay apart: robot against table and other objects, arm against target; and hand against target. When the
/// target is held: robot against all that it does not hold, held object against all but its support; and held object
/// against its support.
std::vector<ClearancePair> clearance_pairs(const scene::Scenario& scenario, const std::string& target);
std::vector<ClearancePair> target_pairs(const scene::Scenario& scenario, const std::string& target);

}  // namespace primo::physics
