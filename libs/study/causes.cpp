#include "study/causes.h"

#include <algorithm>
#include <array>

namespace primo::study {
namespace {

using physics::Outcome;
using physics::Verdict;

/// A criterion of the path that is not met.
bool violates(const Verdict& verdict, const char* name) {
  return std::any_of(verdict.criteria.begin(), verdict.criteria.end(),
                     [&](const physics::Criterion& c) { return c.name == name && !c.met; });
}

/// Something stood upright before and, outside the hand, does not any more.
bool something_fell(const Verdict& verdict) {
  return std::any_of(verdict.before.begin(), verdict.before.end(), [&](const symbols::Literal& literal) {
    return literal.predicate == "upright" && !verdict.after.contains(literal) &&
           !verdict.after.contains({"inhand", literal.arguments});
  });
}

Cause of_path(const Verdict& verdict) {
  if (violates(verdict, "clearance")) return Cause::collision;
  if (violates(verdict, "target_clearance")) return Cause::hand_in_object;
  if (violates(verdict, "limit_margin")) return Cause::joint_limit;
  if (violates(verdict, "joint_speed")) return Cause::too_fast;
  return Cause::other;
}

Cause of_outcome(const Verdict& verdict) {
  switch (verdict.outcome) {
    case Outcome::no_contact:
      return Cause::no_contact;
    case Outcome::initial_penetration:
      return Cause::hand_in_object;
    case Outcome::not_opposed:
      return Cause::not_opposed;
    case Outcome::fell_at_release:
    case Outcome::fell_in_jiggle:
    case Outcome::contact_lost:
      return Cause::slipped;
    case Outcome::support_fell:
      return Cause::knocked_over;
    case Outcome::not_released:
    case Outcome::not_on:
      return Cause::not_on;
    default:
      return Cause::other;
  }
}

}  // namespace

Cause cause_of(const RolloutResult& result, bool executed) {
  const Verdict& verdict = result.verdict;
  if (executed ? verdict.final_pose_success : verdict.success) return Cause::none;
  if (verdict.outcome == Outcome::bad_plan) return Cause::plan_failed;
  if (verdict.outcome == Outcome::unstable) return Cause::unstable;
  if (!executed && verdict.final_pose_success) return of_path(verdict);
  if (executed && violates(verdict, "clearance")) return Cause::collision;
  if (executed && something_fell(verdict)) return Cause::knocked_over;
  if (verdict.outcome == Outcome::initial_penetration) return Cause::hand_in_object;
  if (verdict.position_error > kReached) return Cause::unreachable;
  if (something_fell(verdict)) return Cause::knocked_over;
  return of_outcome(verdict);
}

const char* description(Cause cause) {
  static constexpr std::array<const char*, 14> texts = {"success",
                                                        "no plan",
                                                        "the simulation diverged",
                                                        "collision with an obstacle or the table",
                                                        "the hand is inside its target",
                                                        "beyond a joint limit",
                                                        "too fast",
                                                        "ends away from its target",
                                                        "something was knocked over",
                                                        "the closed hand misses the object",
                                                        "held from one side only",
                                                        "slipped out of the hand",
                                                        "not at rest on its support",
                                                        "another cause"};
  return texts[static_cast<std::size_t>(cause)];
}

}  // namespace primo::study
