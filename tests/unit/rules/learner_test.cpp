#include "rules/learner.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "generated_data.h"
#include "rules/online.h"
#include "rules/score.h"

namespace primo::rules {
namespace {

using generated::lit;
using generated::no;
using symbols::Experience;
using symbols::Literal;

RuleSet learned(const std::vector<Experience>& data, const LearnerSettings& settings = {}) {
  auto rules = learn(data, settings);
  EXPECT_TRUE(rules.ok()) << (rules.ok() ? "" : rules.error().message);
  return rules.ok() ? std::move(rules).value() : RuleSet{};
}

std::set<Literal> as_set(const std::vector<Literal>& literals) { return {literals.begin(), literals.end()}; }

const Rule* rule_of(const RuleSet& rules, const std::string& action) {
  for (const auto& rule : rules.rules) {
    if (rule.action.predicate == action) return &rule;
  }
  return nullptr;
}

/// The same experience with other names of its objects, listed in another order.
Experience renamed(Experience experience) {
  const auto name = [](const std::string& object) {
    std::string other("z");
    return other.append(object.rbegin(), object.rend());
  };
  const auto literal = [&](Literal l) {
    for (auto& argument : l.arguments) argument = name(argument);
    return l;
  };
  const auto state = [&](const symbols::State& s) {
    symbols::State out;
    for (const auto& l : s) out.insert(literal(l));
    return out;
  };
  for (auto& object : experience.objects) object = name(object);
  std::reverse(experience.objects.begin(), experience.objects.end());
  experience.before = state(experience.before);
  experience.action = literal(experience.action);
  experience.after = state(experience.after);
  return experience;
}

TEST(Learn, finds_the_papers_grasp_and_place_rules) {
  const auto truth = generated::grasp_place(0.94, 0.92);
  const auto data = generated::grasp_place_data(truth, 500, 1);
  const auto rules = learned(data);
  ASSERT_EQ(rules.rules.size(), 2u) << to_text(rules);
  for (const auto& expected : truth.rules) {
    const Rule* rule = rule_of(rules, expected.action.predicate);
    ASSERT_TRUE(rule);
    EXPECT_EQ(as_set(rule->context), as_set(expected.context)) << to_text(*rule);
    ASSERT_EQ(rule->outcomes.size(), 2u) << to_text(*rule);
    EXPECT_EQ(as_set(rule->outcomes[0].literals), as_set(expected.outcomes[0].literals));
    EXPECT_TRUE(rule->outcomes[1].literals.empty());
    // Counted by hand from the data: the probability is the share.
    std::int64_t covered = 0, happened = 0;
    for (const auto& e : data) {
      if (!bind_rule(expected, e.objects, e.before, e.action)) continue;
      ++covered;
      happened += e.after != e.before;
    }
    EXPECT_EQ(rule->trials(), covered);
    EXPECT_EQ(rule->outcomes[0].count, happened);
    EXPECT_NEAR(rule->outcomes[0].p, static_cast<double>(happened) / static_cast<double>(covered), 1e-12);
  }
  const auto test = generated::grasp_place_data(truth, 500, 99);
  EXPECT_LT(generated::variational_distance(truth, rules, test), 0.025);
}

TEST(Learn, is_exact_on_noise_free_data) {
  const auto truth = generated::grasp_place(1, 1);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto rules = learned(generated::grasp_place_data(truth, 100, seed));
    EXPECT_EQ(generated::variational_distance(truth, rules, generated::grasp_place_data(truth, 300, 99)), 0)
        << "seed " << seed << "\n"
        << to_text(rules);
    EXPECT_EQ(rules.rules.size(), 2u);
  }
}

TEST(Learn, splits_the_slippery_grippers_pickup_by_wetness) {
  const auto truth = generated::slippery_gripper();
  double distance = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto rules = learned(generated::slippery_gripper_data(truth, 2000, seed));
    distance += generated::variational_distance(truth, rules, generated::slippery_gripper_data(truth, 300, 99)) / 5;
    const auto wet = [&](bool negated) {
      return std::count_if(rules.rules.begin(), rules.rules.end(), [&](const Rule& rule) {
        return rule.action.predicate == "pickup" && as_set(rule.context).contains({"wet", {}, negated});
      });
    };
    EXPECT_EQ(wet(false), 1) << to_text(rules);
    EXPECT_EQ(wet(true), 1) << to_text(rules);
  }
  EXPECT_LT(distance, 0.03);
}

TEST(Learn, scores_at_least_as_high_as_the_rules_that_made_the_data) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto grasp = generated::grasp_place(0.9, 0.8);
    const auto grasp_data = generated::grasp_place_data(grasp, 200, seed);
    EXPECT_GE(score(learned(grasp_data), grasp_data), score(grasp, grasp_data)) << "seed " << seed;
    const auto gripper = generated::slippery_gripper();
    const auto gripper_data = generated::slippery_gripper_data(gripper, 300, seed);
    EXPECT_GE(score(learned(gripper_data), gripper_data), score(gripper, gripper_data)) << "seed " << seed;
  }
}

TEST(Learn, outcome_probabilities_under_overlap_are_those_of_the_maximum_likelihood) {
  // dry on a dry floor changes nothing either way: only the wet examples tell p(¬wet).
  std::vector<Experience> data;
  for (int i = 0; i < 100; ++i) {
    Experience e{.id = std::to_string(i), .objects = {}, .before = {}, .action = lit("dry"), .after = {}};
    if (i < 40) e.before.insert(lit("wet"));
    if (i < 10) e.after.insert(lit("wet"));
    data.push_back(e);
  }
  // Without the preference for wet in the context, which would leave no overlap.
  const auto rules = learned(data, {.requirement = 0});
  ASSERT_EQ(rules.rules.size(), 1u) << to_text(rules);
  ASSERT_EQ(rules.rules[0].outcomes.size(), 2u);
  EXPECT_EQ(rules.rules[0].outcomes[0].literals, std::vector<Literal>{no("wet")});
  EXPECT_NEAR(rules.rules[0].outcomes[0].p, 30.0 / 40.0, 1e-6);
  EXPECT_EQ(rules.rules[0].outcomes[0].count, 90) << "30 dried and 60 that were dry";
  EXPECT_EQ(rules.rules[0].trials(), 100);
}

TEST(Learn, takes_what_an_action_makes_false_for_its_condition_until_data_speak_against_it) {
  // wipe(X) takes the dust away and makes X clean. First there is dust always, then it works without dust as well.
  const auto wiped = [](int n, bool without_dust) {
    std::vector<Experience> data;
    for (int i = 0; i < n; ++i) {
      Experience e{.id = std::to_string(i), .objects = {"a"}, .before = {}, .action = lit("wipe", {"a"}), .after = {}};
      e.before.insert(lit("plate", {"a"}));
      if (i % 2 == 0 || !without_dust) e.before.insert(lit("dust", {"a"}));
      e.after = {lit("plate", {"a"}), lit("clean", {"a"})};
      data.push_back(e);
    }
    return data;
  };
  const auto context = [](const RuleSet& rules) {
    EXPECT_EQ(rules.rules.size(), 1u) << to_text(rules);
    return as_set(rules.rules.at(0).context);
  };
  // plate(X) always holds too, but the action leaves it alone (decision 0302).
  EXPECT_EQ(context(learned(wiped(20, false))), std::set<Literal>{lit("dust", {"X"})});
  EXPECT_EQ(context(learned(wiped(20, false), {.requirement = 0})), std::set<Literal>{});
  EXPECT_EQ(context(learned(wiped(20, true))), std::set<Literal>{});
}

TEST(Learn, takes_what_may_hold_by_chance_for_a_condition_only_with_enough_examples) {
  // push(X) works three times by light and fails once in the dark; of light the data say whether it ever changes.
  const auto pushed = [](int times) {
    std::vector<Experience> data;
    for (int i = 0; i < 4 * times; ++i) {
      Experience e{.id = std::to_string(i), .objects = {"a"}, .before = {}, .action = lit("push", {"a"}), .after = {}};
      if (i % 4 != 0) {
        e.before.insert(lit("light"));
        e.after = {lit("light"), lit("moved", {"a"})};
      }
      data.push_back(e);
    }
    return data;
  };
  const Experience lamp{.id = "lamp", .objects = {}, .before = {}, .action = lit("press"), .after = {lit("light")}};
  const auto with_lamp = [&](std::vector<Experience> data) {
    data.push_back(lamp);
    return data;
  };
  const auto context = [](const RuleSet& rules) {
    const auto rule = std::find_if(rules.rules.begin(), rules.rules.end(),
                                   [](const Rule& r) { return r.action.predicate == "push"; });
    EXPECT_NE(rule, rules.rules.end()) << to_text(rules);
    return rule == rules.rules.end() ? std::set<Literal>{} : as_set(rule->context);
  };
  const std::set<Literal> nothing, light{lit("light")};
  // The literal gains 4 ln 4 - 3 ln 3 = 2.25 nats and costs 0.5, or 3.5 where it is a guess.
  EXPECT_EQ(context(learned(pushed(1))), light);
  EXPECT_EQ(context(learned(with_lamp(pushed(1)))), nothing);
  EXPECT_EQ(context(learned(with_lamp(pushed(1)), {.guess = 0})), light);
  // Four times the data: 9.0 nats against 0.5 + 3 * 10/12.
  EXPECT_EQ(context(learned(with_lamp(pushed(4)))), light);
  // The lamp comes last, after rules have been found: the same as all at once.
  const auto online = OnlineLearner::create().value();
  for (const auto& e : pushed(1)) ASSERT_TRUE(online->note(e).ok());
  online->settle();
  EXPECT_EQ(context(online->rules()), light);
  ASSERT_TRUE(online->note(lamp).ok());
  online->settle();
  EXPECT_EQ(to_json(online->rules()), to_json(learned(with_lamp(pushed(1)))));
  EXPECT_EQ(learn(pushed(1), {.guess = -1}).error().code, Code::config);
}

TEST(Learn, what_a_context_literal_earns_is_no_part_of_the_score) {
  const auto truth = generated::grasp_place(1, 1);
  const auto data = generated::grasp_place_data(truth, 100, 7);
  // Noise-free and exact: no likelihood is lost, and each literal costs α.
  const auto rules = learned(data);
  EXPECT_NEAR(score(rules, data), -0.5 * static_cast<double>(penalty(rules)), 1e-9);
  EXPECT_EQ(learn(data, {.requirement = -1}).error().code, Code::config);
}

TEST(Learn, does_not_depend_on_the_order_of_lines_or_the_names_of_objects) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    auto data = generated::grasp_place_data(generated::grasp_place(0.7, 0.6), 150, seed);
    const auto gripper = generated::slippery_gripper_data(generated::slippery_gripper(), 150, seed);
    for (auto e : gripper) {
      e.id += "g";
      data.push_back(e);
    }
    const std::string expected = to_json(learned(data));
    Random random(seed, "shuffle");
    for (std::size_t i = data.size(); i > 1; --i) std::swap(data[i - 1], data[random.below(i)]);
    EXPECT_EQ(to_json(learned(data)), expected);
    for (auto& e : data) e = renamed(e);
    EXPECT_EQ(to_json(learned(data)), expected);
  }
}

TEST(Learn, a_context_that_always_holds_is_left_out_and_can_be_listed_as_untested) {
  std::vector<Experience> data;
  for (int i = 0; i < 60; ++i) {
    Experience e{
        .id = std::to_string(i), .objects = {"c", "t"}, .before = {}, .action = lit("grasp", {"c"}), .after = {}};
    e.before = {lit("on", {"c", "t"}), lit("cylinder", {"c"}), lit("table", {"t"}), lit("clear", {"c"})};
    e.after = e.before;
    if (i < 18) {
      e.after.erase(lit("on", {"c", "t"}));
      e.after.insert(lit("inhand", {"c"}));
    }
    data.push_back(e);
  }
  const auto rules = learned(data);
  ASSERT_EQ(rules.rules.size(), 1u);
  EXPECT_EQ(rules.rules[0].context, std::vector<Literal>{lit("on", {"X", "Y"})}) << to_text(rules);
  EXPECT_EQ(untested_context(rules.rules[0], data),
            (std::vector<Literal>{lit("clear", {"X"}), lit("cylinder", {"X"}), lit("table", {"Y"})}));
  const Rule projected = project_to_desired(rules.rules[0]);
  EXPECT_EQ(projected.outcomes[0].count, 18);
  EXPECT_NEAR(projected.outcomes[0].p, 0.3, 1e-12);
  EXPECT_EQ(projected.noise_count, 42);
}

TEST(Learn, reaches_objects_through_others) {
  // Pressing a button lights the lamp its wire leads to, if that lamp has a bulb: two deictic variables.
  std::vector<Experience> data;
  for (std::uint64_t i = 0; i < 80; ++i) {
    Random random(6, "lamps", {i});
    Experience e{.id = std::to_string(i),
                 .objects = {"b1", "b2", "w1", "w2", "l1", "l2"},
                 .before = {},
                 .action = {},
                 .after = {}};
    const bool crossed = random.below(2);
    e.before = {lit("at", {"b1", "w1"}), lit("at", {"b2", "w2"}), lit("to", {"w1", crossed ? "l2" : "l1"}),
                lit("to", {"w2", crossed ? "l1" : "l2"})};
    for (const char* lamp : {"l1", "l2"}) {
      if (random.below(3)) e.before.insert(lit("bulb", {lamp}));
    }
    const bool first = random.below(2);
    const std::string lamp = first != crossed ? "l1" : "l2";
    e.action = lit("press", {first ? "b1" : "b2"});
    e.after = e.before;
    if (e.before.contains(lit("bulb", {lamp}))) e.after.insert(lit("lit", {lamp}));
    data.push_back(e);
  }
  const auto rules = learned(data);
  const Rule* rule = rule_of(rules, "press");
  ASSERT_TRUE(rule) << to_text(rules);
  EXPECT_EQ(as_set(rule->context), as_set({lit("at", {"X", "Y"}), lit("to", {"Y", "Z"}), lit("bulb", {"Z"})}))
      << to_text(rules);
  EXPECT_EQ(rules.rules.size(), 1u) << to_text(rules);
  EXPECT_EQ(rules.defaults.at("press").noise_count, 0) << to_text(rules);
}

TEST(Learn, takes_actions_without_arguments_repeated_arguments_and_shared_names) {
  std::vector<Experience> data;
  for (int i = 0; i < 20; ++i) {
    const bool self = i % 2 == 0;
    Experience e{.id = std::to_string(i), .objects = {"a", "b"}, .before = {}, .action = {}, .after = {}};
    e.action = lit("join", {"a", self ? "a" : "b"});
    if (self) e.after = {lit("join", {"a", "a"})};  // the predicate has the action's name
    data.push_back(e);
  }
  const auto rules = learned(data);
  ASSERT_EQ(rules.rules.size(), 1u) << to_text(rules);
  EXPECT_EQ(rules.rules[0].action, lit("join", {"X", "X"}));
  EXPECT_EQ(rules.rules[0].outcomes[0].p, 1);
}

TEST(Learn, without_experiences_gives_no_rules) {
  EXPECT_TRUE(learned({}).rules.empty());
  EXPECT_TRUE(learned({}).defaults.empty());
}

TEST(Learn, where_nothing_ever_happens_the_default_rule_says_so) {
  std::vector<Experience> data(5, {.id = "", .objects = {"a"}, .before = {}, .action = lit("wait"), .after = {}});
  const auto rules = learned(data);
  EXPECT_TRUE(rules.rules.empty()) << to_text(rules);
  EXPECT_EQ(rules.defaults.at("wait").no_change, 1);
  EXPECT_EQ(rules.defaults.at("wait").no_change_count, 5);
}

TEST(Learn, counts_an_id_once_and_refuses_it_with_two_contents) {
  auto data = generated::grasp_place_data(generated::grasp_place(0.9, 0.9), 60, 1);
  const std::string expected = to_json(learned(data));
  const std::vector<Experience> again(data.begin(), data.begin() + 30);
  data.insert(data.end(), again.begin(), again.end());
  EXPECT_EQ(to_json(learned(data)), expected);
  data.push_back(again.front());
  data.back().after = {};
  const auto refused = learn(data);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("e0 stands twice with different contents"), std::string::npos);
}

TEST(Learn, refuses_ill_formed_experiences_and_settings) {
  const Experience lost{.id = "", .objects = {}, .before = {lit("on", {"a", "b"})}, .action = lit("x"), .after = {}};
  EXPECT_NE(learn({lost}).error().message.find("experience 1: s: on(a,b) mentions a"), std::string::npos);
  EXPECT_EQ(learn({}, {.p_min = 0}).error().code, Code::config);
  EXPECT_EQ(learn({}, {.alpha = -1}).error().code, Code::config);
}

TEST(Learn, returns_the_best_rules_so_far_when_its_evaluations_are_spent) {
  const auto data = generated::grasp_place_data(generated::grasp_place(0.9, 0.9), 200, 1);
  const auto full = learned(data), early = learned(data, {.max_candidates = 5});
  EXPECT_EQ(to_json(early), to_json(learned(data, {.max_candidates = 5})));
  EXPECT_LT(score(early, data), score(full, data));
  const auto nothing = learned(data, {.max_steps = 1, .max_candidates = 1});
  EXPECT_GE(score(early, data), score(nothing, data));
}

TEST(Learn, no_example_is_covered_by_two_rules) {
  const auto data = generated::slippery_gripper_data(generated::slippery_gripper(), 400, 3);
  const auto rules = learned(data);
  std::int64_t covered = 0;
  for (const auto& e : data) {
    int by = 0;
    for (const auto& rule : rules.rules) by += bind_rule(rule, e.objects, e.before, e.action).has_value();
    EXPECT_LE(by, 1);
    covered += by;
  }
  std::int64_t counted = 0;
  for (const auto& rule : rules.rules) counted += rule.trials();
  EXPECT_EQ(counted, covered);
  for (const auto& [action, rule] : rules.defaults) counted += rule.no_change_count + rule.noise_count;
  EXPECT_EQ(counted, 400);
}

}  // namespace
}  // namespace primo::rules
