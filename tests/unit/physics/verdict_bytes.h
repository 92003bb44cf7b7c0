// A verdict as bytes, for tests of "the same, bit for bit".
#pragma once

#include <string>

#include "physics/verdict.h"

namespace primo::physics::testing {

/// All that a verdict says, bit for bit.
inline std::string bytes(const Verdict& v) {
  std::string text = std::to_string(v.success) + std::to_string(v.final_pose_success) + std::to_string(v.path_clean) +
                     config::enum_name(v.outcome) + v.reason + std::to_string(v.steps);
  const auto add = [&](double value) { text.append(reinterpret_cast<const char*>(&value), sizeof value); };
  for (const double value : {v.score, v.displacement, v.survival, v.position_error, v.clearance, v.target_clearance,
                             v.limit_margin, v.max_speed, v.path_length}) {
    add(value);
  }
  for (const auto& criterion : v.criteria) text += criterion.name, add(criterion.value), add(criterion.margin);
  for (const auto& literal : v.before) text += literal.text();
  for (const auto& literal : v.after) text += literal.text();
  for (const auto& name : v.objects) text += name;
  for (const auto& row : v.survivals) {
    text += std::to_string(row.held) + "/" + std::to_string(row.seeds);
    for (const double value : {row.amplitude, row.survival, row.displacement}) add(value);
  }
  for (const auto& contact : v.contacts) {
    text += contact.first + contact.second;
    for (const double value : {contact.begin, contact.end, contact.peak_force}) add(value);
  }
  return text + std::to_string(v.unlisted_contacts);
}

}  // namespace primo::physics::testing
