#include "rules/prediction.h"

#include <gtest/gtest.h>

#include "generated_data.h"

namespace primo::rules {
namespace {

using generated::lit;
using generated::no;
using symbols::State;

const std::vector<std::string> kObjects{"a", "b", "t"};

Rule rule(symbols::Literal action, std::vector<symbols::Literal> context) {
  return {.action = std::move(action), .context = std::move(context), .outcomes = {}, .noise = 1};
}

TEST(Bind, a_deictic_variable_must_single_out_one_object) {
  const Rule grasp = rule(lit("grasp", {"X"}), {lit("on", {"Y", "X"})});
  EXPECT_FALSE(bind_rule(grasp, kObjects, {}, lit("grasp", {"t"}))) << "none";
  const auto one = bind_rule(grasp, kObjects, {lit("on", {"a", "t"})}, lit("grasp", {"t"}));
  ASSERT_TRUE(one);
  EXPECT_EQ(*one, (Binding{{"X", "t"}, {"Y", "a"}}));
  EXPECT_FALSE(bind_rule(grasp, kObjects, {lit("on", {"a", "t"}), lit("on", {"b", "t"})}, lit("grasp", {"t"})))
      << "two";
}

TEST(Bind, distinct_variables_are_distinct_objects) {
  EXPECT_FALSE(bind_rule(rule(lit("join", {"X", "Y"}), {}), kObjects, {}, lit("join", {"a", "a"})));
  EXPECT_TRUE(bind_rule(rule(lit("join", {"X", "X"}), {}), kObjects, {}, lit("join", {"a", "a"})));
  EXPECT_FALSE(bind_rule(rule(lit("join", {"X", "X"}), {}), kObjects, {}, lit("join", {"a", "b"})));
  const Rule on = rule(lit("grasp", {"X"}), {lit("on", {"X", "Y"})});
  EXPECT_FALSE(bind_rule(on, kObjects, {lit("on", {"a", "a"})}, lit("grasp", {"a"})));
}

TEST(Bind, constants_match_only_themselves) {
  const Rule on_t = rule(lit("grasp", {"X"}), {lit("on", {"X", "t"})});
  EXPECT_TRUE(bind_rule(on_t, kObjects, {lit("on", {"a", "t"})}, lit("grasp", {"a"})));
  EXPECT_FALSE(bind_rule(on_t, kObjects, {lit("on", {"a", "b"})}, lit("grasp", {"a"})));
  EXPECT_FALSE(bind_rule(rule(lit("grasp", {"a"}), {}), kObjects, {}, lit("grasp", {"b"})));
  EXPECT_FALSE(bind_rule(rule(lit("grasp", {"X"}), {lit("on", {"X", "unknown"})}), kObjects, {}, lit("grasp", {"b"})));
}

/// All assignments of objects to variables, tried one after the other.
std::vector<Binding> every_binding(const Rule& r, const State& state, const symbols::Literal& action) {
  std::vector<std::string> variables;
  const auto collect = [&](const symbols::Literal& literal) {
    for (const auto& term : literal.arguments) {
      if (symbols::is_variable(term) && std::find(variables.begin(), variables.end(), term) == variables.end()) {
        variables.push_back(term);
      }
    }
  };
  collect(r.action);
  for (const auto& literal : r.context) collect(literal);
  std::size_t total = 1;
  for (std::size_t i = 0; i < variables.size(); ++i) total *= kObjects.size();
  std::vector<Binding> found;
  for (std::size_t code = 0; code < total; ++code) {
    Binding binding;
    std::set<std::string> used;
    std::size_t rest = code;
    for (const auto& variable : variables) {
      binding[variable] = kObjects[rest % kObjects.size()];
      used.insert(binding[variable]);
      rest /= kObjects.size();
    }
    if (used.size() < variables.size()) continue;
    if (ground({r.action}, binding).front() == action && holds(ground(r.context, binding), state))
      found.push_back(binding);
  }
  return found;
}

TEST(Bind, agrees_with_trying_every_assignment) {
  int unique = 0;
  for (std::uint64_t trial = 0; trial < 3000; ++trial) {
    Random random(4, "bind", {trial});
    const std::vector<std::string> terms{"X", "Y", "Z", "a"};
    const auto any = [&](const std::vector<std::string>& from) { return from[random.below(from.size())]; };
    Rule r = rule(lit("do", {any({"X", "a"}), any(terms)}), {});
    for (auto n = random.below(4); n > 0; --n) {
      auto literal = random.below(2) ? lit("p", {any(terms), any(terms)}) : lit("q", {any(terms)});
      literal.negated = random.below(3) == 0;
      r.context.push_back(literal);
    }
    State state;
    for (const auto& x : kObjects) {
      if (random.below(2)) state.insert(lit("q", {x}));
      for (const auto& y : kObjects) {
        if (random.below(2)) state.insert(lit("p", {x, y}));
      }
    }
    const auto action = lit("do", {any(kObjects), any(kObjects)});
    const auto expected = every_binding(r, state, action);
    const auto found = bind_rule(r, kObjects, state, action);
    ASSERT_EQ(found.has_value(), expected.size() == 1) << to_text(r);
    if (found) {
      EXPECT_EQ(*found, expected.front());
      ++unique;
    }
  }
  EXPECT_GT(unique, 200);
}

TEST(Covering, two_rules_that_cover_leave_it_to_the_default_rule) {
  RuleSet rules;
  rules.rules = {rule(lit("grasp", {"X"}), {}), rule(lit("grasp", {"X"}), {lit("wet")})};
  rules.defaults["grasp"] = {.no_change = 0.8, .noise = 0.2};
  EXPECT_EQ(covering(rules, kObjects, {}, lit("grasp", {"a"})), &rules.rules[0]);
  EXPECT_EQ(covering(rules, kObjects, {lit("wet")}, lit("grasp", {"a"})), nullptr);
  const auto prediction = predict(rules, kObjects, {lit("wet")}, lit("grasp", {"a"}));
  ASSERT_EQ(prediction.successors.size(), 1u);
  EXPECT_EQ(prediction.successors[0].state, (State{lit("wet")}));
  EXPECT_EQ(prediction.successors[0].p, 0.8);
  EXPECT_EQ(prediction.noise, 0.2);
}

TEST(Predict, adds_up_outcomes_that_lead_to_the_same_state) {
  RuleSet rules;
  rules.rules = {{.action = lit("dry"), .context = {}, .outcomes = {{0.9, {no("wet")}}, {0.1, {}}}, .noise = 0}};
  const auto dry = predict(rules, kObjects, {}, lit("dry"));
  ASSERT_EQ(dry.successors.size(), 1u);
  EXPECT_DOUBLE_EQ(dry.successors[0].p, 1);
  const auto wet = predict(rules, kObjects, {lit("wet")}, lit("dry"));
  ASSERT_EQ(wet.successors.size(), 2u);
  EXPECT_EQ(wet.successors[0].state, State{});
  EXPECT_DOUBLE_EQ(wet.successors[0].p, 0.9);
}

TEST(Predict, an_unknown_action_is_all_noise) {
  const auto prediction = predict({}, kObjects, {}, lit("fly"));
  EXPECT_TRUE(prediction.successors.empty());
  EXPECT_EQ(prediction.noise, 1);
}

TEST(DesiredOutcome, is_the_most_probable_change_also_where_most_attempts_fail) {
  RuleSet rules = generated::grasp_place(0.3, 0.5);
  rules.rules[0].outcomes[0].count = 30;
  rules.rules[0].outcomes[1].count = 70;
  const auto desired = desired_outcome(rules, "grasp");
  ASSERT_TRUE(desired.ok()) << desired.error().message;
  EXPECT_EQ(desired->literals, (std::vector<symbols::Literal>{lit("inhand", {"X"}), no("on", {"X", "Y"})}));
  EXPECT_EQ(desired->rate.successes, 30);
  EXPECT_EQ(desired->rate.trials, 100);
}

TEST(DesiredOutcome, can_be_asked_to_reach_a_goal) {
  RuleSet rules;
  rules.rules = {{.action = lit("grasp", {"X"}),
                  .context = {},
                  .outcomes = {{0.6, {no("upright", {"X"})}, 60}, {0.3, {lit("inhand", {"X"})}, 30}, {0.1, {}, 10}},
                  .noise = 0}};
  EXPECT_EQ(desired_outcome(rules, "grasp")->literals[0], no("upright", {"X"}));
  const auto desired = desired_outcome(rules, "grasp", {lit("inhand", {"X"})});
  ASSERT_TRUE(desired.ok());
  EXPECT_EQ(desired->literals[0], lit("inhand", {"X"}));
  EXPECT_EQ(desired->rate.successes, 30);
  EXPECT_EQ(desired->rate.trials, 100) << "the other outcomes' examples still count";
  EXPECT_NE(desired_outcome(rules, "grasp", {lit("broken", {"X"})}).error().message.find("contains broken(X)"),
            std::string::npos);
  EXPECT_NE(desired_outcome(rules, "place").error().message.find("no rule for the action place"), std::string::npos);
}

}  // namespace
}  // namespace primo::rules
