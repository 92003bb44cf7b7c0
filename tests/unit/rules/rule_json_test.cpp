#include <gtest/gtest.h>

#include "core/random.h"
#include "generated_data.h"
#include "rules/rule.h"
#include "unit/mutate.h"

namespace primo::rules {
namespace {

using generated::lit;
using generated::no;

const char* const kRules =
    R"({"rules":[{"action":["grasp","X"],"context":[["on","X","Y"],["not","wet"]],)"
    R"("outcomes":[[0.94,[["inhand","X"],["not","on","X","Y"]]]],"noise":0.06,"counts":[47,3]}],)"
    R"("default":{"grasp":{"nochange":0.9,"noise":0.1,"counts":[9,1]}}})";

std::string message(const std::string& json) {
  const auto read = rules_from_json(json);
  EXPECT_FALSE(read.ok()) << json;
  if (read.ok()) return "";
  EXPECT_EQ(read.error().code, Code::data);
  return read.error().message;
}

TEST(RulesJson, is_the_published_form) {
  const auto read = rules_from_json(kRules);
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read->rules.size(), 1u);
  const Rule& rule = read->rules[0];
  EXPECT_EQ(rule.action, lit("grasp", {"X"}));
  EXPECT_EQ(rule.context, (std::vector<symbols::Literal>{lit("on", {"X", "Y"}), no("wet")}));
  EXPECT_EQ(rule.outcomes[0].literals, (std::vector<symbols::Literal>{lit("inhand", {"X"}), no("on", {"X", "Y"})}));
  EXPECT_EQ(rule.outcomes[0].count, 47);
  EXPECT_EQ(rule.noise_count, 3);
  EXPECT_EQ(rule.trials(), 50);
  EXPECT_EQ(read->defaults.at("grasp").no_change, 0.9);
  EXPECT_EQ(to_json(*read), kRules);
}

TEST(RulesJson, counts_and_the_default_are_optional) {
  const auto read = rules_from_json(R"({"rules":[{"action":["dry"],"context":[],"outcomes":[],"noise":1}]})");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->rules[0].trials(), 0);
}

TEST(RulesJson, keeps_the_number_of_examples_when_outcomes_share_some) {
  auto rules = *rules_from_json(
      R"({"rules":[{"action":["dry"],"context":[],"outcomes":[[0.5,[["a"]]],[0.5,[]]],"noise":0,"counts":[8,7,0],"examples":10}]})");
  EXPECT_EQ(rules.rules[0].trials(), 10);
  EXPECT_EQ(rules_from_json(to_json(rules))->rules[0].trials(), 10);
}

TEST(RulesJson, errors_say_where_and_what_would_be_right) {
  const auto rule = [](const std::string& body) { return message(R"({"rules":[{)" + body + "}]}"); };
  const std::string head = R"("action":["a","X"],"context":[],)";
  EXPECT_NE(message("{}").find("\"rules\" must be a list"), std::string::npos);
  EXPECT_NE(message(R"({"rules":[],"defaults":{}})").find("known: rules, default, derived"), std::string::npos);
  EXPECT_NE(rule(R"("action":["a"])").find("rules[0]: lacks the key \"context\""), std::string::npos);
  EXPECT_NE(rule(head + R"("outcomes":[],"noise":0.5)").find("sum to 0.5"), std::string::npos);
  EXPECT_NE(rule(head + R"("outcomes":[[2,[]]],"noise":0)").find("outcomes[0] is 2; a probability"), std::string::npos);
  EXPECT_NE(
      rule(head + R"("outcomes":[[1,[["on","X","Y"]]]],"noise":0)").find("neither the action nor the context binds"),
      std::string::npos);
  EXPECT_NE(rule(head + R"("outcomes":[],"noise":1,"counts":[1,2])").find("one for noise"), std::string::npos);
  EXPECT_NE(rule(head + R"("outcomes":[],"noise":1,"counts":[-1])").find("whole number"), std::string::npos);
  EXPECT_NE(rule(head + R"("outcomes":[],"noise":1,"counts":[1],"examples":5)").find("more than"), std::string::npos);
  EXPECT_NE(message(R"({"rules":[],"default":{"g":{"nochange":1}}})").find("default.g: must have the keys"),
            std::string::npos);
}

TEST(RulesJson, mutated_texts_are_read_back_the_same_or_refused) {
  int accepted = 0;
  for (std::uint64_t round = 0; round < 20000; ++round) {
    Random random(3, "mutate", {round});
    const std::string text = test::mutated(kRules, random);
    const auto read = rules_from_json(text);
    if (!read.ok()) {
      EXPECT_FALSE(read.error().message.empty());
      continue;
    }
    ++accepted;
    const auto again = rules_from_json(to_json(*read));
    ASSERT_TRUE(again.ok()) << text << "\n" << again.error().message;
    EXPECT_EQ(to_json(*again), to_json(*read));
  }
  EXPECT_GT(accepted, 100) << "the mutations must also produce valid texts";
}

TEST(RuleText, has_the_papers_layout_with_counts_and_wilson_intervals) {
  const auto rules = *rules_from_json(kRules);
  // Wilson's interval of 47/50 is 0.838 to 0.979, of 3/50 0.021 to 0.162.
  EXPECT_EQ(to_text(rules.rules[0]),
            "grasp(X): on(X,Y), ¬wet\n"
            "  → 0.94  inhand(X), ¬on(X,Y)   (47/50, 95 % 0.84–0.98)\n"
            "    0.06  noise                 (3/50, 95 % 0.02–0.16)\n");
}

TEST(ProjectToDesired, makes_all_but_the_most_probable_change_noise) {
  const Rule rule{.action = lit("grasp", {"X"}),
                  .context = {lit("on", {"X", "Y"})},
                  .outcomes = {{0.6, {}, 60}, {0.3, {lit("inhand", {"X"})}, 30}, {0.08, {no("upright", {"X"})}, 8}},
                  .noise = 0.02,
                  .noise_count = 2,
                  .examples = 100};
  const Rule projected = project_to_desired(rule);
  ASSERT_EQ(projected.outcomes.size(), 1u);
  EXPECT_EQ(projected.outcomes[0].literals, rule.outcomes[1].literals);
  EXPECT_EQ(projected.outcomes[0].count, 30);
  EXPECT_EQ(projected.noise_count, 70);
  EXPECT_DOUBLE_EQ(projected.outcomes[0].p, 0.3);
  EXPECT_DOUBLE_EQ(projected.noise, 0.7);
  EXPECT_EQ(projected.trials(), 100);
}

TEST(ProjectToDesired, of_a_rule_that_changes_nothing_is_all_noise) {
  const Rule projected = project_to_desired({.action = lit("a"), .context = {}, .outcomes = {{1, {}, 5}}, .noise = 0});
  EXPECT_TRUE(projected.outcomes.empty());
  EXPECT_EQ(projected.noise, 1);
  EXPECT_EQ(projected.noise_count, 5);
}

TEST(ProjectToDesired, without_counts_keeps_the_stated_probability) {
  const Rule projected =
      project_to_desired({.action = lit("a"), .context = {}, .outcomes = {{0.7, {lit("b")}}, {0.3, {}}}, .noise = 0});
  EXPECT_DOUBLE_EQ(projected.outcomes[0].p, 0.7);
  EXPECT_DOUBLE_EQ(projected.noise, 0.3);
}

}  // namespace
}  // namespace primo::rules
