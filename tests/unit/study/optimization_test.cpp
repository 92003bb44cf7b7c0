#include "study/optimization.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <set>

#include "study/codec.h"
#include "synthetic.h"

namespace primo::study {
namespace {

namespace fs = std::filesystem;

class OptimizationTest : public ::testing::Test {
 protected:
  void SetUp() override {
    directory = fs::temp_directory_path() / ("primo_optimization_" + std::to_string(::getpid()) + "_" +
                                             ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(directory);
    fs::create_directories(directory);
    goal.study = "test-0";
    goal.primitive = test::primitive(3);
    for (int k = 0; k < 4; ++k) {
      goal.scenarios.push_back(test::scenario("s" + std::to_string(k), 0.8 + 0.01 * k));
      goal.estimates.push_back(test::estimate(goal.scenarios.back()));
    }
    goal.desired = test::grasped();
    goal.optimizer.evaluations = 200;
    goal.optimizer.population = 10;
    goal.algorithms = {"cma"};
    goal.seed = 5;
  }
  void TearDown() override { fs::remove_all(directory); }
  Journal journal(const std::string& name = "journal.db") {
    auto opened = Journal::open(directory / name);
    EXPECT_TRUE(opened.ok()) << opened.error().message;
    return std::move(*opened);
  }
  static RolloutResult roll(const Rollout& rollout) { return test::bowl(rollout); }

  fs::path directory;
  OptimizeGoal goal;
};

TEST_F(OptimizationTest, cma_finds_precisions_that_succeed_everywhere) {
  test::FunctionEvaluator evaluator(roll);
  auto record = journal();
  const auto result = optimize(goal, evaluator, record);
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_EQ(result->success.value(), 1.0);
  EXPECT_EQ(result->success.trials, 4 * 3);
  EXPECT_EQ(result->evaluations, 200);
  for (const double x : result->primitive.log_rho()) EXPECT_NEAR(x, 3.0, 0.3);
  EXPECT_EQ(result->primitive.name, "grasp_optimized_1");
}

TEST_F(OptimizationTest, gives_the_same_bytes_whatever_the_order_of_answers) {
  goal.algorithms = {"cma", "monte_carlo"};
  goal.restarts = 2;
  goal.optimizer.evaluations = 60;
  test::FunctionEvaluator forward(roll), backward(roll);
  backward.reverse = true;
  auto one = journal("one.db"), two = journal("two.db");
  const auto a = optimize(goal, forward, one), b = optimize(goal, backward, two);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(encode(*a), encode(*b));
  EXPECT_EQ(a->evaluations, 4 * 60);
}

TEST_F(OptimizationTest, goes_on_after_being_stopped_anywhere_and_ends_with_the_same_bytes) {
  goal.optimizer.evaluations = 60;
  test::FunctionEvaluator undisturbed(roll);
  auto whole = journal("whole.db");
  const auto expected = optimize(goal, undisturbed, whole);
  ASSERT_TRUE(expected.ok());
  int calls = 0, runs = 0;
  while (true) {
    auto record = journal("parts.db");
    test::FunctionEvaluator evaluator(roll);
    evaluator.fail_after = 37;
    const auto result = optimize(goal, evaluator, record);
    calls += evaluator.calls;
    ++runs;
    ASSERT_LT(runs, 100);
    if (!result.ok()) {
      ASSERT_EQ(result.error().code, Code::unavailable);
      continue;
    }
    EXPECT_EQ(encode(*result), encode(*expected));
    EXPECT_EQ(encode(*result), encode(*optimize(goal, evaluator, record)));
    break;
  }
  EXPECT_GT(runs, 5);
  EXPECT_EQ(calls, undisturbed.calls) << "nothing is done twice";
  auto parts = journal("parts.db");
  EXPECT_EQ(parts.evaluations()->size(), whole.evaluations()->size());
}

TEST_F(OptimizationTest, uses_common_random_numbers_within_a_generation_and_fresh_ones_to_choose) {
  goal.optimizer.evaluations = 40;
  std::map<std::string, std::set<std::uint64_t>> seeds;  // by scenario
  std::vector<std::uint64_t> order;
  test::FunctionEvaluator evaluator(roll);
  evaluator.on_rollout = [&](const Rollout& r) {
    seeds[r.scenario.name].insert(r.judge_seed);
    if (r.scenario.name == "s0") order.push_back(r.judge_seed);
  };
  auto record = journal();
  ASSERT_TRUE(optimize(goal, evaluator, record).ok());
  for (const auto& [name, set] : seeds) EXPECT_EQ(set.size(), 4u + 3u) << "four generations and three validation seeds";
  for (std::size_t i = 0; i < 40; ++i) EXPECT_EQ(order[i], order[i / 10 * 10]);
  std::set<std::uint64_t> all;
  for (const auto& [name, set] : seeds) all.insert(set.begin(), set.end());
  EXPECT_EQ(all.size(), 4u * 7u) << "no two scenarios share a seed";
}

TEST_F(OptimizationTest, keeps_the_primitive_it_began_with_when_nothing_better_is_found) {
  goal.primitive = goal.primitive.with_log_rho({3, 3, 3});
  goal.optimizer.evaluations = 10;
  goal.algorithms = {"monte_carlo"};
  test::FunctionEvaluator evaluator(roll);
  auto record = journal();
  const auto result = optimize(goal, evaluator, record);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->primitive.name, "test");
  const auto finalists = record.finalists();
  ASSERT_TRUE(finalists.ok());
  int chosen = 0;
  for (const auto& f : *finalists) {
    chosen += f.chosen;
    if (f.chosen) {
      EXPECT_EQ(f.kind, "start");
    }
    EXPECT_LE(f.gamma, result->gamma);
  }
  EXPECT_EQ(chosen, 1);
}

TEST_F(OptimizationTest, stops_early_only_when_told_and_when_the_recommendation_succeeds) {
  goal.optimizer.evaluations = 400;
  OptimizationSettings settings;
  settings.early_stop.generations = 4;
  settings.early_stop.tolerance = 0.02;
  goal.settings = config::dump(settings);
  test::FunctionEvaluator evaluator(roll);
  auto record = journal();
  std::vector<Progress> seen;
  const auto result = optimize(goal, evaluator, record, [&](const Progress& p) { seen.push_back(p); });
  ASSERT_TRUE(result.ok());
  EXPECT_LT(result->evaluations, 400);
  EXPECT_EQ(result->success.value(), 1.0);
  ASSERT_FALSE(seen.empty());
  EXPECT_TRUE(seen.back().finished);
  EXPECT_EQ(seen.back().done, result->evaluations);
  for (std::size_t i = 1; i < seen.size(); ++i) EXPECT_GE(seen[i].best_gamma, seen[i - 1].best_gamma);

  // Nothing ever succeeds: no early end, however flat γ is.
  test::FunctionEvaluator hopeless([](const Rollout& r) { return test::bowl(r, 3.0, 0.0); });
  auto other = journal("other.db");
  goal.optimizer.evaluations = 100;
  const auto none = optimize(goal, hopeless, other);
  ASSERT_TRUE(none.ok());
  EXPECT_EQ(none->evaluations, 100);
}

TEST_F(OptimizationTest, tells_the_course_of_the_learning_curve) {
  test::FunctionEvaluator evaluator(roll);
  auto record = journal();
  ASSERT_TRUE(optimize(goal, evaluator, record).ok());
  const auto course = record.evaluations();
  ASSERT_TRUE(course.ok());
  ASSERT_EQ(course->size(), 200u);
  for (const auto& e : *course) {
    EXPECT_EQ(e.scenarios, 4);
    EXPECT_GE(e.final_pose, e.successes);
    // γ by hand, from the bowl and the settings' defaults.
    double g = 0;
    int successes = 0;
    for (const auto& s : goal.scenarios) {
      double square = 0;
      for (const double x : e.x) square += (x - 3) * (x - 3);
      const double distance = std::sqrt(square) + std::abs((s.objects[0].position.x() - 0.8) * 10);
      const bool success = distance < 2;
      successes += success;
      g += (0.5 * success + 0.5 / (1 + distance) + 0.6) / 4;
    }
    EXPECT_EQ(e.successes, successes);
    EXPECT_NEAR(e.gamma, g, 1e-9);
  }
}

TEST_F(OptimizationTest, refuses_goals_that_cannot_be_run) {
  test::FunctionEvaluator evaluator(roll);
  auto record = journal();
  const auto refused = [&](auto change, const std::string& word) {
    OptimizeGoal wrong = goal;
    change(wrong);
    const auto result = optimize(wrong, evaluator, record);
    ASSERT_FALSE(result.ok()) << word;
    EXPECT_NE(result.error().message.find(word), std::string::npos) << result.error().message;
  };
  refused([](OptimizeGoal& g) { g.scenarios.clear(); }, "scenarios");
  refused([](OptimizeGoal& g) { g.estimates.pop_back(); }, "estimates");
  refused([](OptimizeGoal& g) { g.algorithms = {}; }, "cma");
  refused([](OptimizeGoal& g) { g.algorithms = {"simplex"}; }, "simplex");
  refused([](OptimizeGoal& g) { g.restarts = 0; }, "restarts");
  refused([](OptimizeGoal& g) { g.desired = {}; }, "desired");
  refused([](OptimizeGoal& g) { g.settings = "fitnes: {}"; }, "fitness");
  refused(
      [](OptimizeGoal& g) {
        for (auto& task : g.primitive.tasks) task.optimize = false;
      },
      "precision");
}

TEST_F(OptimizationTest, says_why_when_the_planner_refuses) {
  test::FunctionEvaluator evaluator([](const Rollout&) {
    RolloutResult result;
    result.plan_reason = "unknown task variable 'positon'";
    return result;
  });
  auto record = journal();
  const auto result = optimize(goal, evaluator, record);
  ASSERT_FALSE(result.ok());
  EXPECT_NE(result.error().message.find("positon"), std::string::npos);
}

}  // namespace
}  // namespace primo::study
