// Joints that follow others: the linear equalities of an MJCF model, solved for the joints that a robot file lists.
#pragma once

#include <mujoco/mujoco.h>

#include <memory>
#include <string>
#include <vector>

#include "core/result.h"
#include "robot/curve.h"

namespace primo::robot {

/// How an MJCF joint's value follows from q: offset + ratio · q[index], or curve(q[index]) where there is a curve
/// (then ratio is its steepest slope). index −1: it does not.
struct Drive {
  int index = -1;
  double offset = 0, ratio = 1;
  std::shared_ptr<const Curve> curve = nullptr;
};

/// Fills in the drives (by MJCF joint) of unlisted joints from the model's active equalities:
///   joint:  y − y₀ = a₀ + a₁ (x − x₀),   tendon: L₁ − L₁₀ = a₀ + a₁ (L₂ − L₂₀), L = Σ c_i q_i of fixed tendons,
/// ₀ the reference positions; x or L₂ may be absent. A follower may lead another. Error (Code::config), put after
/// `where`: couplings of higher degree, of two listed joints, to more than one listed joint; tendons through sites that
/// pull. What connect and weld equalities couple is left to close_loops() (loops.h).
Status solve_couplings(const mjModel& model, const std::string& where, std::vector<Drive>& drives);

}  // namespace primo::robot
