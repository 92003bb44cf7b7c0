#include "study/loop.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <optional>
#include <sstream>

#include "core/files.h"
#include "rules/learner.h"
#include "study/codec.h"
#include "study/generalization.h"
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
      executed += rollouts[i].mode == physics::Mode::execute;
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
  int rollouts_done = 0, executed = 0;
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
    study.robot = std::string(PRIMO_SOURCE_DIR) + "/configs/robots/schunk_lwa3_sdh2.yaml";
    study.robot_digest = "0";
    auto loaded = robot::Robot::load(study.robot);
    ASSERT_TRUE(loaded.ok()) << loaded.error().message;
    robot.emplace(std::move(*loaded));
    study.parts.resize(1);
    Part& part = study.parts[0];
    part.name = "grasp";
    part.primitive = test::primitive(2).with_log_rho({1.9, 2.0});  // succeeds in some scenarios only
    for (int k = 0; k < 3; ++k) {
      part.training.push_back(test::scenario("s" + std::to_string(k), 0.75 + 0.05 * k));
      part.training.back().robot_start.assign(robot->home().begin(), robot->home().end());
    }
    part.settings.experience.scenarios = 30;
    part.settings.experience.displacement = 0.05;
    part.settings.optimizer.evaluations = 80;
    part.settings.optimizer.population = 8;
    study.parts[0].settings.executed = 5;
  }
  void TearDown() override { fs::remove_all(directory); }
  std::string result_text(const std::string& name) const { return read_file(directory / name / "result.json").value(); }

  fs::path directory;
  std::optional<robot::Robot> robot;
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
  ASSERT_EQ(result->parts[0].collections.size(), 2u);
  const auto &before = result->parts[0].collections[0], &after = result->parts[0].collections[1];
  EXPECT_LT(before.displaced.desired.value(), 0.9);
  EXPECT_EQ(after.displaced.desired.value(), 1.0);
  const auto* rule = rule_of(after.rules, "grasp");
  ASSERT_NE(rule, nullptr);
  const auto shown = desired_rule(*rule, result->parts[0].optimizations[0].desired);
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
  std::istringstream file(read_file(directory / "run" / "experience-grasp-0.jsonl").value());
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
  EXPECT_TRUE(result->parts[0].collections[0].displaced.on.empty()) << "a grasp is not placed";
  result->parts[0].collections[0].displaced.on = {{"both", 3}, {"paper only", 2}};
  const auto back = result_from_json(to_json(*result));
  ASSERT_TRUE(back.ok()) << back.error().message;
  EXPECT_EQ(back->parts[0].collections[0].displaced.on, result->parts[0].collections[0].displaced.on);
}

TEST_F(LoopTest, ends_with_the_same_bytes_however_often_it_was_stopped) {
  study.parts[0].settings.generalization.levels = {0.02};
  study.parts[0].settings.generalization.scenarios = 15;
  study.parts[0].settings.generalization.executed = 5;
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
  study.parts[0].settings.optimizer.settings.validation = 2;
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
  study.parts[0].settings.protocol = Protocol::robust;
  study.parts[0].settings.pool.scenarios = 24;
  study.parts[0].settings.pool.validation = 9;
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
  study.parts[0].settings.rounds = 5;
  study.parts[0].settings.optimizer.restarts = 3;
  study.parts[0].settings.optimizer.later_restarts = 1;
  const auto result = run_study(study, directory / "run", workers);
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_EQ(result->parts[0].optimizations.size(), 2u) << "the second round cannot improve on certain success";
  EXPECT_NE(result->parts[0].end.find("no longer change"), std::string::npos);
  EXPECT_EQ(workers.goals.at(0).restarts, 3);
  EXPECT_EQ(workers.goals.at(1).restarts, 1);
}

TEST_F(LoopTest, compares_both_primitives_on_held_out_scenarios_of_every_level) {
  SyntheticWorkers workers;
  auto& settings = study.parts[0].settings;
  settings.generalization.levels = {0, 0.05};
  settings.generalization.tables = {0.05};
  settings.generalization.scenarios = 40;
  settings.generalization.executed = 10;
  const auto result = run_study(study, directory / "run", workers);
  ASSERT_TRUE(result.ok()) << result.error().message;
  const auto& levels = result->parts[0].levels;
  ASSERT_EQ(levels.size(), 2u);
  for (const auto& level : levels) {
    EXPECT_EQ(level.strict.trials(), 40);
    EXPECT_EQ(level.executed.trials(), 10);
    EXPECT_EQ(level.before.strict.successes, level.strict.first().successes);
    EXPECT_EQ(level.after.strict.successes, level.strict.second().successes);
    EXPECT_EQ(level.after.strict.successes, 40);
    int failures = 0;
    for (const auto& [cause, example] : level.before.failures) failures += example.count;
    EXPECT_EQ(failures, 40 - level.before.strict.successes) << "every failure has one cause";
  }
  EXPECT_LT(levels[1].before.strict.successes, 40);
  EXPECT_FALSE(levels[0].before.rules);
  ASSERT_TRUE(levels[1].after.rules && levels[1].after.executed_rules);
  EXPECT_EQ(rule_of(*levels[1].after.rules, "grasp")->outcomes[0].count, 40);
  EXPECT_EQ(rule_of(*levels[1].after.executed_rules, "grasp")->outcomes[0].count, 10);
  const auto text = result_text("run");
  const auto back = result_from_json(text);
  ASSERT_TRUE(back.ok()) << back.error().message;
  EXPECT_EQ(to_json(*back), text);
  // No held-out scenario is one of the training's or the experience's.
  const auto held_out = held_out_scenario(*robot, study.parts[0], 1, 0);
  const auto experience = draw_displaced(*robot, study.parts[0].training, 0.02, settings.experience.seed, 0, 1, "_");
  ASSERT_TRUE(held_out.ok() && experience.ok());
  EXPECT_NE(held_out->objects[0].position, experience->scenarios[0].objects[0].position);
}

TEST_F(LoopTest, parts_are_done_one_after_the_other_and_answers_are_shared) {
  SyntheticWorkers alone, both;
  ASSERT_TRUE(run_study(study, directory / "alone", alone).ok());
  study.parts.push_back(study.parts[0]);
  study.parts[1].name = "again";
  const auto result = run_study(study, directory / "both", both);
  ASSERT_TRUE(result.ok()) << result.error().message;
  ASSERT_EQ(result->parts.size(), 2u);
  EXPECT_EQ(result->parts[1].name, "again");
  EXPECT_EQ(both.rollouts_done, alone.rollouts_done) << "the same question is never asked twice";
  EXPECT_EQ(result->parts[0].collections[1].training.gamma, result->parts[1].collections[1].training.gamma);
  EXPECT_TRUE(fs::exists(directory / "both" / "experience-again-1.jsonl"));
}

TEST_F(LoopTest, another_structure_is_searched_in_place_of_p_which_stays_what_is_compared_with) {
  SyntheticWorkers workers;
  study.parts[0].structure = test::primitive(3);
  study.parts[0].structure->name = "other";
  const auto result = run_study(study, directory / "run", workers);
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_EQ(workers.goals.at(0).primitive.name, "other");
  const auto& collections = result->parts[0].collections;
  EXPECT_EQ(collections[0].primitive.tasks.size(), 2u);
  EXPECT_EQ(collections[1].primitive.tasks.size(), 3u);
  const auto pairs = paired_entries(collections[0].primitive, collections[1].primitive);
  ASSERT_EQ(pairs.size(), 3u);
  EXPECT_TRUE(pairs[1].before && pairs[1].after);
  EXPECT_FALSE(pairs[2].before);
  study.parts[0].structure->action = "place";
  EXPECT_FALSE(study.validate().ok());
}

TEST_F(LoopTest, rules_are_learned_from_executed_motions_where_the_study_says_so) {
  SyntheticWorkers workers;
  study.parts[0].settings.experience.mode = physics::Mode::execute;
  const auto result = run_study(study, directory / "run", workers);
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_EQ(workers.executed, 2 * 30) << "every displaced scenario, with P and with P*";
}

TEST_F(LoopTest, says_so_when_the_action_never_changes_anything) {
  SyntheticWorkers workers;
  study.parts[0].primitive = study.parts[0].primitive.with_log_rho({-3, -3});
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
