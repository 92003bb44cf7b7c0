#include "study/causes.h"

#include <gtest/gtest.h>

#include <set>

#include "synthetic.h"

namespace primo::study {
namespace {

using physics::Outcome;

RolloutResult failed(Outcome outcome, double position_error = 0) {
  auto result = test::perfect_grasp();
  result.verdict.success = result.verdict.final_pose_success = false;
  result.verdict.outcome = outcome;
  result.verdict.position_error = position_error;
  return result;
}

RolloutResult unclean(const char* criterion) {
  auto result = test::perfect_grasp();
  result.verdict.success = result.verdict.path_clean = false;
  result.verdict.criteria = {{"clearance", 0, 0, true}, {criterion, -1, 0, false}};
  return result;
}

TEST(Causes, success_has_none_by_the_verdict_that_is_asked_for) {
  EXPECT_EQ(cause_of(test::perfect_grasp(), false), Cause::none);
  EXPECT_EQ(cause_of(unclean("joint_speed"), true), Cause::none) << "executed, only physics decides";
}

TEST(Causes, a_held_object_at_the_end_of_a_path_that_is_not_clean_fails_by_the_path) {
  EXPECT_EQ(cause_of(unclean("clearance"), false), Cause::collision);
  EXPECT_EQ(cause_of(unclean("target_clearance"), false), Cause::hand_in_object);
  EXPECT_EQ(cause_of(unclean("limit_margin"), false), Cause::joint_limit);
  EXPECT_EQ(cause_of(unclean("joint_speed"), false), Cause::too_fast);
}

TEST(Causes, every_outcome_of_the_judge_has_its_cause) {
  EXPECT_EQ(cause_of(failed(Outcome::bad_plan), false), Cause::plan_failed);
  EXPECT_EQ(cause_of(failed(Outcome::unstable), true), Cause::unstable);
  EXPECT_EQ(cause_of(failed(Outcome::no_contact), false), Cause::no_contact);
  EXPECT_EQ(cause_of(failed(Outcome::no_contact, 2 * kReached), false), Cause::unreachable);
  EXPECT_EQ(cause_of(failed(Outcome::initial_penetration, 2 * kReached), false), Cause::hand_in_object);
  EXPECT_EQ(cause_of(failed(Outcome::not_opposed), false), Cause::not_opposed);
  for (const auto outcome : {Outcome::fell_at_release, Outcome::fell_in_jiggle, Outcome::contact_lost})
    EXPECT_EQ(cause_of(failed(outcome), false), Cause::slipped);
  EXPECT_EQ(cause_of(failed(Outcome::support_fell), false), Cause::knocked_over);
  for (const auto outcome : {Outcome::not_released, Outcome::not_on})
    EXPECT_EQ(cause_of(failed(outcome), false), Cause::not_on);
}

TEST(Causes, what_stood_and_lies_was_knocked_over_but_not_what_the_hand_holds) {
  auto result = failed(Outcome::fell_in_jiggle);
  result.verdict.before = {{"upright", {"c1"}}, {"upright", {"c2"}}};
  result.verdict.after = {{"inhand", {"c1"}}, {"upright", {"c2"}}};
  EXPECT_EQ(cause_of(result, true), Cause::slipped) << "a held object may lean";
  result.verdict.after = {{"inhand", {"c1"}}};
  EXPECT_EQ(cause_of(result, true), Cause::knocked_over);
}

TEST(Causes, each_has_a_name_and_a_sentence_of_its_own) {
  std::set<std::string> names, sentences;
  for (std::size_t i = 0; i < config::EnumNames<Cause>::names.size(); ++i) {
    names.insert(config::enum_name(static_cast<Cause>(i)));
    sentences.insert(description(static_cast<Cause>(i)));
  }
  EXPECT_EQ(names.size(), static_cast<std::size_t>(Cause::other) + 1);
  EXPECT_EQ(sentences.size(), names.size());
}

}  // namespace
}  // namespace primo::study
