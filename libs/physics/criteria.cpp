#include "physics/criteria.h"

#include <array>

namespace primo::physics {

std::span<const CriterionEntry> criteria() {
  static const std::array table = {clearance_criterion(),   target_clearance_criterion(), limit_margin_criterion(),
                                   joint_speed_criterion(), path_length_criterion(),      iterations_criterion()};
  return table;
}

std::vector<Criterion> evaluate_criteria(const Motion& motion) {
  std::vector<Criterion> all;
  for (const auto& entry : criteria()) all.push_back(entry.evaluate(motion));
  return all;
}

}  // namespace primo::physics
