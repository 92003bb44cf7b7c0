// What rules are for: sampling, diagnosis, differences, plans, exports.
#include <gtest/gtest.h>

#include <cmath>

#include "generated_data.h"
#include "rules/analysis.h"
#include "rules/export.h"
#include "rules/plan.h"

namespace primo::rules {
namespace {

using generated::lit;
using generated::no;
using symbols::Experience;
using symbols::Literal;
using symbols::State;

TEST(Sample, draws_successors_and_noise_as_often_as_predicted) {
  RuleSet rules;
  rules.rules = {
      {.action = lit("go"), .context = {}, .outcomes = {{0.5, {lit("a")}}, {0.3, {lit("b")}}}, .noise = 0.2}};
  const auto prediction = predict(rules, {}, {}, lit("go"));
  std::map<State, int> drawn;
  int noise = 0;
  constexpr int kDraws = 20000;
  Random random(1, "sample");
  for (int i = 0; i < kDraws; ++i) {
    if (const State* state = sample(prediction, random)) {
      ++drawn[*state];
    } else {
      ++noise;
    }
  }
  // Four standard deviations.
  const auto near = [](int count, double p) {
    return std::abs(count - kDraws * p) < 4 * std::sqrt(kDraws * p * (1 - p));
  };
  EXPECT_TRUE(near(drawn[{lit("a")}], 0.5));
  EXPECT_TRUE(near(drawn[{lit("b")}], 0.3));
  EXPECT_TRUE(near(noise, 0.2));
}

/// grasp(X) works for what is light; of the heavy things it breaks every second in a way that no outcome says.
std::vector<Experience> mixed() {
  std::vector<Experience> data;
  for (int i = 0; i < 40; ++i) {
    Experience e{
        .id = "e" + std::to_string(i), .objects = {"a", "b"}, .before = {}, .action = lit("grasp", {"a"}), .after = {}};
    const bool heavy = i < 10;
    e.before = {lit("on", {"a", "b"})};
    if (i % 2) e.before.insert(lit("red", {"a"}));
    if (heavy) e.before.insert(lit("heavy", {"a"}));
    e.after = e.before;
    if (!heavy) e.after.insert(lit("inhand", {"a"}));
    if (heavy && i < 5) e.after.insert(lit("broken", {"b"}));
    data.push_back(e);
  }
  return data;
}

TEST(Diagnose, names_what_is_unexplained_and_the_literal_that_would_split_it_best) {
  RuleSet rules;
  rules.rules = {{.action = lit("grasp", {"X"}),
                  .context = {},
                  .outcomes = {{0.75, {lit("inhand", {"X"})}, 30}, {0.125, {}, 5}},
                  .noise = 0.125,
                  .noise_count = 5}};
  const auto diagnosis = diagnose(rules, mixed());
  ASSERT_EQ(diagnosis.rules.size(), 1u);
  const auto& rule = diagnosis.rules[0];
  EXPECT_EQ(rule.covered, 40);
  EXPECT_EQ(rule.noise, 0.125);
  EXPECT_NEAR(rule.entropy, -(0.75 * std::log(0.75) + 0.25 * std::log(0.125)), 1e-12);
  EXPECT_EQ(rule.unexplained, (std::vector<std::string>{"e0", "e1", "e2", "e3", "e4"}));
  ASSERT_TRUE(rule.split);
  EXPECT_EQ(rule.split->literal, lit("heavy", {"X"}));
  // 5 of 10 heavy and 0 of 30 others are unexplained, 5 of 40 in all.
  const double apart = 10 * std::log(0.5), together = 5 * std::log(5.0 / 40) + 35 * std::log(35.0 / 40);
  EXPECT_NEAR(rule.split->gain, apart - together, 1e-9);
}

TEST(Diagnose, lists_changes_that_no_rule_covers) {
  const auto diagnosis = diagnose({}, mixed());
  ASSERT_EQ(diagnosis.defaults.size(), 1u);
  EXPECT_EQ(diagnosis.defaults[0].covered, 40);
  EXPECT_EQ(diagnosis.defaults[0].unexplained.size(), 35u);
}

TEST(Difference, tells_added_removed_and_changed_rules) {
  const auto before = generated::grasp_place(0.9, 0.8);
  auto after = generated::grasp_place(0.7, 0.8);
  std::reverse(after.rules[1].context.begin(), after.rules[1].context.end());
  auto different = difference(before, after);
  ASSERT_EQ(different.changed.size(), 1u) << "the order of a context says nothing";
  EXPECT_EQ(different.changed[0].outcomes[0].p, 0.7);
  EXPECT_TRUE(different.added.empty() && different.removed.empty());
  after.rules[0].context.pop_back();
  different = difference(before, after);
  EXPECT_EQ(different.added.size(), 1u);
  EXPECT_EQ(different.removed.size(), 1u);
  EXPECT_EQ(different.removed[0].context, before.rules[0].context);
  EXPECT_TRUE(difference(before, before).empty());
  EXPECT_TRUE(difference(before, generated::grasp_place(0.9001, 0.8), 0.001).empty());
}

/// A light that a button turns on with 0.6, and with 0.9 once it is wound up, which takes an action.
RuleSet light() {
  RuleSet rules;
  rules.rules = {
      {.action = lit("press"),
       .context = {no("wound"), no("on")},
       .outcomes = {{0.6, {lit("on")}}, {0.1, {}}},
       .noise = 0.3},
      {.action = lit("press"), .context = {lit("wound"), no("on")}, .outcomes = {{0.9, {lit("on")}}}, .noise = 0.1},
      {.action = lit("wind"), .context = {no("wound")}, .outcomes = {{1, {lit("wound")}}}, .noise = 0}};
  return rules;
}

TEST(Plan, winds_first_where_there_is_time) {
  const PlanProblem problem{.objects = {}, .state = {}, .goal = {lit("on")}, .horizon = 2};
  EXPECT_NEAR(*best_success(light(), problem), 0.9, 1e-12);
  const auto uct = plan_uct(light(), problem);
  ASSERT_TRUE(uct.ok()) << uct.error().message;
  EXPECT_NEAR(uct->success, 0.9, 1e-12);
  ASSERT_EQ(uct->steps.size(), 2u);
  EXPECT_EQ(uct->steps[0].action, lit("wind"));
  EXPECT_EQ(uct->steps[1].action, lit("press"));
  const auto replan = plan_replan(light(), problem);
  ASSERT_TRUE(replan.ok()) << replan.error().message;
  EXPECT_NEAR(replan->success, 0.9, 1e-12) << "the most probable path is 1 · 0.9";
  // With one action left only pressing helps.
  const PlanProblem hurried{.objects = {}, .state = {}, .goal = {lit("on")}, .horizon = 1};
  EXPECT_NEAR(plan_uct(light(), hurried)->success, 0.6, 1e-12);
  EXPECT_NEAR(plan_replan(light(), hurried)->success, 0.6, 1e-12);
}

TEST(Plan, success_counts_new_attempts_and_noise_as_failure) {
  RuleSet rules;
  rules.rules = {
      {.action = lit("try"), .context = {no("done")}, .outcomes = {{0.5, {lit("done")}}, {0.3, {}}}, .noise = 0.2}};
  const PlanProblem problem{.objects = {}, .state = {}, .goal = {lit("done")}, .horizon = 3};
  const double expected = 0.5 * (1 + 0.3 + 0.3 * 0.3);  // a geometric series
  EXPECT_NEAR(*best_success(rules, problem), expected, 1e-12);
  EXPECT_NEAR(plan_uct(rules, problem)->success, expected, 1e-12);
  EXPECT_NEAR(plan_replan(rules, problem)->success, expected, 1e-12);
  EXPECT_EQ(plan_uct(rules, problem)->steps.size(), 1u);
}

TEST(Plan, no_plan_claims_more_than_the_best_policy_has_and_uct_comes_close) {
  const auto rules = generated::grasp_place(0.9, 0.8);
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    Random random(seed, "plan");
    const auto scene = generated::make_tabletop(random, 3);
    PlanProblem problem{scene.objects, scene.before, {lit("on", {"o0", "o1"})}, 4};
    const auto best = best_success(rules, problem);
    ASSERT_TRUE(best.ok()) << best.error().message;
    for (const auto& plan : {plan_uct(rules, problem, {.seed = seed}), plan_replan(rules, problem)}) {
      if (!plan.ok()) {
        EXPECT_EQ(plan.error().code, Code::failed);
        EXPECT_EQ(*best, 0) << "seed " << seed;
        continue;
      }
      EXPECT_LE(plan->success, *best + 1e-12);
      EXPECT_GE(plan->success, 0.9 * *best) << "seed " << seed;
    }
  }
}

TEST(Plan, is_the_same_for_the_same_seed_and_refuses_bad_problems) {
  const PlanProblem problem{.objects = {"a"}, .state = {}, .goal = {lit("on")}, .horizon = 3};
  const auto a = plan_uct(light(), problem, {.seed = 3}), b = plan_uct(light(), problem, {.seed = 3});
  EXPECT_EQ(a->success, b->success);
  EXPECT_EQ(a->steps.size(), b->steps.size());
  EXPECT_EQ(plan_uct(light(), {.objects = {}, .state = {}, .goal = {}, .horizon = 3}).error().code, Code::usage);
  EXPECT_EQ(plan_uct(light(), {.objects = {}, .state = {}, .goal = {lit("on", {"x"})}}).error().code, Code::usage);
  EXPECT_EQ(plan_replan(light(), {.objects = {}, .state = {}, .goal = {lit("off")}}).error().code, Code::failed);
}

TEST(Latex, has_the_papers_layout) {
  RuleSet rules;
  rules.rules = {{.action = lit("grasp", {"X"}),
                  .context = {lit("on", {"X", "Y"}), no("wet")},
                  .outcomes = {{0.94, {lit("inhand", {"X"}), no("on", {"X", "Y"})}}},
                  .noise = 0.06}};
  EXPECT_EQ(to_latex(rules),
            "\\[\n  \\mathsf{grasp}(X):\\ \\mathsf{on}(X,Y),\\ \\neg \\mathsf{wet}\\ \\rightarrow\\ \\begin{cases}\n"
            "    0.94 & \\mathsf{inhand}(X),\\ \\neg \\mathsf{on}(X,Y) \\\\\n"
            "    0.06 & \\text{noise}\n  \\end{cases}\n\\]\n");
}

TEST(Ppddl, hoists_what_all_outcomes_share_and_says_what_it_cannot_say) {
  RuleSet rules;
  rules.rules = {{.action = lit("turn"),
                  .context = {},
                  .outcomes = {{0.5, {lit("a"), lit("b")}}, {0.5, {lit("a"), no("b")}}},
                  .noise = 0}};
  const auto domain = to_ppddl(rules);
  ASSERT_TRUE(domain.ok()) << domain.error().message;
  EXPECT_NE(domain->text.find("(and (a) (probabilistic\n        0.5 (b)\n        0.5 (not (b))))"), std::string::npos)
      << domain->text;
  EXPECT_EQ(domain->largest_noise, 0);
  rules.rules[0].outcomes[0].literals.push_back({"size", {}, true, symbols::Relation::equal, 3});
  EXPECT_NE(to_ppddl(rules).error().message.find("loses its value"), std::string::npos);
  rules = {};
  rules.rules = {{.action = lit("x"), .context = {lit("On"), lit("on")}, .outcomes = {}, .noise = 1}};
  EXPECT_NE(to_ppddl(rules).error().message.find("would have one name"), std::string::npos);
}

}  // namespace
}  // namespace primo::rules
