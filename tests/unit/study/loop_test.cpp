#include "study/loop.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <sstream>

#include "core/files.h"
#include "rules/learner.h"
#include "study/codec.h"
#include "synthetic.h"

namespace primo::study {
namespace {

namespace fs = std::filesystem;

/// Sees what is there, rolls out on the bowl, learns with the real learner. Stops after so many calls.
class SyntheticWorkers : public Workers {
 public:
  Status evaluate(std::span<const Rollout> rollouts,
                  const std::function<void(std::size_t, RolloutResult)>& on_result) override {
    for (std::size_t i = 0; i < rollouts.size(); ++i) {
      if (stop()) return stopped();
      ++rollouts_done;
      on_result(i, test::bowl(rollouts[i]));
    }
    return success();
  }
  Result<std::vector<scene::SceneEstimate>> observe(std::span<const scene::Scenario> scenarios) override {
    if (stop()) return stopped();
    std::vector<scene::SceneEstimate> estimates;
    for (const auto& s : scenarios) estimates.push_back(test::estimate(s));
    return estimates;
  }
  Result<rules::RuleSet> learn(const std::string& batch, const std::vector<symbols::Experience>& experiences) override {
    if (stop()) return stopped();
    batches.push_back(batch);
    return rules::learn(experiences);
  }
  Result<OptimizeResult> optimize(const OptimizeGoal& goal) override {
    if (stop()) return stopped();
    goals.push_back(goal);
    return optimize_in_directory(goal, *this);
  }
  int calls_left = -1;
  int rollouts_done = 0;
  std::vector<std::string> batches;
  std::vector<OptimizeGoal> goals;

 private:
  static Error stopped() { return {Code::unavailable, "stopped"}; }
  bool stop() { return calls_left >= 0 && calls_left-- == 0; }
};

class LoopTest : public ::testing::Test {
 protected:
  void SetUp() override {
    directory = fs::temp_directory_path() / ("primo_loop_" + std::to_string(::getpid()) + "_" +
                                             ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(directory);
    fs::create_directories(directory);
    study.name = "test";
    study.robot = "/nowhere/robot.yaml";
    study.robot_digest = "0";
    study.primitive = test::primitive(2).with_log_rho({1.9, 2.0});  // succeeds in some scenarios only
    for (int k = 0; k < 3; ++k) {
      study.training.push_back(test::scenario("s" + std::to_string(k), 0.75 + 0.05 * k));
      study.training.back().robot_start = {0.0};
    }
    study.settings.experience.scenarios = 30;
    study.settings.experience.displacement = 0.05;
    study.settings.optimizer.evaluations = 80;
    study.settings.optimizer.population = 8;
    study.settings.executed = 5;
  }
  void TearDown() override { fs::remove_all(directory); }
  std::string result_text(const std::string& name) const { return read_file(directory / name / "result.json").value(); }

  fs::path directory;
  Study study;
};

TEST_F(LoopTest, makes_the_rule_more_predictive) {
  SyntheticWorkers workers;
  std::vector<std::string> stages;
  const auto result = run_study(study, directory / "run", workers, [&](const Progress& p) {
    if (stages.empty() || stages.back() != p.stage) stages.push_back(p.stage);
    EXPECT_LE(p.done, p.total);
    EXPECT_EQ(p.study, study.id());
  });
  ASSERT_TRUE(result.ok()) << result.error().message;
  ASSERT_EQ(result->collections.size(), 2u);
  const auto &before = result->collections[0], &after = result->collections[1];
  EXPECT_LT(before.displaced.desired.value(), 0.9);
  EXPECT_EQ(after.displaced.desired.value(), 1.0);
  const auto* rule = rule_of(after.rules, "grasp");
  ASSERT_NE(rule, nullptr);
  const auto shown = desired_rule(*rule, result->optimizations[0].desired);
  ASSERT_EQ(shown.outcomes.size(), 1u);
  EXPECT_EQ(shown.outcomes[0].count, 30);
  EXPECT_DOUBLE_EQ(shown.outcomes[0].p, 1.0);
  EXPECT_EQ(after.executed.trials, 5);
  EXPECT_EQ(after.training.strict.trials, 3 * 3);
  EXPECT_EQ(stages, (std::vector<std::string>{"observe", "collect", "learn", "collect", "learn", "execute", "done"}));
  const auto text = summary(*result);
  EXPECT_NE(text.find("inhand(X)"), std::string::npos) << text;
  EXPECT_NE(text.find("30/30"), std::string::npos) << text;

  // What was counted is what was seen: the experience files say the same.
  int lines = 0, grasped = 0;
  std::istringstream file(read_file(directory / "run" / "experience-0.jsonl").value());
  for (std::string line; std::getline(file, line); ++lines) {
    const auto experience = symbols::experience_from_json(line);
    ASSERT_TRUE(experience.ok()) << experience.error().message;
    grasped += experience->after.contains({"inhand", {"c1"}});
  }
  EXPECT_EQ(lines, 30);
  EXPECT_EQ(grasped, before.displaced.strict.successes);
}

TEST_F(LoopTest, result_reads_back_to_the_same_bytes) {
  SyntheticWorkers workers;
  ASSERT_TRUE(run_study(study, directory / "run", workers).ok());
  const auto text = result_text("run");
  const auto back = result_from_json(text);
  ASSERT_TRUE(back.ok()) << back.error().message;
  EXPECT_EQ(to_json(*back), text);
  for (std::size_t n = 0; n < text.size(); n += 101) EXPECT_FALSE(result_from_json(text.substr(0, n)).ok());
}

TEST_F(LoopTest, counts_of_a_places_two_criteria_are_kept_with_the_result) {
  SyntheticWorkers workers;
  ASSERT_TRUE(run_study(study, directory / "run", workers).ok());
  auto result = result_from_json(result_text("run"));
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_TRUE(result->collections[0].displaced.on.empty()) << "a grasp is not placed";
  result->collections[0].displaced.on = {{"both", 3}, {"paper only", 2}};
  const auto back = result_from_json(to_json(*result));
  ASSERT_TRUE(back.ok()) << back.error().message;
  EXPECT_EQ(back->collections[0].displaced.on, result->collections[0].displaced.on);
}

TEST_F(LoopTest, ends_with_the_same_bytes_however_often_it_was_stopped) {
  SyntheticWorkers undisturbed;
  ASSERT_TRUE(run_study(study, directory / "whole", undisturbed).ok());
  int rollouts = 0, runs = 0;
  while (true) {
    SyntheticWorkers workers;
    workers.calls_left = 61 + 7 * (runs % 5);
    const auto result = run_study(study, directory / "parts", workers);
    rollouts += workers.rollouts_done;
    ASSERT_LT(++runs, 100);
    if (result.ok()) break;
    ASSERT_EQ(result.error().code, Code::unavailable) << result.error().message;
    EXPECT_FALSE(fs::exists(directory / "parts" / "result.json")) << "a result is there only when it is complete";
  }
  EXPECT_GT(runs, 3);
  EXPECT_EQ(rollouts, undisturbed.rollouts_done) << "nothing is done twice";
  EXPECT_EQ(result_text("parts"), result_text("whole"));
}

TEST_F(LoopTest, run_again_says_the_same_without_any_work) {
  SyntheticWorkers first, second;
  ASSERT_TRUE(run_study(study, directory / "run", first).ok());
  const auto text = result_text("run");
  second.calls_left = 0;
  ASSERT_TRUE(run_study(study, directory / "run", second).ok());
  EXPECT_EQ(result_text("run"), text);
}

TEST_F(LoopTest, tells_the_optimizer_everything_in_the_goal) {
  SyntheticWorkers workers;
  study.settings.optimizer.settings.validation = 2;
  ASSERT_TRUE(run_study(study, directory / "run", workers).ok());
  ASSERT_EQ(workers.goals.size(), 1u);
  const auto& goal = workers.goals[0];
  EXPECT_EQ(goal.study, study.id());
  EXPECT_EQ(goal.scenarios.size(), 3u);
  EXPECT_EQ(goal.estimates.size(), 3u);
  EXPECT_EQ(goal.desired, test::grasped());
  EXPECT_TRUE(fs::path(goal.directory).is_absolute());
  const auto settings = config::read_text<OptimizationSettings>(goal.settings, "goal");
  ASSERT_TRUE(settings.ok());
  EXPECT_EQ(settings->validation, 2);
  ASSERT_EQ(workers.batches.size(), 2u);
  EXPECT_NE(workers.batches[0], workers.batches[1]);
}

TEST_F(LoopTest, robust_protocol_gives_the_optimizer_a_pool_and_scenarios_held_out) {
  SyntheticWorkers workers;
  study.settings.protocol = Protocol::robust;
  study.settings.pool.scenarios = 24;
  study.settings.pool.validation = 9;
  ASSERT_TRUE(run_study(study, directory / "run", workers).ok());
  ASSERT_EQ(workers.goals.size(), 1u);
  const auto& goal = workers.goals[0];
  ASSERT_EQ(goal.scenarios.size(), 24u + 9u);
  EXPECT_EQ(goal.estimates.size(), goal.scenarios.size());
  EXPECT_EQ(goal.drawn, 3) << "as many rollouts as on the three training scenarios";
  EXPECT_EQ(goal.held_out, 9);
  EXPECT_NE(goal.scenarios[23].name.find("_pool_"), std::string::npos);
  EXPECT_NE(goal.scenarios[24].name.find("_choice_"), std::string::npos);
}

TEST_F(LoopTest, ends_when_the_rules_no_longer_change) {
  SyntheticWorkers workers;
  study.settings.rounds = 5;
  const auto result = run_study(study, directory / "run", workers);
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_EQ(result->optimizations.size(), 2u) << "the second round cannot improve on certain success";
  EXPECT_NE(result->end.find("no longer change"), std::string::npos);
}

TEST_F(LoopTest, says_so_when_the_action_never_changes_anything) {
  SyntheticWorkers workers;
  study.primitive = study.primitive.with_log_rho({-3, -3});
  const auto result = run_study(study, directory / "run", workers);
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, Code::failed);
  EXPECT_NE(result.error().message.find("grasp"), std::string::npos) << result.error().message;
}

rules::RuleSet one_rule(std::int64_t successes, std::int64_t trials, const std::string& predicate = "on") {
  rules::Rule rule;
  rule.action = {"grasp", {"X"}};
  rule.context = {{predicate, {"X", "Y"}}};
  rule.outcomes = {{static_cast<double>(successes) / static_cast<double>(trials), {{"inhand", {"X"}}}, successes}};
  rule.noise_count = trials - successes;
  rule.noise = 1 - rule.outcomes[0].p;
  return {{rule}, {}};
}

TEST(RulesChanged, only_beyond_the_intervals_or_in_structure) {
  EXPECT_FALSE(rules_changed(one_rule(30, 100), one_rule(30, 100)));
  EXPECT_FALSE(rules_changed(one_rule(30, 100), one_rule(33, 100)));
  EXPECT_TRUE(rules_changed(one_rule(30, 100), one_rule(94, 100)));
  EXPECT_TRUE(rules_changed(one_rule(30, 100), one_rule(30, 100, "near")));
  EXPECT_TRUE(rules_changed(one_rule(30, 100), {}));
  EXPECT_FALSE(rules_changed({}, {}));
}

TEST(DesiredRule, keeps_the_desired_outcome_and_calls_the_rest_noise) {
  rules::Rule rule = one_rule(30, 100).rules[0];
  rule.outcomes.push_back({0.6, {{"upright", {"X"}, true}}, 60});
  rule.noise = 0.1;
  rule.noise_count = 10;
  const auto shown = desired_rule(rule, {{"inhand", {"X"}}});
  ASSERT_EQ(shown.outcomes.size(), 1u);
  EXPECT_EQ(shown.outcomes[0].count, 30);
  EXPECT_DOUBLE_EQ(shown.outcomes[0].p, 0.3);
  EXPECT_DOUBLE_EQ(shown.noise, 0.7);
  EXPECT_EQ(shown.noise_count, 70);
  EXPECT_EQ(desired_rule(rule, {{"flies", {"X"}}}).outcomes[0].count, 60) << "else the most probable change";
}

}  // namespace
}  // namespace primo::study
