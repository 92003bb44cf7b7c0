// Joints that follow others: the linear equalities of an MJCF model, solved for the joints that a robot file lists.
#pragma once

#include <mujoco/mujoco.h>

#include <string>
#include <vector>

#include "core/result.h"

namespace primo::robot {

/// How an MJCF joint's value follows from q: offset + ratio · q[index]. index −1: it does not.
struct Drive {
  int index = -1;
  double offset = 0, ratio = 1;
};

/// Fills in the drives (by MJCF joint) of unlisted joints from the model's active equalities:
///   joint:  y − y₀ = a₀ + a₁ (x − x₀),   tendon: L₁ − L₁₀ = a₀ + a₁ (L₂ − L₂₀), L = Σ c_i q_i of fixed tendons,
/// ₀ the reference positions; x or L₂ may be absent. A follower may lead another. Error (Code::config), put after
/// `where`: couplings of higher degree, of two listed joints, to more than one listed joint; loops closed by connect,
/// weld or distance; tendons through sites that pull.
Status solve_couplings(const mjModel& model, const std::string& where, std::vector<Drive>& drives);

}  // namespace primo::robot
