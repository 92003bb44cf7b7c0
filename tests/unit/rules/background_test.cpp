// Functions, derived predicates, constants and invented concepts.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "generated_data.h"
#include "rules/invent.h"
#include "rules/score.h"

namespace primo::rules {
namespace {

using generated::lit;
using generated::no;
using symbols::Experience;
using symbols::Literal;
using symbols::Relation;

Literal value(std::string function, std::vector<std::string> arguments, int v, Relation relation = Relation::equal) {
  return {std::move(function), std::move(arguments), false, relation, v};
}

std::set<Literal> as_set(const std::vector<Literal>& literals) { return {literals.begin(), literals.end()}; }

Experience experience(std::uint64_t i, std::vector<std::string> objects, Literal action) {
  return {
      .id = std::to_string(i), .objects = std::move(objects), .before = {}, .action = std::move(action), .after = {}};
}

TEST(Functions, a_range_is_found_by_generalizing_and_moving_its_bound) {
  // What weighs at most 4 is lifted.
  std::vector<Experience> data;
  for (std::uint64_t i = 0; i < 120; ++i) {
    Random random(1, "weights", {i});
    auto e = experience(i, {"a", "b"}, lit("lift", {"a"}));
    const int weight = static_cast<int>(random.below(10));
    e.before = {value("weight", {"a"}, weight), value("weight", {"b"}, static_cast<int>(random.below(10)))};
    e.after = e.before;
    if (weight <= 4) e.after.insert(lit("up", {"a"}));
    data.push_back(e);
  }
  const auto rules = learn(data).value();
  ASSERT_EQ(rules.rules.size(), 1u) << to_text(rules);
  EXPECT_EQ(as_set(rules.rules[0].context), as_set({value("weight", {"X"}, 4, Relation::at_most)})) << to_text(rules);
  EXPECT_EQ(rules.defaults.at("lift").noise_count, 0);
  EXPECT_EQ(to_json(rules_from_json(to_json(rules)).value()), to_json(rules));
}

TEST(Functions, an_outcome_gives_a_new_value_and_overlaps_where_it_is_the_old_one) {
  // Filling sets the level to 3, in three of four cases.
  std::vector<Experience> data;
  for (std::uint64_t i = 0; i < 80; ++i) {
    auto e = experience(i, {"a"}, lit("fill", {"a"}));
    const int before = static_cast<int>(i % 2 ? 3 : i / 2 % 3);
    e.before = {value("level", {"a"}, before)};
    e.after = {value("level", {"a"}, i % 8 == 0 ? before : 3)};
    data.push_back(e);
  }
  // Not full: i even, 40 of them, of which those with i mod 8 = 0 (10) stay, whatever their level: p(level = 3) =
  // 30/40.
  const auto rules = learn(data).value();
  ASSERT_EQ(rules.rules.size(), 1u) << to_text(rules);
  ASSERT_EQ(rules.rules[0].outcomes.size(), 2u) << to_text(rules);
  EXPECT_EQ(rules.rules[0].outcomes[0].literals, std::vector<Literal>{value("level", {"X"}, 3)});
  EXPECT_NEAR(rules.rules[0].outcomes[0].p, 30.0 / 40.0, 1e-6);
  const auto prediction = predict(rules, {"a"}, {value("level", {"a"}, 1)}, lit("fill", {"a"}));
  ASSERT_EQ(prediction.successors.size(), 2u);
  EXPECT_EQ(prediction.successors[0].state, (symbols::State{value("level", {"a"}, 3)}));
}

/// Blocks in random stacks; pickup works for a block with nothing on it, which no predicate says.
std::vector<Experience> stacks(int n) {
  std::vector<Experience> data;
  for (int i = 0; i < n; ++i) {
    Random random(2, "stacks", {static_cast<std::uint64_t>(i)});
    auto e = experience(static_cast<std::uint64_t>(i), {"t", "a", "b", "c", "d"}, {});
    std::vector<std::string> tops;
    for (const std::string name : {"a", "b", "c", "d"}) {
      const auto where = random.below(tops.size() + 1);
      e.before.insert(lit("on", {name, where == tops.size() ? "t" : tops[where]}));
      if (where < tops.size()) tops.erase(tops.begin() + static_cast<std::ptrdiff_t>(where));
      tops.push_back(name);
    }
    const std::string x(1, static_cast<char>('a' + random.below(4)));
    e.action = lit("pickup", {x});
    e.after = e.before;
    if (std::find(tops.begin(), tops.end(), x) != tops.end()) {
      std::erase_if(e.after, [&](const Literal& l) { return l.arguments[0] == x; });
      e.after.insert(lit("inhand", {x}));
    }
    data.push_back(e);
  }
  return data;
}

TEST(Derived, a_declared_predicate_is_used_in_contexts_and_never_in_outcomes) {
  const auto data = stacks(80);
  const auto definitions = symbols::definitions_from_text("clear(X) := not exists Y: on(Y,X)", "test").value();
  const auto rules = learn(data, {}, {.derived = definitions, .constants = {}}).value();
  ASSERT_EQ(rules.rules.size(), 1u) << to_text(rules);
  EXPECT_EQ(as_set(rules.rules[0].context), as_set({lit("on", {"X", "Y"}), lit("clear", {"X"})})) << to_text(rules);
  EXPECT_EQ(rules.rules[0].outcomes[0].p, 1);
  EXPECT_EQ(as_set(rules.rules[0].outcomes[0].literals), as_set({lit("inhand", {"X"}), no("on", {"X", "Y"})}));
  // They travel with the rules: a prediction derives them anew.
  const auto read = rules_from_json(to_json(rules)).value();
  for (const auto& e : data) EXPECT_EQ(predict(read, e.objects, e.before, e.action).successors.front().state, e.after);
  const auto without = learn(data).value();
  EXPECT_GT(score(rules, data), score(without, data));
}

TEST(Derived, what_is_defined_may_not_stand_in_the_data) {
  auto data = stacks(2);
  data[1].before.insert(lit("clear", {"a"}));
  const auto definitions = symbols::definitions_from_text("clear(X) := not exists Y: on(Y,X)", "test").value();
  const auto refused = learn(data, {}, {.derived = definitions, .constants = {}});
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("clear is defined as derived"), std::string::npos) << refused.error().message;
}

TEST(Invent, finds_that_nothing_may_stand_on_a_block) {
  const auto data = stacks(120);
  const auto rules = learn_inventing(data).value();
  ASSERT_FALSE(rules.derived.empty()) << to_text(rules);
  EXPECT_GT(score(rules, data), score(learn(data).value(), data) + 1);
  for (const auto& e : data) {
    const auto prediction = predict(rules, e.objects, e.before, e.action);
    ASSERT_FALSE(prediction.successors.empty());
    EXPECT_EQ(prediction.successors.front().state, e.after) << to_text(rules);
    EXPECT_EQ(prediction.successors.front().p, 1);
  }
  // What is not used is not kept.
  std::string contexts;
  for (const auto& rule : rules.rules) contexts += to_text(rule);
  EXPECT_NE(contexts.find(rules.derived.back().head.predicate), std::string::npos);
}

TEST(Constants, a_rule_may_name_an_object_that_is_always_the_same) {
  // Only the red door opens; nothing else tells the doors apart.
  std::vector<Experience> data;
  for (std::uint64_t i = 0; i < 60; ++i) {
    Random random(4, "doors", {i});
    auto e =
        experience(i, {"red", "blue", "green"}, lit("open", {std::array{"red", "blue", "green"}[random.below(3)]}));
    if (e.action.arguments[0] == "red") e.after.insert(lit("open", {"red"}));
    data.push_back(e);
  }
  const auto nameless = learn(data).value();
  const auto rules = learn(data, {}, {.derived = {}, .constants = {"red", "blue"}}).value();
  ASSERT_EQ(rules.rules.size(), 1u) << to_text(rules);
  EXPECT_EQ(rules.rules[0].action, lit("open", {"red"}));
  EXPECT_EQ(rules.rules[0].outcomes[0].literals, std::vector<Literal>{lit("open", {"red"})});
  EXPECT_EQ(rules.rules[0].outcomes[0].p, 1);
  EXPECT_GT(score(rules, data), score(nameless, data));
}

TEST(Store, refuses_a_predicate_with_two_arities) {
  auto data = stacks(2);
  data[1].before.insert(lit("on", {"a"}));
  EXPECT_NE(learn(data).error().message.find("on has 1 argument, but 2 in experience 0"), std::string::npos);
}

}  // namespace
}  // namespace primo::rules
