// Why a rollout failed, from its verdict alone.
#pragma once

#include "study/backend.h"

namespace primo::study {

/// In the order in which they are looked for: the first that applies is the cause.
enum class Cause {
  none,            ///< it did not fail
  plan_failed,     ///< no motion, or one that the judge refuses
  unstable,        ///< the simulation diverged
  collision,       ///< the path touches an obstacle or the table
  hand_in_object,  ///< the hand is inside its target, along the path or at its end
  joint_limit,
  too_fast,
  unreachable,   ///< the motion ends away from its target
  knocked_over,  ///< something that stood before lies there afterwards
  no_contact,    ///< the closed hand misses the object
  not_opposed,   ///< it touches, but not from both sides
  slipped,       ///< it was in the hand and came out of it
  not_on,        ///< let go, but not at rest on its support
  other
};

/// Beyond this distance of grasp centre and object at the end (of the held object and its place), a motion is said not
/// to have reached its target, m.
inline constexpr double kReached = 0.03;

/// @param executed whether the verdict is of Mode::execute: then the path counts only where physics lets it.
Cause cause_of(const RolloutResult& result, bool executed);

/// For people: "the hand is inside its target".
const char* description(Cause cause);

}  // namespace primo::study

template <>
struct primo::config::EnumNames<primo::study::Cause> {
  static constexpr std::array<std::string_view, 14> names = {
      "none",        "plan_failed",  "unstable",   "collision",   "hand_in_object", "joint_limit", "too_fast",
      "unreachable", "knocked_over", "no_contact", "not_opposed", "slipped",        "not_on",      "other"};
};
